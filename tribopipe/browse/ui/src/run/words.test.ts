import fc from "fast-check";
import { describe, expect, it } from "vitest";

import { counted, moment, size, unbroken } from "./words";

describe("moment", () => {
  it.each([
    ["2026-03-04T05:06:07Z", "2026-03-04 05:06 UTC"],
    ["2026-03-04T05:06:07.89+00:00", "2026-03-04 05:06 UTC"],
    ["2026-03-04T05:06+01:00", "2026-03-04 05:06 +01:00"],
    ["2026-03-04T05:06:07", "2026-03-04 05:06"],
    ["2026-03-04", "2026-03-04"],
    ["last spring", "last spring"],
    ["", ""],
  ])("writes %j as %j", (date, text) => {
    expect(moment(date)).toBe(text);
  });
});

describe("size", () => {
  const FACTORS = { B: 1, kB: 1e3, MB: 1e6, GB: 1e9 };

  it("tells three digits of any number of bytes, with at most three before the point", () => {
    fc.assert(
      fc.property(
        fc.double({ min: 0, max: 11.99, noNaN: true }).map((power) => Math.floor(10 ** power)),
        (bytes) => {
          const [digits, unit] = size(bytes).split(" ") as [string, keyof typeof FACTORS];
          expect(Math.abs(Number(digits) * FACTORS[unit] - bytes)).toBeLessThanOrEqual(0.00501 * bytes);
          expect(digits).toMatch(/^\d{1,3}(\.\d+)?$/);
        },
      ),
      { seed: 7 },
    );
  });

  it.each([
    [0, "0 B"],
    [999, "999 B"],
    [1000, "1.00 kB"],
    [12_345, "12.3 kB"],
    [999_400, "999 kB"],
    [999_600, "1.00 MB"],
    [5e12, "5000 GB"],
  ])("writes %d as %s", (bytes, text) => {
    expect(size(bytes)).toBe(text);
  });
});

describe("counted", () => {
  it("has one run, and two runs, and no runs", () => {
    expect([1, 2, 0].map((count) => counted(count, "run"))).toEqual(["1 run", "2 runs", "0 runs"]);
  });
});

describe("unbroken", () => {
  it.each([
    ["400.0 ± 4.0 mN", "400.0_±_4.0_mN"],
    ["(8.99 ± 0.65)×10⁻¹² mm³/(N·mm)", "(8.99_±_0.65)×10⁻¹² mm³/(N·mm)"],
    ["95 % CI: -4.4 to 17.3 nm/min", "95_% CI: -4.4_to_17.3_nm/min"],
    ["2 runs to go", "2 runs to go"],
  ])("keeps the numbers of %j together", (text, joined) => {
    expect(unbroken(text).replaceAll("\u00a0", "_")).toBe(joined);
  });
});
