import uPlot from "uplot";

import type { Line, Mark } from "../api";
import { pieces, strides } from "./pieces";
import { shapePath } from "./shapes";
import type { Stroke } from "./strokes";
import type { Styled } from "./styled";

/** Where values stand on the canvas. */
interface Places {
  x(value: number): number;
  y(value: number): number;
}

const BAND = 0.16;
const SHAPE_RADIUS = 3.5;
/** Between figures on a line, in CSS pixels; between samples that are shown one by one. */
const SHAPES_EVERY = 150;
const SAMPLES_EVERY = 12;
/** The golden section keeps figures of many lines apart. */
const STAGGER = 0.618;

/** Draw lines, their bands and marks on the axes of a plot, nothing outside of them. */
export function paint(plot: uPlot, lines: Styled<Line>[], marks: Styled<Mark>[], zero: string | null): void {
  const { ctx, bbox } = plot;
  const places = placesOf(plot);
  ctx.save(); // uPlot remembers what it set, so all is left as it was.
  ctx.save();
  ctx.beginPath();
  ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
  ctx.clip();
  if (zero !== null) paintZero(plot, places, zero);
  for (const line of lines) paintBand(ctx, places, line);
  for (const line of lines) paintLine(ctx, places, line);
  lines.forEach((line, place) => paintShapes(plot, places, line, (place * STAGGER) % 1));
  ctx.restore();
  const { min, max } = plot.scales.x!;
  const isSeen = ({ thing: { x } }: Styled<Mark>): boolean => x >= min! && x <= max!;
  for (const mark of marks.filter(isSeen)) paintMark(ctx, places, mark);
  ctx.restore();
}

function placesOf(plot: uPlot): Places {
  const along = (scale: "x" | "y") => {
    const { min = 0, max = 1 } = plot.scales[scale]!;
    const [low, high] = [min, max].map((end) => plot.valToPos(end!, scale, true)) as [number, number];
    const factor = (high - low) / (max! - min!);
    return (value: number) => low + (value - min!) * factor;
  };
  return { x: along("x"), y: along("y") };
}

function paintZero({ ctx, bbox }: uPlot, { y }: Places, colour: string): void {
  ctx.strokeStyle = colour;
  ctx.lineWidth = uPlot.pxRatio;
  ctx.setLineDash([]);
  ctx.beginPath();
  ctx.moveTo(bbox.left, y(0));
  ctx.lineTo(bbox.left + bbox.width, y(0));
  ctx.stroke();
}

function paintLine(ctx: CanvasRenderingContext2D, places: Places, { thing, stroke, colour }: Styled<Line>): void {
  dress(ctx, stroke, colour);
  ctx.beginPath();
  for (const [from, to] of pieces(thing.x, thing.y)) {
    ctx.moveTo(places.x(thing.x[from]!), places.y(thing.y[from]!));
    // A lone sample is a line to itself, which round caps make a dot.
    for (let at = Math.min(from + 1, to); at <= to; at++) ctx.lineTo(places.x(thing.x[at]!), places.y(thing.y[at]!));
  }
  ctx.stroke();
}

function paintBand(ctx: CanvasRenderingContext2D, places: Places, { thing, colour }: Styled<Line>): void {
  const { x, lower, upper } = thing;
  if (lower === null || upper === null) return;
  ctx.beginPath();
  for (const [from, to] of pieces(x, lower, upper).flatMap((piece) => strides(x, piece))) {
    // All go round the same way, as parts that go round in opposite ways would cut holes into each other.
    const [there, back] = x[to]! >= x[from]! ? [lower, upper] : [upper, lower];
    ctx.moveTo(places.x(x[from]!), places.y(there[from]!));
    for (let at = from + 1; at <= to; at++) ctx.lineTo(places.x(x[at]!), places.y(there[at]!));
    for (let at = to; at >= from; at--) ctx.lineTo(places.x(x[at]!), places.y(back[at]!));
    ctx.closePath();
  }
  ctx.globalAlpha = BAND;
  ctx.fillStyle = colour;
  ctx.fill();
}

/** The figure of a line here and there along it; of measurements that stand wide apart, each sample. */
function paintShapes(plot: uPlot, places: Places, { thing, stroke, colour }: Styled<Line>, offset: number): void {
  const { ctx, bbox } = plot;
  const apart = bbox.width / uPlot.pxRatio / Math.max(thing.x.length - 1, 1);
  const isEach = thing.role === "measured" && apart > SAMPLES_EVERY;
  if (stroke.shape === null && !isEach) return;
  const every = isEach ? 0 : SHAPES_EVERY * uPlot.pxRatio;
  const radius = (stroke.shape === null ? SHAPE_RADIUS / 2 : SHAPE_RADIUS) * uPlot.pxRatio;
  dress(ctx, { ...stroke, width: 1.5, dash: [], alpha: 1 }, colour);
  for (const [x, y] of spaced(thing, places, bbox.left + offset * every, every)) {
    paintShape(ctx, new Path2D(shapePath(stroke.shape ?? "circle", x, y, radius)), colour);
  }
}

/** Samples on the canvas so far apart, from a start on; each of them where they need not be apart. */
function* spaced({ x, y }: Line, places: Places, start: number, every: number): Generator<[number, number]> {
  let next = every === 0 ? -Infinity : start;
  for (let at = 0; at < x.length; at++) {
    const [here, value] = [places.x(x[at]!), y[at]];
    if (value == null || here < next) continue;
    yield [here, places.y(value)];
    if (every > 0) next = start + every * (Math.floor((here - start) / every) + 1);
  }
}

function paintShape(ctx: CanvasRenderingContext2D, path: Path2D, colour: string): void {
  ctx.fillStyle = colour;
  ctx.fill(path);
  ctx.stroke(path);
}

/** A measured value with its error bar. */
function paintMark(ctx: CanvasRenderingContext2D, places: Places, { thing, stroke, colour }: Styled<Mark>): void {
  const x = places.x(thing.x);
  const [low, high] = [places.y(thing.y - thing.half_width), places.y(thing.y + thing.half_width)];
  const cap = SHAPE_RADIUS * uPlot.pxRatio;
  dress(ctx, stroke, colour);
  ctx.beginPath();
  ctx.moveTo(x, low);
  ctx.lineTo(x, high);
  for (const end of [low, high]) {
    ctx.moveTo(x - cap, end);
    ctx.lineTo(x + cap, end);
  }
  ctx.stroke();
  paintShape(ctx, new Path2D(shapePath(stroke.shape ?? "circle", x, places.y(thing.y), cap)), colour);
}

function dress(ctx: CanvasRenderingContext2D, { width, dash, alpha }: Stroke, colour: string): void {
  ctx.globalAlpha = alpha;
  ctx.strokeStyle = colour;
  ctx.lineWidth = width * uPlot.pxRatio;
  ctx.setLineDash(dash.map((part) => part * uPlot.pxRatio));
  ctx.lineCap = dash.length ? "butt" : "round";
  ctx.lineJoin = "round";
}
