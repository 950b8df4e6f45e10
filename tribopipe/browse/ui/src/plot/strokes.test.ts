import { describe, expect, it } from "vitest";

import type { Line } from "../api";
import { colouringOf, lineStrokes, markStrokes } from "./strokes";
import { lineOf, markOf, panelOf, plotOf } from "./testing";

const panelWith = (...lines: Partial<Line>[]) => panelOf({ lines: lines.map(lineOf) });
const plotWith = (...runs: string[]) => plotOf({ panels: [panelWith(...runs.map((run) => ({ run })))] });

describe("colouringOf", () => {
  it("tells runs apart as soon as there are several, in the order they come", () => {
    expect(colouringOf(plotWith("b", "a", "b", ""), undefined, undefined)).toEqual({ runs: ["b", "a"] });
    expect(colouringOf(plotWith("a", "a", ""), undefined, undefined)).toBe("role");
  });

  it("keeps to what is asked for: one way, or the places of a list", () => {
    expect(colouringOf(plotWith("a", "b"), "role", undefined)).toBe("role");
    expect(colouringOf(plotWith("b"), "run", ["a", "b"])).toEqual({ runs: ["a", "b"] });
  });
});

describe("lineStrokes", () => {
  it("gives each law its colour and dashes, wherever it stands", () => {
    const [archard, sarkar] = lineStrokes(
      panelWith({ role: "fit", law: "archard" }, { role: "fit", law: "sarkar" }),
      "role",
    );
    const [alone] = lineStrokes(panelWith({ role: "fit", law: "sarkar" }), "role");
    expect(archard!.colour).not.toBe(sarkar!.colour);
    expect(archard!.dash).not.toEqual(sarkar!.dash);
    expect(alone!.colour).toBe(sarkar!.colour);
  });

  it("draws a prediction dashed and a fit of Archard's law solid", () => {
    const [fit, prediction] = lineStrokes(panelWith({ role: "fit" }, { role: "prediction" }), "role");
    expect(fit!.dash).toEqual([]);
    expect(prediction!.dash).not.toEqual([]);
  });

  it("draws what is slow and neither wear nor drift faint, in a colour that nothing beside it has", () => {
    const lines = panelWith({ name: "reading" }, { role: "drift" }, { name: "wear" }, { role: "wander" });
    const strokes = lineStrokes(lines, "role");
    expect(strokes.map(({ alpha }) => alpha < 1)).toEqual([false, false, false, true]);
    expect(new Set(strokes.map(({ colour }) => colour)).size).toBe(4);
  });

  it("lets no two of several measured lines of a run look the same", () => {
    const strokes = lineStrokes(panelWith(...Array.from({ length: 7 }, () => ({}))), "role");
    expect(new Set(strokes.map(({ colour, shape }) => `${colour} ${shape}`)).size).toBe(7);
    expect(strokes.slice(0, 2).map(({ shape }) => shape)).toEqual([null, null]);
  });

  it("gives all lines of a run its colour, measured ones faint", () => {
    const lines = panelWith({ run: "a" }, { run: "b" }, { run: "b", role: "fit", law: "archard" });
    const [a, b, fit] = lineStrokes(lines, { runs: ["a", "b"] });
    expect([a!.colour, b!.colour, fit!.colour]).toEqual(["--series-1", "--series-2", "--series-2"]);
    expect(b!.alpha).toBeLessThan(1);
    expect(fit!.alpha).toBe(1);
  });

  it("lets no two of sixteen runs look the same", () => {
    const runs = Array.from({ length: 16 }, (_, place) => `run-${place}`);
    const strokes = lineStrokes(panelWith(...runs.map((run) => ({ run }))), { runs });
    expect(new Set(strokes.map(({ colour, shape }) => `${colour} ${shape}`)).size).toBe(16);
  });
});

describe("markStrokes", () => {
  it("tells marks apart by figures, or by their runs' colours", () => {
    const panel = panelOf({ marks: [markOf({ run: "a" }), markOf({ run: "b" })] });
    const [one, other] = markStrokes(panel, "role");
    expect(one!.shape).not.toBe(other!.shape);
    expect(markStrokes(panel, { runs: ["b", "a"] }).map(({ colour }) => colour)).toEqual(["--series-2", "--series-1"]);
  });
});
