import fc from "fast-check";
import { describe, expect, it } from "vitest";

import { lineOf, panelOf, plotOf } from "./testing";
import { ANYWHERE, learnt, rounded, stepped, viewOf, type Step, type View } from "./view";

const number = fc.double({ min: -1e6, max: 1e6, noNaN: true });
const span = fc.double({ min: 1e-3, max: 1e6, noNaN: true });
const views = fc.record({ from: number, span }).map(({ from, span }): View => ({ from, to: from + span }));
const steps = fc.constantFrom<Step>("in", "out", "left", "right");

/** A view and the ends of an axis around it. */
const within = fc
  .record({
    view: views,
    before: fc.double({ min: 0, max: 1e6, noNaN: true }),
    after: fc.double({ min: 0, max: 1e6, noNaN: true }),
  })
  .map(({ view, before, after }) => ({ view, ends: { from: view.from - before, to: view.to + after } }));

const plotAlong = (x: number[], from: number, to: number) =>
  plotOf({ x: { name: "time", label: "time / s", from, to }, panels: [panelOf({ lines: [lineOf({ x })] })] });

describe("viewOf", () => {
  it("is the range of the answer, and of some width where that is one place", () => {
    expect(viewOf(plotAlong([], 2, 5))).toEqual({ from: 2, to: 5 });
    expect(viewOf(plotAlong([], 3, 3))).toEqual({ from: 2.5, to: 3.5 });
  });
});

describe("learnt", () => {
  it("tells an end from lines that do not go beyond the view", () => {
    expect(learnt(ANYWHERE, plotAlong([0, 50, 100], 0, 100))).toEqual({ from: 0, to: 100 });
    expect(learnt(ANYWHERE, plotAlong([0, 10, 21], 5, 20))).toEqual(ANYWHERE);
    expect(learnt(ANYWHERE, plotAlong([5, 10, 21], 5, 20))).toEqual({ from: 5, to: Infinity });
  });

  it("keeps the ends that were known", () => {
    expect(learnt({ from: 0, to: 100 }, plotAlong([9, 10, 21], 10, 20))).toEqual({ from: 0, to: 100 });
  });
});

describe("stepped", () => {
  it("goes nowhere beyond the ends, and always to a view of some width", () => {
    fc.assert(
      fc.property(within, steps, ({ view, ends }, step) => {
        const next = stepped(view, step, ends);
        if (next === null) return;
        const slack = 1e-9 * (Math.abs(ends.from) + Math.abs(ends.to) + 1);
        expect(next.from).toBeGreaterThanOrEqual(ends.from - slack);
        expect(next.to).toBeLessThanOrEqual(ends.to + slack);
        expect(next.to).toBeGreaterThan(next.from);
      }),
      { seed: 7 },
    );
  });

  it("keeps the width when it moves", () => {
    fc.assert(
      fc.property(within, fc.constantFrom<Step>("left", "right"), ({ view, ends }, step) => {
        const next = stepped(view, step, ends)!;
        expect(Math.abs(next.to - next.from - (view.to - view.from))).toBeLessThan(
          1e-9 * (Math.abs(view.from) + Math.abs(view.to) + 1),
        );
      }),
      { seed: 7 },
    );
  });

  it("halves, doubles and moves by a quarter", () => {
    const view = { from: 40, to: 60 };
    expect(stepped(view, "in", ANYWHERE)).toEqual({ from: 45, to: 55 });
    expect(stepped(view, "out", ANYWHERE)).toEqual({ from: 30, to: 70 });
    expect(stepped(view, "left", ANYWHERE)).toEqual({ from: 35, to: 55 });
    expect(stepped(view, "right", { from: 0, to: 62 })).toEqual({ from: 42, to: 62 });
  });

  it("is the same view at the end, and all of it once that would fit", () => {
    const view = { from: 0, to: 60 };
    expect(stepped(view, "left", { from: 0, to: 100 })).toBe(view);
    expect(stepped({ from: 20, to: 80 }, "out", { from: 0, to: 100 })).toBeNull();
    expect(stepped(view, "whole", { from: 0, to: 100 })).toBeNull();
  });
});

describe("rounded", () => {
  it("stays within a part in a thousand of the view, whatever its size", () => {
    const anySize = fc
      .record({
        from: fc.double({ min: -1, max: 1, noNaN: true }),
        span: fc.double({ min: 1e-3, max: 1, noNaN: true }),
        power: fc.integer({ min: -30, max: 30 }),
      })
      .map(({ from, span, power }) => ({ from: from * 10 ** power, to: (from + span) * 10 ** power }));
    fc.assert(
      fc.property(anySize, (view) => {
        const round = rounded(view)!;
        const width = view.to - view.from;
        expect(Math.abs(round.from - view.from) / width).toBeLessThan(1e-3);
        expect(Math.abs(round.to - view.to) / width).toBeLessThan(1e-3);
        expect(round.to).toBeGreaterThan(round.from);
      }),
      { seed: 7 },
    );
  });

  it("has few digits", () => {
    expect(rounded({ from: 1.23456789, to: 2.3456789 })).toEqual({ from: 1.2346, to: 2.3457 });
    expect(rounded({ from: 12345.678, to: 98765.432 })).toEqual({ from: 12346, to: 98765 });
  });

  it("is nothing where the ends cannot be told apart", () => {
    expect(rounded({ from: 1, to: 1 })).toBeNull();
    expect(rounded({ from: 1e6, to: 1e6 + 1e-4 })).toBeNull();
    expect(rounded({ from: 0, to: Infinity })).toBeNull();
    expect(rounded({ from: NaN, to: 1 })).toBeNull();
  });
});
