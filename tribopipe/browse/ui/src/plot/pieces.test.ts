import fc from "fast-check";
import { describe, expect, it } from "vitest";

import { pieces, strides, type Piece } from "./pieces";

const places = ([from, to]: Piece): number[] => Array.from({ length: to - from + 1 }, (_, at) => from + at);

describe("pieces", () => {
  it("hold all places that are known in every column, and no others", () => {
    const column = fc.array(fc.option(fc.integer()), { minLength: 12, maxLength: 12 });
    fc.assert(
      fc.property(column, column, (one, other) => {
        const known = places([0, 11]).filter((at) => one[at] !== null && other[at] !== null);
        expect(pieces(one, other).flatMap(places)).toEqual(known);
      }),
      { seed: 7 },
    );
  });

  it("have a gap between them", () => {
    expect(pieces([1, 2, null, 3, null])).toEqual([
      [0, 1],
      [3, 3],
    ]);
    expect(pieces([])).toEqual([]);
    expect(pieces([NaN, 1, Infinity])).toEqual([[1, 1]]);
  });
});

describe("strides", () => {
  it("go one way each, follow on each other, and cover the piece", () => {
    fc.assert(
      fc.property(fc.array(fc.integer({ min: 0, max: 4 }), { minLength: 1 }), (x) => {
        const found = strides(x, [0, x.length - 1]);
        for (const [from, to] of found) {
          const signs = places([from, to])
            .slice(1)
            .map((at) => Math.sign(x[at]! - x[at - 1]!));
          expect(signs.includes(1) && signs.includes(-1)).toBe(false);
        }
        expect(found.slice(1).map(([from]) => from)).toEqual(found.slice(0, -1).map(([, to]) => to));
        expect([found[0]![0], found.at(-1)![1]]).toEqual([0, x.length - 1]);
      }),
      { seed: 7 },
    );
  });

  it("turn where x does, even after standing still", () => {
    expect(strides([0, 1, 2, 1, 0], [0, 4])).toEqual([
      [0, 2],
      [2, 4],
    ]);
    expect(strides([0, 1, 1, 0], [0, 3])).toEqual([
      [0, 2],
      [2, 3],
    ]);
    expect(strides([9, 0, 1], [1, 2])).toEqual([[1, 2]]);
  });
});
