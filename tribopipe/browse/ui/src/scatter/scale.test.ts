import { describe, expect, it } from "vitest";

import { isLogarithmic, placeOn, scaleOf } from "./scale";

describe("scaleOf", () => {
  it("has round ticks around all values", () => {
    expect(scaleOf([200, 400, 800], false)).toMatchObject({ from: 170, to: 830, ticks: [200, 300, 400, 500, 600, 700, 800] });
    expect(scaleOf([0, 1], false).ticks).toEqual([0, 0.2, 0.4, 0.6, 0.8, 1]);
  });

  it("has room around a single value, zero, or none", () => {
    for (const values of [[0], [-5], [3e-12], []]) {
      const { from, to, ticks } = scaleOf(values, false);
      expect(from).toBeLessThan(to);
      expect(ticks.length).toBeGreaterThan(1);
    }
  });

  it("has ticks at 1, 2 and 5 over few decades, at powers of ten over many", () => {
    expect(scaleOf([10, 100], true).ticks).toEqual([10, 20, 50, 100]);
    expect(scaleOf([1e-12, 1e-8], true).ticks).toEqual([1e-12, 1e-11, 1e-10, 1e-9, 1e-8]);
  });

  it("has ticks at equal distances where 1, 2 and 5 are too few", () => {
    expect(scaleOf([4.2e-12, 9e-12], true).ticks).toEqual([5e-12, 6e-12, 7e-12, 8e-12, 9e-12]);
  });
});

describe("isLogarithmic", () => {
  it("is as chosen", () => {
    expect(isLogarithmic("1", [1, 2])).toBe(true);
    expect(isLogarithmic("0", [1, 1e6])).toBe(false);
  });

  it("follows from the values without a choice", () => {
    expect(isLogarithmic(null, [7e-12, 1.4e-8])).toBe(true);
    expect(isLogarithmic(null, [200, 1600])).toBe(false);
    expect(isLogarithmic(null, [0, 1e6])).toBe(false);
    expect(isLogarithmic(null, [-1, 1e6])).toBe(false);
    expect(isLogarithmic(null, [])).toBe(false);
  });
});

describe("placeOn", () => {
  it("goes from 0 to 1 along the axis", () => {
    for (const log of [false, true]) {
      const scale = scaleOf([1, 100], log);
      expect(placeOn(scale, scale.from)).toBeCloseTo(0);
      expect(placeOn(scale, scale.to)).toBeCloseTo(1);
    }
    expect(placeOn(scaleOf([1, 100], true), 10)).toBeCloseTo(0.5);
  });
});
