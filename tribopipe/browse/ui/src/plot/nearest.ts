import type { Line } from "../api";
import type { View } from "./view";

/** How far beyond its ends a line is still read, in parts of the view. */
const REACH = 0.02;

/** Place of the sample of a line that is nearest to a place on the axis; -1 where there is none near it. */
export function nearest({ x, y }: Line, place: number, view: View): number {
  let [found, distance] = [-1, Infinity];
  for (let at = 0; at < x.length; at++) {
    const away = Math.abs(x[at]! - place);
    if (away < distance && y[at] != null) [found, distance] = [at, away];
  }
  return isWithin(x, place) || distance < REACH * (view.to - view.from) ? found : -1;
}

function isWithin(x: number[], place: number): boolean {
  const ends = [x[0]!, x.at(-1)!];
  return Math.min(...ends) <= place && place <= Math.max(...ends);
}
