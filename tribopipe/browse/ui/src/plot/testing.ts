import type { Line, Mark, Panel, Plot } from "../api";

/** Lines, marks, panels and plots for tests: what a test does not name is empty or usual. */
export function lineOf(given: Partial<Line> = {}): Line {
  const usual = {
    name: "wear",
    run: "",
    role: "measured",
    law: null,
    x: [],
    y: [],
    lower: null,
    upper: null,
    path: null,
  };
  return { ...(usual as Line), ...given };
}

export const markOf = (given: Partial<Mark> = {}): Mark => ({
  name: "end",
  run: "",
  x: 0,
  y: 0,
  half_width: 0,
  value: "",
  ...given,
});

export const panelOf = (given: Partial<Panel> = {}): Panel => ({ label: "wear / µm", lines: [], marks: [], ...given });

export function plotOf(given: Partial<Plot> = {}): Plot {
  const x = { name: "time", label: "time / s", from: 0, to: 100 };
  return { name: "wear", title: "Wear", words: "", x, panels: [], samples: 0, points: 0, ...given };
}
