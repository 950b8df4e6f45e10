import type { Line } from "../api";
import type { View } from "./view";

/** As far from a sample, in parts of the view, as nothing was recorded there. */
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

const isWithin = (x: number[], place: number): boolean => Math.min(x[0]!, x.at(-1)!) <= place && place <= Math.max(x[0]!, x.at(-1)!);
