import type { Line, Panel, Plot } from "../api";
import { seriesVariable } from "../components/series";
import type { Shape } from "./shapes";
import { shapeOf } from "./shapes";

/** How a line or a mark is drawn, on the canvas and in the legend. */
export interface Stroke {
  /** CSS variable. */
  colour: string;
  /** In CSS pixels. */
  width: number;
  dash: number[];
  /** Below 1 where what lies over it, in the same colour, is to be seen. */
  alpha: number;
  /** What tells it from others of its kind where colours do not. */
  shape: Shape | null;
}

/** What colours tell apart: kinds of lines and laws; or runs, each by its place in a list. */
export type Colouring = "role" | { runs: string[] };

const LAWS = { archard: "--series-1", sarkar: "--series-5" } as const;
const MEASURED = ["--plot-measured", "--series-1", "--series-3", "--series-4", "--series-6"];
const MODELLED = ["--series-1", "--series-2", "--series-3", "--series-4", "--series-6"];
const FAINT = 0.55;
const LIGHT = 0.75;
const WIDTHS = { measured: 1, fit: 2, prediction: 2, drift: 1.75, wander: 1.5, residual: 1 };
/** What a run has beside wear has a colour of its own, too. */
const BESIDE: Partial<Record<Line["role"], string>> = { drift: "--series-5", wander: "--series-3" };
/** Dashes tell laws apart, too. */
const SARKAR_DASHES = { fit: [12, 3], prediction: [9, 4, 2, 4] };
const DASHES = { measured: [], fit: [], prediction: [8, 5], drift: [6, 4], wander: [], residual: [] };

/** Runs tell lines apart as soon as there are several. */
export function colouringOf(plot: Plot, by: "role" | "run" | undefined, runs: string[] | undefined): Colouring {
  const all = plot.panels.flatMap(({ lines, marks }) => [...lines, ...marks]).map(({ run }) => run);
  const several = [...new Set(all)].filter((run) => run !== "");
  return (by ?? (several.length > 1 ? "run" : "role")) === "run" ? { runs: runs ?? several } : "role";
}

/** How the lines of a panel are drawn, in their order. */
export function lineStrokes({ lines }: Panel, colouring: Colouring): Stroke[] {
  return lines.map((line, place) => {
    const before = lines.slice(0, place);
    const width = WIDTHS[line.role];
    const dash = dashOf(line);
    const byRoles = colouring === "role" || line.run === "";
    const alpha = line.role === "wander" ? LIGHT : line.role === "measured" && !byRoles ? FAINT : 1;
    if (byRoles) return { width, dash, alpha, ...byRole(line, before) };
    return { width, dash, alpha, ...byRun(line.run, colouring.runs) };
  });
}

function dashOf({ role, law }: Line): number[] {
  return law === "sarkar" && (role === "fit" || role === "prediction") ? SARKAR_DASHES[role] : DASHES[role];
}

/** How the marks of a panel are drawn, in their order. */
export function markStrokes({ marks }: Panel, colouring: Colouring): Stroke[] {
  return marks.map(({ run }, place) => ({
    width: 1.5,
    dash: [],
    alpha: 1,
    ...(colouring === "role" ? { colour: "--ink", shape: shapeOf(place + 1) } : byRun(run, colouring.runs)),
  }));
}

function byRun(run: string, runs: string[]): Pick<Stroke, "colour" | "shape"> {
  const place = Math.max(runs.indexOf(run), 0);
  return { colour: seriesVariable(place), shape: shapeOf(place) };
}

/**
 * A law has its colour; others take the next of their kind. From the third of a kind on lines have figures, too; not the
 * second, as figures on a curve look like points that were measured.
 */
function byRole(line: Line, before: Line[]): Pick<Stroke, "colour" | "shape"> {
  const alike = before.filter(({ role, run }) => role === line.role && run === line.run).length;
  const unlawful = before.filter(({ role, law }) => role !== "measured" && !(role in BESIDE) && law === null).length;
  return { colour: roleColour(line, alike, unlawful), shape: shapeOf(Math.max(alike - 1, 0)) };
}

function roleColour({ role, law }: Line, alike: number, unlawful: number): string {
  if (law !== null) return LAWS[law];
  if (BESIDE[role]) return BESIDE[role];
  if (role === "residual" || role === "measured") return MEASURED[alike % MEASURED.length]!;
  return MODELLED[unlawful % MODELLED.length]!;
}
