import type { Line, Mark } from "../api";
import type { View } from "./view";

export type Range = readonly [low: number, high: number];

const MARGIN = 0.06;
/** The band of a measured line counts up to this many times its median width; beyond, it may leave the axis. */
const WIDEST = 2;
const NOTHING: Range = [Infinity, -Infinity];

/** What a vertical axis spans to show all that is drawn within a view; missing values do not count. */
export function verticalRange(lines: readonly Line[], marks: readonly Mark[], view: View): Range {
  const within = spanned(lines, marks, view);
  const [low, high] = within[0] <= within[1] ? within : spanned(lines, marks, { from: -Infinity, to: Infinity });
  if (low > high) return [0, 1];
  const margin = high > low ? MARGIN * (high - low) : Math.abs(low) * MARGIN || 1;
  return [low - margin, high + margin];
}

function spanned(lines: readonly Line[], marks: readonly Mark[], view: View): Range {
  let range = NOTHING;
  for (const line of lines) {
    for (const values of [line.y, ...band(line)]) range = joined(range, extremes(line.x, values, view));
  }
  for (const { x, y, half_width } of marks) {
    if (x >= view.from && x <= view.to) range = joined(range, [y - half_width, y + half_width]);
  }
  return range;
}

/** The edges of a band; those of a measured line without its few widest places, which would flatten all else. */
function band({ role, y, lower, upper }: Line): (number | null)[][] {
  if (!lower || !upper) return [];
  if (role !== "measured") return [lower, upper];
  const widths = y.map((_, at) => upper[at]! - lower[at]!).filter((width) => Number.isFinite(width));
  const most = (WIDEST / 2) * (widths.toSorted((a, b) => a - b)[Math.floor(widths.length / 2)] ?? 0);
  const within = (value: number | null | undefined, at: number): number | null =>
    value == null || y[at] == null ? null : Math.min(Math.max(value, y[at] - most), y[at] + most);
  return [lower.map(within), upper.map(within)];
}

const joined = (one: Range, other: Range): Range => [Math.min(one[0], other[0]), Math.max(one[1], other[1])];

function extremes(x: number[], values: (number | null)[], { from, to }: View): Range {
  let [low, high] = NOTHING;
  for (let at = 0; at < x.length; at++) {
    const [place, value] = [x[at]!, values[at]];
    if (value == null || !Number.isFinite(value) || place < from || place > to) continue;
    if (value < low) low = value;
    if (value > high) high = value;
  }
  return [low, high];
}
