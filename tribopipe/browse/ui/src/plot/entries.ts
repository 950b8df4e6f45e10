import type { Line, Mark, Plot } from "../api";
import { nearest } from "./nearest";
import { read } from "./numbers";
import type { Styled, StyledPanel } from "./styled";
import type { Stroke } from "./strokes";
import { ANYWHERE, type View } from "./view";

/** A line or mark in the legend. */
export interface Entry {
  key: string;
  name: string;
  stroke: Stroke;
  kind: "line" | "band" | "mark";
  /** Value to read; empty where there is none. */
  value: string;
  shown: boolean;
}

/** What belongs to one run; "" for what belongs to none, or where there is no need to say. */
export interface Group {
  run: string;
  entries: Entry[];
}

/** Put entries of the same run together, in the order they come; each drops the run from its name. */
export function byRun(all: { run: string; entry: Entry }[]): Group[] {
  const groups = new Map<string, Entry[]>();
  for (const { run, entry } of all) {
    groups.set(run, [...(groups.get(run) ?? []), { ...entry, name: withoutRun(entry.name, run) }]);
  }
  return [...groups].map(([run, entries]) => ({ run, entries }));
}

/** "200mN, measured" and "200mN: measured" as "measured" */
function withoutRun(name: string, run: string): string {
  const rest = run && name.startsWith(run) ? name.slice(run.length) : "";
  return /^[,:] ./.test(rest) ? rest.slice(2) : name;
}

/** What values are read against. */
export interface Reading {
  /** Place on the horizontal axis, if any. */
  at: number | null;
  view: View;
  /** What the values are divided by, as the axis says. */
  unit: number;
}

/** A line with its value at the place that is read. */
export function lineEntry({ key, thing, stroke }: Styled<Line>, shown: boolean, { at, view, unit }: Reading): Entry {
  const value = at === null ? null : thing.y[nearest(thing, at, view)];
  const kind = thing.lower && thing.upper ? "band" : "line";
  return { key, name: thing.name, stroke, kind, value: value == null ? "" : read(value / unit), shown };
}

/** One entry per run, which stands for all its lines and marks: its color, figure, and first value to read. */
export function runEntries({ lines, marks }: StyledPanel, hidden: ReadonlySet<string>, reading: Reading): Entry[] {
  const runs = new Set([...lines, ...marks].map(({ thing }) => thing.run));
  return [...runs].map((run) => {
    const shown = !hidden.has(run);
    const own = lines.filter(({ thing }) => thing.run === run);
    const value = own.map((line) => lineEntry(line, shown, reading).value).find((text) => text !== "") ?? "";
    const { colour, shape } = (own[0] ?? marks.find(({ thing }) => thing.run === run))!.stroke;
    return { key: run, name: run, stroke: { colour, shape, width: 2, dash: [], alpha: 1 }, kind: "line", value, shown };
  });
}

/** From this number of runs on, a legend with one entry per line takes more space than the plot. */
const MANY = 4;

/** Whether a plot shows many runs, and nothing else. */
export function ofManyRuns({ panels }: Pick<Plot, "panels">): boolean {
  const runs = new Set(panels.flatMap(({ lines, marks }) => [...lines, ...marks].map(({ run }) => run)));
  return runs.size >= MANY && !runs.has("");
}

/** What each kind of line and mark of several runs is, in one color for all: "Archard, fitted". */
export function kindEntries(panels: StyledPanel[]): Entry[] {
  const found = new Map<string, Entry>();
  const reading = { at: null, view: ANYWHERE, unit: 1 };
  for (const { lines, marks } of panels) {
    const all = [
      ...lines.map((line) => ({ run: line.thing.run, entry: lineEntry(line, true, reading) })),
      ...marks.map((mark) => ({ run: mark.thing.run, entry: { ...markEntry(mark, true), value: "" } })),
    ];
    for (const { run, entry } of all) {
      const name = withoutRun(entry.name, run);
      const stroke = { ...entry.stroke, colour: "--ink", shape: null };
      if (!found.has(name)) found.set(name, { ...entry, key: name, name, stroke });
    }
  }
  return [...found.values()];
}

/** A mark with its value and standard uncertainty. */
export const markEntry = ({ key, thing, stroke }: Styled<Mark>, shown: boolean): Entry => ({
  key,
  name: thing.name,
  stroke,
  kind: "mark",
  value: thing.value,
  shown,
});
