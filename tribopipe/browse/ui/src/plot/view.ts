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

/** Where the lines begin and end; beyond the view if there is more than it shows. */
export function extentOf({ panels }: Plot): View {
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

/** What is looked at after a step; null for all of it. */
export function stepped(view: View, step: Step, extent: View): View | null {
  const span = view.to - view.from;
  switch (step) {
    case "whole":
      return null;
    case "in":
      return { from: view.from + span / 4, to: view.to - span / 4 };
    case "out":
      return wider(view, span / 2, extent);
    case "left":
      return extent.from < view.from ? moved(view, -span / 4) : view;
    case "right":
      return extent.to > view.to ? moved(view, span / 4) : view;
  }
}

const moved = ({ from, to }: View, by: number): View => ({ from: from + by, to: to + by });

/** Wider on the sides where there is more; all of it where there is none. */
function wider(view: View, by: number, extent: View): View | null {
  const [before, after] = [extent.from < view.from, extent.to > view.to];
  if (!before && !after) return null;
  return { from: before ? view.from - by : view.from, to: after ? view.to + by : view.to };
}

const DIGITS_OF_SPAN = 5;
const FINEST = 1e-9;

/** The view in round numbers, for the address; null where it is too narrow to tell its ends apart. */
export function rounded({ from, to }: View): View | null {
  const span = to - from;
  if (!(span > FINEST * Math.max(Math.abs(from), Math.abs(to)))) return null;
  const digits = Math.min(Math.max(DIGITS_OF_SPAN - 1 - Math.floor(Math.log10(span)), 0), 20);
  return { from: Number(from.toFixed(digits)), to: Number(to.toFixed(digits)) };
}
