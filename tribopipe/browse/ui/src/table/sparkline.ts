import { get, type Sparkline } from "../api";

/** Size of the drawing, in its own units. */
export const WIDTH = 80;
export const HEIGHT = 20;
const EDGE = 2;

/** The lines of a curve as points of SVG polylines, scaled to the drawing; a gap begins another line. */
export function polylines({ x, y }: Sparkline): string[] {
  const across = scale(x, EDGE, WIDTH - EDGE);
  const up = scale(y, HEIGHT - EDGE, EDGE);
  const lines: string[][] = [[]];
  y.forEach((value, place) => {
    const at = x[place] ?? null;
    if (value === null || at === null) lines.push([]);
    else lines.at(-1)?.push(`${across(at)},${up(value)}`);
  });
  return lines.filter(({ length }) => length > 1).map((points) => points.join(" "));
}

/** Map numbers to a range, all that are equal to its middle. */
function scale(values: (number | null)[], from: number, to: number): (value: number) => string {
  const known = values.filter((value) => value !== null);
  const [low, high] = [Math.min(...known), Math.max(...known)];
  return (value) => (high > low ? from + ((to - from) * (value - low)) / (high - low) : (from + to) / 2).toFixed(1);
}

let last: Promise<unknown> = Promise.resolve();

/** Ask for the curve of a run after all others asked for before, so that nothing else has to wait for them. */
export function askSparkline(id: string, signal: AbortSignal): Promise<Sparkline | null> {
  const ask = () => (signal.aborted ? null : get<Sparkline>(`runs/${encodeURIComponent(id)}/sparkline`, {}, signal));
  const mine = last.then(ask);
  last = mine.catch(() => null);
  return mine;
}
