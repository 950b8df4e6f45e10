import fc from "fast-check";
import { describe, expect, it } from "vitest";

import { verticalRange } from "./range";
import { lineOf, markOf } from "./testing";

const ALL = { from: -Infinity, to: Infinity };

describe("verticalRange", () => {
  it("spans all that is drawn within the view, with a margin of 6 % at either end", () => {
    const value = fc.option(fc.double({ min: -1e3, max: 1e3, noNaN: true }));
    fc.assert(
      fc.property(fc.array(value, { minLength: 1 }), fc.nat(20), fc.nat(20), (y, from, width) => {
        const seen = y.filter((one, at): one is number => one !== null && at >= from && at <= from + width);
        if (seen.length === 0 || Math.min(...seen) === Math.max(...seen)) return;
        const [least, most] = [Math.min(...seen), Math.max(...seen)];
        const [low, high] = verticalRange([lineOf({ x: y.map((_, at) => at), y })], [], { from, to: from + width });
        expect(low).toBeCloseTo(least - 0.06 * (most - least), 6);
        expect(high).toBeCloseTo(most + 0.06 * (most - least), 6);
      }),
      { seed: 7 },
    );
  });

  it("makes room for bands and for the intervals of marks within the view", () => {
    const band = lineOf({ x: [0, 1], y: [5, 5], lower: [1, 2], upper: [8, 9] });
    expect(verticalRange([band], [], ALL)).toEqual([1 - 0.48, 9 + 0.48]);
    const marks = [markOf({ x: 1, y: 10, half_width: 10 }), markOf({ x: 3, y: 500, half_width: 10 })];
    expect(verticalRange([], marks, { from: 0, to: 2 })).toEqual([-1.2, 21.2]);
  });

  it("lets the band of a measured line leave the axis where it is much wider than elsewhere", () => {
    const x = [0, 1, 2, 3, 4];
    const measured = lineOf({ x, y: [5, 5, 5, 5, 5], lower: [4, 4, 4, 4, -995], upper: [6, 6, 6, 6, 1005] });
    expect(verticalRange([measured], [], ALL)).toEqual([3 - 0.24, 7 + 0.24]);
    expect(verticalRange([{ ...measured, role: "fit" }], [], ALL)).toEqual([-1115, 1125]);
  });

  it("shows the whole where nothing is within the view", () => {
    const line = lineOf({ x: [0, 1], y: [0, 100] });
    expect(verticalRange([line], [], { from: 5, to: 6 })).toEqual(verticalRange([line], [], ALL));
  });

  it("has some height where all is level or nothing is there", () => {
    const level = (value: number) => verticalRange([lineOf({ x: [0, 1], y: [value, value] })], [], ALL);
    expect(level(0)).toEqual([-1, 1]);
    expect(level(-100)).toEqual([-106, -94]);
    expect(verticalRange([], [], ALL)).toEqual([0, 1]);
    expect(verticalRange([lineOf({ x: [0], y: [null] })], [], ALL)).toEqual([0, 1]);
  });
});
