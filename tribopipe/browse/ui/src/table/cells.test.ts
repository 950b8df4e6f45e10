import fc from "fast-check";
import { describe, expect, it } from "vitest";

import type { Cell } from "../api";
import { compareCells, textOf } from "./cells";

describe("compareCells", () => {
  const numbers = fc.double({ noNaN: true, noDefaultInfinity: true }).map((value): Cell => [value, String(value)]);
  const column = fc.oneof(
    fc.array(fc.oneof(fc.constant<Cell>(null), numbers)),
    fc.array(fc.oneof(fc.constant<Cell>(null), fc.string())),
  );

  it("orders any column: neighbours never stand the wrong way round, the unknown come last", () => {
    fc.assert(
      fc.property(column, fc.boolean(), (cells, descending) => {
        const order = cells.toSorted((a, b) => compareCells(a, b, descending));
        const known = order.map((cell) => cell !== null && cell !== "");
        expect(known.lastIndexOf(true)).toBe(known.filter(Boolean).length - 1);
        order.forEach((cell, at) => {
          if (at > 0) expect(compareCells(order[at - 1]!, cell, descending)).toBeLessThanOrEqual(0);
        });
        const sizes = order.flatMap((cell) => (Array.isArray(cell) ? [cell[0]] : []));
        expect(sizes).toEqual(sizes.toSorted((a, b) => (descending ? b - a : a - b)));
      }),
      { seed: 7 },
    );
  });
});

describe("textOf", () => {
  it("is what is written, and nothing where nothing is known", () => {
    expect([textOf("oil"), textOf([2e-9, "2.0 ± 0.1"]), textOf(null), textOf(undefined)]).toEqual([
      "oil",
      "2.0 ± 0.1",
      "",
      "",
    ]);
  });
});
