import fc from "fast-check";
import { describe, expect, it } from "vitest";

import type { Cell, Column, Runs } from "../api";
import { chosenColumns, headed, matching, rowsOf, sorted, sortOf, sortText } from "./listing";

const runsOf = (columns: string[], rows: Record<string, Cell[]>): Runs => ({
  revision: "1",
  total: Object.keys(rows).length,
  start: 0,
  ids: Object.keys(rows),
  columns,
  rows: Object.values(rows),
  aligned: {},
});

const columnNamed = (name: string, shown = true): Column => ({
  name,
  shown,
  label: name,
  unit: "",
  help: "",
  kind: "text",
});

const rows = rowsOf(
  runsOf(["pin", "k_d", "medium"], {
    "run-10": ["Si3N4", [2e-9, "2.0"], "dry air"],
    "run-9": [null, [1e-8, "10.0"], ""],
    "run-1": ["100Cr6", null, "oil"],
    Run_b: ["", [-1e-9, "−1.0"], null],
  }),
);

const idsBy = (text: string) => sorted(rows, sortOf(text)).map(({ id }) => id);

describe("rowsOf", () => {
  it("finds a cell by the name of its column; nothing is known of any other", () => {
    expect(rows.map((row) => row.cell("medium"))).toEqual(["dry air", "", "oil", null]);
    expect(rows[0]!.cell("colour")).toBeNull();
  });
});

describe("headed", () => {
  const runs = {
    ...runsOf(["k_d"], { a: [[2e-15, "(2.0 ± 0.1)×10⁻⁹", 1e-16]], b: [null] }),
    aligned: { k_d: { unit: "10⁻⁹ mm³/(N·mm)", texts: ["2.00 ± 0.10", ""] } },
  };

  it("puts one power of ten in the unit of a column, and shows its numbers under it", () => {
    expect(headed([columnNamed("k_d")], runs)[0]!.unit).toBe("10⁻⁹ mm³/(N·mm)");
    expect(rowsOf(runs).map((row) => row.shown("k_d"))).toEqual(["2.00 ± 0.10", ""]);
    expect(rowsOf(runs)[0]!.cell("k_d")).toEqual([2e-15, "(2.0 ± 0.1)×10⁻⁹", 1e-16]);
  });
});

describe("chosenColumns", () => {
  const columns = ["id", "pin", "k_d", "medium", "operator"].map((name) => columnNamed(name, name !== "medium"));
  const names = (named: string | null) => chosenColumns(columns, named, rows).map(({ name }) => name);

  it("are the usual ones in which anything is known", () => {
    expect(names(null)).toEqual(["pin", "k_d"]);
  });

  it("are those of the address in the archive's order, the unknown left out, the id never twice", () => {
    expect(names("medium,pin,colour,id")).toEqual(["pin", "medium"]);
    expect(names("operator")).toEqual(["operator"]);
    expect(names("")).toEqual([]);
  });
});

describe("matching", () => {
  const columns = [columnNamed("pin"), columnNamed("k_d")];
  const found = (search: string) => matching(rows, columns, search).map(({ id }) => id);

  it("needs every word, in any case and order, in the id or a shown column", () => {
    expect(found("si3n4 RUN")).toEqual(["run-10"]);
    expect(found("run-1")).toEqual(["run-10", "run-1"]);
    expect(found("10.0")).toEqual(["run-9"]);
    expect(found("oil")).toEqual([]);
  });

  it("leaves all rows where there are no words", () => {
    expect(matching(rows, columns, " \t ")).toBe(rows);
  });

  it("takes signs for themselves", () => {
    expect([found(".*"), found("[")]).toEqual([[], []]);
  });
});

describe("sorted", () => {
  it("puts numbers by size and the unknown last, whichever way round", () => {
    expect(idsBy("k_d")).toEqual(["Run_b", "run-10", "run-9", "run-1"]);
    expect(idsBy("-k_d")).toEqual(["run-9", "run-10", "Run_b", "run-1"]);
  });

  it("puts empty texts last, too, and keeps their order", () => {
    expect(idsBy("pin")).toEqual(["run-1", "run-10", "run-9", "Run_b"]);
    expect(idsBy("-pin")).toEqual(["run-10", "run-1", "run-9", "Run_b"]);
  });

  it("puts ids as people count", () => {
    const [low, middle, high] = ["run-1", "run-9", "run-10"].map((id) => idsBy("id").indexOf(id));
    expect(low).toBeLessThan(middle!);
    expect(middle).toBeLessThan(high!);
  });

  it("leaves the rows that it was given as they were", () => {
    const before = [...rows];
    sorted(rows, sortOf("-k_d"));
    expect(rows).toEqual(before);
  });
});

describe("sort in the address", () => {
  it("is read as it is written", () => {
    const sorts = fc.record({ column: fc.stringMatching(/^[a-z][a-z_0-9]*$/), descending: fc.boolean() });
    fc.assert(
      fc.property(sorts, (sort) => {
        expect(sortOf(sortText(sort))).toEqual(sort);
      }),
      { seed: 7 },
    );
  });

  it("is by id where it says nothing", () => {
    expect([sortOf(null), sortOf("")]).toEqual([
      { column: "id", descending: false },
      { column: "id", descending: false },
    ]);
    expect(sortOf("-")).toEqual({ column: "id", descending: true });
  });
});
