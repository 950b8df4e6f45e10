import type { Plot } from "../api";

/** The part of the horizontal axis that is looked at, in its unit. */
export interface View {
  from: number;
  to: number;
}

export type Step = "in" | "out" | "left" | "right" | "whole";

/** What the server answered for; widened where all of it is one place. */
export function viewOf({ x: { from, to } }: Plot): View {
  return to > from ? { from, to } : { from: from - 0.5, to: from + 0.5 };
}

/** The ends of an axis of which nothing is known. */
export const ANYWHERE: View = { from: -Infinity, to: Infinity };

/** The ends of an axis, once a plot tells them: lines go one sample beyond the view where there is more. */
export function learnt(ends: View, plot: Plot): View {
  const [view, extent] = [viewOf(plot), extentOf(plot)];
  return {
    from: extent.from >= view.from ? extent.from : ends.from,
    to: extent.to <= view.to ? extent.to : ends.to,
  };
}

function extentOf({ panels }: Plot): View {
  let [from, to] = [Infinity, -Infinity];
  for (const { lines } of panels) {
    for (const { x } of lines) {
      for (const place of x) {
        if (place < from) from = place;
        if (place > to) to = place;
      }
    }
  }
  return { from, to };
}

/** What is looked at after a step; null for all of it, the same view where there is nowhere to go. */
export function stepped(view: View, step: Step, ends: View): View | null {
  const span = view.to - view.from;
  switch (step) {
    case "whole":
      return null;
    case "in":
      return { from: view.from + span / 4, to: view.to - span / 4 };
    case "out":
      return wider(view, span / 2, ends);
    case "left":
      return moved(view, Math.max(-span / 4, Math.min(ends.from - view.from, 0)));
    case "right":
      return moved(view, Math.min(span / 4, Math.max(ends.to - view.to, 0)));
  }
}

const moved = (view: View, by: number): View => (by === 0 ? view : { from: view.from + by, to: view.to + by });

function wider({ from, to }: View, by: number, ends: View): View | null {
  const [before, after] = [from - by, to + by];
  if (before <= ends.from && after >= ends.to) return null;
  return { from: Math.max(before, Math.min(ends.from, from)), to: Math.min(after, Math.max(ends.to, to)) };
}

const DIGITS_OF_SPAN = 5;
const FINEST = 1e-9;
/** As many as `toFixed` takes. */
const MOST_DIGITS = 100;

/** The view in round numbers, for the address; null where it is too narrow to tell its ends apart. */
export function rounded({ from, to }: View): View | null {
  const span = to - from;
  if (!(span > FINEST * Math.max(Math.abs(from), Math.abs(to)))) return null;
  const digits = Math.min(Math.max(DIGITS_OF_SPAN - 1 - Math.floor(Math.log10(span)), 0), MOST_DIGITS);
  return { from: Number(from.toFixed(digits)), to: Number(to.toFixed(digits)) };
}
