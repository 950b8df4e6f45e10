import { describe, expect, it } from "vitest";

import { byRun, kindEntries, lineEntry, markEntry, ofManyRuns, runEntries, type Entry } from "./entries";
import { styledPanel } from "./styled";
import { lineOf, markOf, panelOf } from "./testing";

const line = lineOf({ x: [0, 1, 2], y: [0, 1e-9, null] });
const band = { ...line, lower: [0, 0, 0], upper: [1, 1, 1] };
const panel = panelOf({ lines: [line, band], marks: [markOf({ y: 33.157, half_width: 0.5812, value: "33.16 ± 0.30 µm (± u)" })] });
const styled = styledPanel(panel, "role", (variable) => variable);
const reading = { at: null, view: { from: 0, to: 2 }, unit: 1 };
const entryNamed = (name: string): Entry => ({ ...lineEntry(styled.lines[0]!, true, reading), name });

describe("byRun", () => {
  const namesIn = (...named: [run: string, name: string][]) =>
    byRun(named.map(([run, name]) => ({ run, entry: entryNamed(name) }))).map(({ run, entries }) => [
      run,
      ...entries.map(({ name }) => name),
    ]);

  it("puts the entries of a run together, in the order they come", () => {
    expect(namesIn(["b", "x"], ["a", "y"], ["b", "z"])).toEqual([
      ["b", "x", "z"],
      ["a", "y"],
    ]);
  });

  it("drops the run from names, but only the whole of it", () => {
    expect(namesIn(["200mN", "200mN, measured"], ["200mN", "200mN: fit"])).toEqual([["200mN", "measured", "fit"]]);
    expect(namesIn(["200", "200mN, measured"], ["", ", x"])).toEqual([
      ["200", "200mN, measured"],
      ["", ", x"],
    ]);
    expect(namesIn(["a", "a"])).toEqual([["a", "a"]]);
  });
});

describe("ofManyRuns", () => {
  const of = (...runs: string[]) => ofManyRuns({ panels: [panelOf({ lines: runs.map((run) => lineOf({ run })) })] });

  it("asks for four runs, and for nothing that belongs to none", () => {
    expect([of("a", "b", "c"), of("a", "b", "c", "d"), of("a", "b", "c", "d", ""), of()]).toEqual([
      false,
      true,
      false,
      false,
    ]);
  });
});

describe("lineEntry", () => {
  const valueAt = (at: number | null, unit = 1) => lineEntry(styled.lines[0]!, true, { ...reading, at, unit }).value;

  it("reads the sample nearest to the pointer, in the axis's unit", () => {
    expect(valueAt(0.9)).toBe("1×10⁻⁹");
    expect(valueAt(0.9, 1e-9)).toBe("1");
    expect([valueAt(null), valueAt(50)]).toEqual(["", ""]);
  });

  it("is a band where the line has one", () => {
    expect(styled.lines.map((one) => lineEntry(one, true, reading).kind)).toEqual(["line", "band"]);
  });
});

describe("markEntry", () => {
  it("reads the value with its standard uncertainty, not with half its interval", () => {
    expect(markEntry(styled.marks[0]!, true).value).toBe("33.16 ± 0.30 µm (± u)");
  });
});

describe("styledPanel", () => {
  it("names every line and mark by a key of its own", () => {
    const keys = [...styled.lines, ...styled.marks].map(({ key }) => key);
    expect(new Set(keys).size).toBe(3);
  });
});

describe("entries of several runs", () => {
  const fit = { ...line, role: "fit" as const };
  const runs = panelOf({
    lines: [
      { ...line, name: "a: wear", run: "a" },
      { ...fit, name: "a: Archard, fitted", run: "a" },
      { ...fit, name: "b: Archard, fitted", run: "b" },
    ],
    marks: [markOf({ name: "c: end", run: "c", value: "1 µm" })],
  });
  const several = styledPanel(runs, { runs: ["a", "b", "c"] }, (variable) => variable);

  it("are one per run, with the first value that is there", () => {
    const entries = runEntries(several, new Set(["b"]), { ...reading, at: 1, unit: 1e-9 });
    expect(entries.map(({ key, value, shown }) => [key, value, shown])).toEqual([
      ["a", "1", true],
      ["b", "1", false],
      ["c", "", true],
    ]);
    expect(new Set(entries.map(({ stroke }) => stroke.colour)).size).toBe(3);
  });

  it("are told once per kind of line, in one color", () => {
    const kinds = kindEntries([several]);
    expect(kinds.map(({ name, kind }) => [name, kind])).toEqual([
      ["wear", "line"],
      ["Archard, fitted", "line"],
      ["end", "mark"],
    ]);
    expect(new Set(kinds.map(({ stroke }) => stroke.colour))).toEqual(new Set(["--ink"]));
  });
});
