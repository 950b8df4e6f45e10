import fc from "fast-check";
import { describe, expect, it } from "vitest";

import { nearest } from "./nearest";
import { lineOf } from "./testing";

const VIEW = { from: 0, to: 100 };

describe("nearest", () => {
  it("is no farther than any other sample that was recorded", () => {
    const samples = fc.array(fc.tuple(fc.integer({ min: 0, max: 100 }), fc.boolean()), { minLength: 1 });
    fc.assert(
      fc.property(samples, fc.double({ min: 0, max: 100, noNaN: true }), (all, place) => {
        const x = all.map(([at]) => at).toSorted((one, other) => one - other);
        const y = all.map(([, known]) => (known ? 1 : null));
        const found = nearest(lineOf({ x, y }), place, VIEW);
        const distances = x.map((at, index) => (y[index] === null ? Infinity : Math.abs(at - place)));
        const least = Math.min(...distances);
        const isIn = x[0]! <= place && place <= x.at(-1)!;
        if (least < Infinity && isIn) expect(distances[found]).toBe(least);
        else if (least >= 2) expect(found).toBe(-1);
      }),
      { seed: 7 },
    );
  });

  it("reads a line a little beyond its ends, and no farther", () => {
    const line = lineOf({ x: [10, 20], y: [1, 2] });
    expect([9, 21, 7, 23].map((place) => nearest(line, place, VIEW))).toEqual([0, 1, -1, -1]);
  });

  it("finds none on an empty line", () => {
    expect(nearest(lineOf(), 5, VIEW)).toBe(-1);
  });
});
