import type { Line, Mark } from "../api";
import { nearest } from "./nearest";
import { read } from "./numbers";
import type { Styled } from "./styled";
import type { Stroke } from "./strokes";
import type { View } from "./view";

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

/** A mark with its value and standard uncertainty. */
export const markEntry = ({ key, thing, stroke }: Styled<Mark>, shown: boolean): Entry => ({
  key,
  name: thing.name,
  stroke,
  kind: "mark",
  value: thing.value,
  shown,
});
