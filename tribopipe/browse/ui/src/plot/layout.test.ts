import { describe, expect, it } from "vitest";

import { heights, isResidual } from "./layout";
import { lineOf, panelOf } from "./testing";

const values = panelOf({ lines: [lineOf({ role: "fit" })] });
const residuals = panelOf({ lines: [lineOf({ role: "residual" })] });

describe("heights", () => {
  it("share the height: one panel has it all, residuals take less", () => {
    expect(heights([values], 400)).toEqual([400]);
    const [above, below] = heights([values, residuals], 400);
    expect(above! + below!).toBe(400);
    expect(above!).toBeGreaterThan(2 * below!);
    expect(heights([], 400)).toEqual([]);
  });

  it("grow where there are three panels or more", () => {
    const all = heights([values, values, values], 400);
    expect(all[0]).toBe(all[2]);
    expect(all[0]! * 3).toBeGreaterThan(400);
  });

  it("take a panel for residuals only where all of its lines are", () => {
    expect(
      [residuals, values, panelOf(), panelOf({ lines: [...values.lines, ...residuals.lines] })].map(isResidual),
    ).toEqual([true, false, false, false]);
  });
});
