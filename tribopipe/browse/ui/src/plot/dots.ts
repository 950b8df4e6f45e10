import type uPlot from "uplot";

import type { Line } from "../api";
import { nearest } from "./nearest";
import type { Styled } from "./styled";

const CLASS = "plot-dot";

/** Show which sample of each line is read at a place on the horizontal axis; none of any where there is no place. */
export function showDots(plot: uPlot, lines: Styled<Line>[], place: number | null): void {
  const view = { from: plot.scales.x!.min!, to: plot.scales.x!.max! };
  const dots = place === null ? [] : lines.flatMap((line) => dotOf(plot, line, nearest(line.thing, place, view)));
  plot.over.querySelectorAll(`.${CLASS}`).forEach((old) => old.remove());
  plot.over.append(...dots);
}

function dotOf(plot: uPlot, { thing, colour }: Styled<Line>, at: number): HTMLElement[] {
  const value = thing.y[at];
  if (value == null) return [];
  const [left, top] = [plot.valToPos(thing.x[at]!, "x"), plot.valToPos(value, "y")];
  const dot = document.createElement("span");
  dot.className = CLASS;
  dot.style.background = colour;
  dot.style.transform = `translate(${left}px, ${top}px)`;
  return [dot];
}
