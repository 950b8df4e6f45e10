import { describe, expect, it } from "vitest";

import { AT_ONCE, partOf, rowIn } from "./parts";

const rowOf = (id: string) => ({ id, cell: () => null, shown: () => "" });

describe("partOf", () => {
  it("asks for as many runs each time, one after the other", () => {
    expect(partOf({ where: "load>1" }, 0)).toEqual({ where: "load>1", start: 0, most: AT_ONCE });
    expect(partOf({}, 3).start).toBe(3 * AT_ONCE);
  });
});

describe("rowIn", () => {
  const parts = [
    { start: 500, rows: ["a", "b"].map(rowOf) },
    { start: 1000, rows: [rowOf("c")] },
  ];

  it("finds a row by its place in the whole list", () => {
    expect([500, 501, 1000].map((place) => rowIn(parts, place)?.id)).toEqual(["a", "b", "c"]);
  });

  it("has none that is not here", () => {
    expect([0, 499, 502, 999, 1001].map((place) => rowIn(parts, place))).toEqual(Array(5).fill(undefined));
  });
});
