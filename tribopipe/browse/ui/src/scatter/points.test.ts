import { describe, expect, it } from "vitest";

import type { Cell, Column } from "../api";
import type { Row } from "../table/listing";
import { coordinate, grouped, materialPair, missing, quantities, quantityLabel, replicateMeans } from "./points";

const rowOf = (id: string, cells: Record<string, Cell>): Row => ({ id, cell: (name) => cells[name] ?? null, shown: () => "" });

const number = (name: string, unit = "", factor = 1, offset = 0): Column => ({
  name,
  label: name,
  unit,
  help: "",
  kind: "number",
  shown: true,
  factor,
  offset,
});

const LOAD = number("load", "mN", 1000);
const FRICTION = number("friction");
const steel = { pin_material: "Si3N4", disc_material: "steel" };
const ROWS = [
  rowOf("c", { ...steel, load: [0.4, "400"], friction: [0.5, "0.5"] }),
  rowOf("a", { ...steel, load: [0.2, "200.0 ± 2.0", 0.002], friction: [0.4, "0.4"] }),
  rowOf("b", { ...steel, load: [0.2, "200.0 ± 2.0", 0.002], friction: [0.6, "0.6"] }),
  rowOf("d", { curved_disc_material: "WC-Co", load: [0.2, "200"], friction: [0.1, "0.1"], mark: "bad" }),
  rowOf("e", { load: [0.2, "200"] }),
];

describe("coordinate", () => {
  it("is in the unit of the column, with its uncertainty where there is one", () => {
    expect(coordinate(ROWS[1]!, LOAD)).toEqual({ value: 200, text: "200.0 ± 2.0", u: 2 });
    expect(coordinate(ROWS[0]!, LOAD)).toEqual({ value: 400, text: "400", u: null });
    expect(coordinate(ROWS[4]!, FRICTION)).toBeNull();
  });

  it("moves temperatures, but not their uncertainty", () => {
    const row = rowOf("a", { temperature: [293.15, "20.0 ± 0.5", 0.5] });
    expect(coordinate(row, number("temperature", "°C", 1, -273.15))).toEqual({ value: 20, text: "20.0 ± 0.5", u: 0.5 });
  });
});

describe("grouped", () => {
  const groups = grouped(ROWS, LOAD, FRICTION);

  it("has one group per pair of materials, each from left to right, without runs that miss a quantity", () => {
    expect(groups.map(({ name, points }) => [name, points.map(({ id }) => id)])).toEqual([
      ["Si3N4 on steel", ["a", "b", "c"]],
      ["WC-Co", ["d"]],
    ]);
    expect(groups[1]!.points[0]!.bad).toBe(true);
    expect(materialPair(ROWS[4]!)).toBe("unknown materials");
  });

  it("is empty for no runs", () => {
    expect(grouped([], LOAD, FRICTION)).toEqual([]);
  });

  it("gives the mean of replicates, which have the same conditions and are not marked bad", () => {
    expect(replicateMeans(groups[0]!)).toEqual([{ x: 200, y: 0.5, count: 2 }]);
    const bad = rowOf("f", { ...steel, load: [0.4, "400"], friction: [0.9, "0.9"], mark: "bad" });
    const wet = rowOf("g", { ...steel, load: [0.4, "400"], friction: [0.9, "0.9"], medium: "water" });
    expect(replicateMeans(grouped([ROWS[0]!, bad, wet], LOAD, FRICTION)[0]!)).toEqual([]);
  });
});

describe("missing", () => {
  it("counts the runs without a quantity", () => {
    expect(missing(ROWS, [LOAD, FRICTION])).toEqual(["1 run has no friction."]);
    const wear = number("k_D");
    expect(missing(ROWS, [wear, wear])).toEqual(["5 runs have no k_D."]);
    expect(missing(ROWS, [LOAD])).toEqual([]);
  });
});

describe("quantities", () => {
  it("are the columns of numbers that some run has", () => {
    const columns = [{ ...number("id"), kind: "text" as const }, LOAD, number("k_D")];
    expect(quantities(columns, ROWS)).toEqual([LOAD]);
    expect([LOAD, FRICTION].map(quantityLabel)).toEqual(["load / mN", "friction"]);
  });
});
