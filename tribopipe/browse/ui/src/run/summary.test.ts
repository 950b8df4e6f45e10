import { describe, expect, it } from "vitest";

import type { Run } from "../api";
import { summary } from "./summary";

describe("summary", () => {
  const group = (title: string, ...facts: [string, string][]) => ({
    title,
    facts: facts.map(([name, value]) => ({ name, value })),
  });
  const runOf = (tribometer: string | null, ...facts: Run["facts"]) => ({ tribometer, facts }) as Run;

  it("tells tribometer, bodies, load and medium", () => {
    const run = runOf(
      "pin-on-disc",
      group("Conditions", ["normal load", "200 mN"], ["medium", "dry air"]),
      group("Pin", ["material", "Si3N4"], ["radius", "1.5 mm"]),
      group("Disc", ["material", "steel"]),
    );
    expect(summary(run)).toEqual(["pin-on-disc", "Si3N4 pin on steel disc", "200 mN", "dry air"]);
  });

  it("leaves out what is not known", () => {
    expect(summary(runOf(null))).toEqual([]);
    expect(summary(runOf(null, group("Conditions", ["medium", ""]), group("Disc", ["material", "steel"])))).toEqual([
      "steel disc",
    ]);
  });
});
