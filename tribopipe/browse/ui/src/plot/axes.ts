import uPlot from "uplot";

import type { Line, Mark } from "../api";
import { showDots } from "./dots";
import { ticks } from "./numbers";
import { paint } from "./paint";
import type { Range } from "./range";
import type { Styled } from "./styled";
import type { View } from "./view";

/** What one pair of axes shows. */
export interface Drawn {
  lines: Styled<Line>[];
  marks: Styled<Mark>[];
  view: View;
  range: Range;
  /** Power of ten taken out of the vertical axis. */
  exponent: number;
  height: number;
  /** Whether numbers stand at the horizontal axis. */
  numbered: boolean;
  /** Colours; that of a line at zero, where there is one. */
  colours: { text: string; grid: string; zero: string | null };
}

export interface Pointed {
  onSelect(view: View): void;
  onWhole(): void;
  /** Place on the horizontal axis under the pointer. */
  onPoint(x: number | null): void;
}

const FONT = '12px system-ui, "Segoe UI", Roboto, "Noto Sans", "Liberation Sans", Arial, sans-serif';
const LEFT = 58;
/** Half of "2,000,000". */
const RIGHT = 32;
const BOTTOM = 24;
/** Panels below this height have ticks closer together. */
const LOW = 180;
/** A drag of fewer pixels is a click. */
const LEAST_DRAG = 6;

/** uPlot keeps axes, pointer and selection; lines are drawn over it, each at its own places, which may go back. */
export const NO_SERIES: uPlot.AlignedData = [[0, 1], [null, null]];

type Options = Omit<uPlot.Options, "width" | "height">;

/** Options of a plot that always shows what it is given last. */
export function axesOptions(drawn: () => Drawn, pointed: () => Pointed, sync: string): Options {
  const given = (_: uPlot, low: number, high: number): uPlot.Range.MinMax => [low, high];
  const axis = {
    font: FONT,
    stroke: () => drawn().colours.text,
    grid: { stroke: () => drawn().colours.grid, width: 1 },
    ticks: { stroke: () => drawn().colours.grid, width: 1, size: 5 },
  };
  return {
    scales: { x: { time: false, auto: false, range: given }, y: { auto: false, range: given } },
    axes: [
      {
        ...axis,
        size: () => (drawn().numbered ? BOTTOM : 6),
        gap: 3,
        values: (_, splits, __, ___, step) => (drawn().numbered ? ticks(splits, step, 0) : splits.map(() => "")),
      },
      {
        ...axis,
        size: LEFT,
        gap: 3,
        space: () => (drawn().height < LOW ? 20 : 32),
        values: (_, splits, __, ___, step) => ticks(splits, step, drawn().exponent),
      },
    ],
    series: [{}, { scale: "y", points: { show: false } }],
    padding: [8, RIGHT, 0, 0],
    legend: { show: false },
    select: { show: true, left: 0, top: 0, width: 0, height: 0 },
    cursor: {
      y: false,
      points: { show: false },
      drag: { x: true, y: false, setScale: false, dist: LEAST_DRAG },
      sync: { key: sync, setSeries: false },
      bind: { dblclick: () => () => (pointed().onWhole(), null) },
    },
    hooks: {
      draw: [(plot) => draw(plot, drawn())],
      setSelect: [(plot) => select(plot, pointed())],
      setCursor: [(plot) => point(plot, drawn(), pointed())],
    },
  };
}

function draw(plot: uPlot, { lines, marks, colours }: Drawn): void {
  paint(plot, lines, marks, colours.zero);
  showDots(plot, lines, placeOf(plot));
}

function point(plot: uPlot, { lines }: Drawn, { onPoint }: Pointed): void {
  const place = placeOf(plot);
  showDots(plot, lines, place);
  onPoint(place);
}

function placeOf(plot: uPlot): number | null {
  const { left } = plot.cursor;
  return left === undefined || left < 0 ? null : plot.posToVal(left, "x");
}

/** Tell what was selected by a drag; plots that only follow another's drag tell nothing. */
function select(plot: uPlot, { onSelect }: Pointed): void {
  const { left, width } = plot.select;
  if (width === 0) return;
  plot.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
  if (plot.cursor.event) onSelect({ from: plot.posToVal(left, "x"), to: plot.posToVal(left + width, "x") });
}
