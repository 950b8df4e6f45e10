import fc from "fast-check";
import { describe, expect, it } from "vitest";

import { axisExponent, axisLabel, counted, read, ticks } from "./numbers";

/** The number that a text stands for: "−1.2346×10⁻⁹" is -1.2346e-9. */
function meant(text: string): number {
  const plain = text.replaceAll(",", "").replaceAll("−", "-");
  const [digits, power = ""] = plain.split("×10");
  const exponent = [...power].map((sign) => "-0123456789"["⁻⁰¹²³⁴⁵⁶⁷⁸⁹".indexOf(sign)]).join("");
  return Number(`${digits}e${exponent || 0}`);
}

const values = fc
  .record({
    digits: fc.double({ min: -10, max: 10, noNaN: true, noDefaultInfinity: true }),
    power: fc.integer({ min: -30, max: 30 }),
  })
  .map(({ digits, power }) => digits * 10 ** power)
  .filter((value) => value === 0 || Math.abs(value) > 1e-40);

describe("read", () => {
  it("tells five digits of any value", () => {
    fc.assert(
      fc.property(values, (value) => {
        expect(Math.abs(meant(read(value)) - value)).toBeLessThanOrEqual(0.5001e-4 * Math.abs(value));
      }),
      { seed: 7 },
    );
  });

  it("has one digit before the point of a power of ten", () => {
    fc.assert(
      fc.property(values, (value) => {
        const [digits, power] = read(value).split("×");
        if (power) expect(digits).toMatch(/^−?[1-9](\.\d+)?$/);
      }),
      { seed: 7 },
    );
  });

  it.each([
    [0, "0"],
    [-0, "0"],
    [23.5231, "23.523"],
    [-0.5, "−0.5"],
    [1234567, "1,234,600"],
    [1.23456e-9, "1.2346×10⁻⁹"],
    [-2e10, "−2×10¹⁰"],
    [9.999999e-4, "1×10⁻³"],
    [99999999, "1×10⁸"],
  ])("writes %d as %s", (value, text) => {
    expect(read(value)).toBe(text);
  });
});

describe("axes", () => {
  it("take out a power of a thousand where numbers would be long, none elsewhere", () => {
    expect(axisExponent([0, 2.5e-9])).toBe(-9);
    expect(axisExponent([-3e-5, 1e-5])).toBe(-6);
    expect(axisExponent([0, 4.5e7])).toBe(6);
    expect([axisExponent([0, 0]), axisExponent([0, 0.6]), axisExponent([-9e6, 0])]).toEqual([0, 0, 0]);
  });

  it("leave one to three digits before the point once it is out", () => {
    fc.assert(
      fc.property(
        values.filter((value) => value !== 0),
        (value) => {
          const exponent = axisExponent([0, value]);
          if (exponent === 0) return;
          const left = Math.abs(value) / 10 ** exponent;
          expect(left).toBeGreaterThanOrEqual(1 - 1e-9);
          expect(left).toBeLessThan(1000 + 1e-9);
        },
      ),
      { seed: 7 },
    );
  });

  it("name the power of ten before the unit", () => {
    expect(axisLabel("effective k_D / mm³/(N·mm)", -9)).toBe("effective k_D / 10⁻⁹ mm³/(N·mm)");
    expect(axisLabel("μ", -3)).toBe("μ / 10⁻³");
    expect(axisLabel("μ", 0)).toBe("μ");
  });

  it("write ticks apart from each other, and as they are", () => {
    const steps = fc.record({
      unit: fc.constantFrom(1, 2, 2.5, 5),
      power: fc.integer({ min: -9, max: 9 }),
      first: fc.integer({ min: -20, max: 20 }),
    });
    fc.assert(
      fc.property(steps, ({ unit, power, first }) => {
        const step = unit * 10 ** power;
        const places = [0, 1, 2, 3, 4].map((count) => (first + count) * step);
        const exponent = axisExponent([places[0]!, places[4]!]);
        const texts = ticks(places, step, exponent);
        expect(new Set(texts).size).toBe(5);
        texts.forEach((text, at) =>
          expect(Math.abs(meant(text) * 10 ** exponent - places[at]!)).toBeLessThan(1e-6 * step),
        );
        expect(texts.filter((text) => /^−0(\.0*)?$/.test(text))).toEqual([]);
      }),
      { seed: 7 },
    );
  });

  it("write ticks with the same digits", () => {
    expect(ticks([-0.5, -0, 0.5, 1], 0.5, 0)).toEqual(["−0.5", "0.0", "0.5", "1.0"]);
    expect(ticks([0, 2.5e-9], 2.5e-9, -9)).toEqual(["0.0", "2.5"]);
    expect(ticks([0, 2e6], 1e6, 0)).toEqual(["0", "2,000,000"]);
  });
});

describe("counted", () => {
  it("sets thousands apart", () => {
    expect([counted(0), counted(999), counted(2_000_000)]).toEqual(["0", "999", "2,000,000"]);
  });
});
