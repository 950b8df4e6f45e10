import { useRef, useState, type KeyboardEvent } from "react";

import type { Column } from "../api";
import { seriesVariable } from "../components/series";
import { axisExponent, axisLabel, read, ticks } from "../plot/numbers";
import { shapeOf, shapePath } from "../plot/shapes";
import { go, runHref } from "../shell/router";
import { quantityLabel, replicateMeans, type Group, type Mean, type Point } from "./points";
import { placeOn, scaleOf, type Scale } from "./scale";
import { useWidth } from "./useWidth";

interface Props {
  groups: Group[];
  x: Column;
  y: Column;
  log: { x: boolean; y: boolean };
}

const HEIGHT = 480;
const [LEFT, RIGHT, TOP, BOTTOM] = [84, 24, 12, 48];
const RADIUS = 5;
const MEAN = 11;
const SHAPES = 6;

const colourOf = (place: number): string => `var(${seriesVariable(place)})`;
/** Shapes go round after six, colors after eight: together they tell 24 groups apart. */
const figureOf = (place: number, x: number, y: number): string =>
  shapePath(shapeOf(1 + (place % SHAPES))!, x, y, RADIUS);

/** Runs as points that lead to them, with one legend entry per pair of materials. */
export function ScatterPlot({ groups, x, y, log }: Props) {
  const [hidden, setHidden] = useState<ReadonlySet<string>>(new Set<string>());
  const box = useRef<HTMLDivElement>(null);
  const width = useWidth(box);
  const shown = groups.filter(({ name }) => !hidden.has(name));
  const points = shown.flatMap((group) => group.points);
  const toggle = (name: string) => {
    const next = new Set(hidden);
    if (!next.delete(name)) next.add(name);
    setHidden(next);
  };
  const across = scaleOf(ends(points, "x", log.x), log.x);
  const up = scaleOf(ends(points, "y", log.y), log.y);
  const places: Places = {
    x: (value) => LEFT + placeOn(across, value) * (width - LEFT - RIGHT),
    y: (value) => HEIGHT - BOTTOM - placeOn(up, value) * (HEIGHT - TOP - BOTTOM),
  };
  const means = shown.map((group) => ({ group, means: replicateMeans(group) }));

  return (
    <div className="scatter">
      <ul className="scatter-legend plot-legend" aria-label="Materials">
        {groups.map(({ name, points: { length } }, place) => (
          <li key={name}>
            <button type="button" aria-pressed={!hidden.has(name)} onClick={() => toggle(name)}>
              <svg width="16" height="16" aria-hidden="true" style={{ color: colourOf(place) }}>
                <path d={figureOf(place, 8, 8)} fill="currentColor" stroke="currentColor" />
              </svg>
              <span>
                {name} ({length})
              </span>
            </button>
          </li>
        ))}
      </ul>
      <div ref={box}>
        {width > 0 && (
          <svg className="scatter-plot" viewBox={`0 0 ${width} ${HEIGHT}`} style={{ aspectRatio: `${width} / ${HEIGHT}` }}>
            <Across scale={across} places={places} column={x} width={width} />
            <Up scale={up} places={places} column={y} width={width} />
            <Points groups={groups} hidden={hidden} places={places} scales={[across, up]} columns={[x, y]} />
            {means.map(({ group, means: dashes }) => (
              <Means key={group.name} means={dashes} colour={colourOf(groups.indexOf(group))} places={places} />
            ))}
          </svg>
        )}
      </div>
      <p className="soft">
        Bars: standard uncertainty u.{" "}
        {means.some(({ means: dashes }) => dashes.length > 0) &&
          "Dashes: means of replicates (same bodies and conditions). "}
        {points.some(({ bad }) => bad) && "Hollow: marked bad. "}
        Click a point to open its run, or select it with <kbd>←</kbd> <kbd>→</kbd> and <kbd>Enter</kbd>.
      </p>
    </div>
  );
}

interface Places {
  x(value: number): number;
  y(value: number): number;
}

/** Values with their error bars; on a logarithmic axis bars may end at its edge. */
function ends(points: Point[], axis: "x" | "y", log: boolean): number[] {
  return points.flatMap((point) => {
    const { value, u } = point[axis];
    return u === null || log ? [value] : [value - u, value + u];
  });
}

interface AxisProps {
  scale: Scale;
  places: Places;
  column: Column;
  width: number;
}

/** The label of an axis and the texts of its ticks. */
function labelled({ log, from, to, ticks: at, step }: Scale, column: Column): { label: string; texts: string[] } {
  if (log) return { label: quantityLabel(column), texts: at.map((tick) => read(tick).replace(/^1×/, "")) };
  const exponent = axisExponent([from, to]);
  return { label: axisLabel(quantityLabel(column), exponent), texts: ticks(at, step, exponent) };
}

function Across({ scale, places, column, width }: AxisProps) {
  const { label, texts } = labelled(scale, column);
  return (
    <g className="scatter-ticks" textAnchor="middle">
      {scale.ticks.map((tick, place) => (
        <g key={tick}>
          <path d={`M${places.x(tick)} ${TOP}V${HEIGHT - BOTTOM}`} />
          <text x={places.x(tick)} y={HEIGHT - BOTTOM + 17}>
            {texts[place]}
          </text>
        </g>
      ))}
      <text className="scatter-label" x={(LEFT + width - RIGHT) / 2} y={HEIGHT - 8}>
        {label}
      </text>
    </g>
  );
}

function Up({ scale, places, column, width }: AxisProps) {
  const { label, texts } = labelled(scale, column);
  const middle = (TOP + HEIGHT - BOTTOM) / 2;
  return (
    <g className="scatter-ticks" textAnchor="end">
      {scale.ticks.map((tick, place) => (
        <g key={tick}>
          <path d={`M${LEFT} ${places.y(tick)}H${width - RIGHT}`} />
          <text x={LEFT - 7} y={places.y(tick) + 4}>
            {texts[place]}
          </text>
        </g>
      ))}
      <text className="scatter-label" textAnchor="middle" transform={`translate(14 ${middle}) rotate(-90)`}>
        {label}
      </text>
    </g>
  );
}

interface PointsProps {
  groups: Group[];
  hidden: ReadonlySet<string>;
  places: Places;
  scales: [Scale, Scale];
  columns: [Column, Column];
}

/** All points are one stop of the Tab key; arrow keys go from one to the next. */
function Points({ groups, hidden, places, scales, columns: [x, y] }: PointsProps) {
  const shown = groups.flatMap(({ name, points }, place) =>
    hidden.has(name) ? [] : points.map((point) => ({ name, place, point })),
  );
  const [current, setCurrent] = useState<string | null>(null);
  const stop = shown.find(({ point }) => point.id === current)?.point.id ?? shown[0]?.point.id;

  const move = (event: KeyboardEvent<SVGElement>) => {
    const by = { ArrowLeft: -1, ArrowUp: -1, ArrowRight: 1, ArrowDown: 1 }[event.key];
    if (by === undefined) return;
    event.preventDefault();
    const links = [...event.currentTarget.querySelectorAll("a")];
    links[links.findIndex((link) => link === document.activeElement) + by]?.focus();
  };

  return (
    <g role="group" aria-label={`${y.label} against ${x.label}: one point per run`} onKeyDown={move}>
      {shown.map(({ name, place, point }) => {
        const [left, top] = [places.x(point.x.value), places.y(point.y.value)];
        const told = `${point.id}, ${name}: ${written(x, point.x.text)}, ${written(y, point.y.text)}`;
        return (
          <a
            key={point.id}
            href={runHref(point.id)}
            className="scatter-point"
            style={{ color: colourOf(place) }}
            tabIndex={point.id === stop ? 0 : -1}
            aria-label={told}
            onFocus={() => setCurrent(point.id)}
            onClick={(event) => {
              if (event.metaKey || event.ctrlKey || event.shiftKey || event.altKey) return;
              event.preventDefault();
              go(runHref(point.id));
            }}
          >
            <title>{told}</title>
            <path className="scatter-bar" d={bars(point, places, scales)} />
            <path className={point.bad ? "is-hollow" : undefined} d={figureOf(place, left, top)} />
          </a>
        );
      })}
    </g>
  );
}

const written = ({ label, unit }: Column, text: string): string => `${label} ${text}${unit && ` ${unit}`}`;

/** Error bars of ± u. */
function bars({ x, y }: Point, places: Places, [across, up]: [Scale, Scale]): string {
  const [left, top] = [places.x(x.value), places.y(y.value)];
  const low = ({ value, u }: Point["x"], { log, from }: Scale) => (log ? Math.max(value - u!, from) : value - u!);
  const horizontal = x.u === null ? "" : `M${places.x(low(x, across))} ${top}H${places.x(Math.min(x.value + x.u, across.to))}`;
  const vertical = y.u === null ? "" : `M${left} ${places.y(low(y, up))}V${places.y(Math.min(y.value + y.u, up.to))}`;
  return horizontal + vertical;
}

function Means({ means, colour, places }: { means: Mean[]; colour: string; places: Places }) {
  return (
    <g className="scatter-means" style={{ color: colour }}>
      {means.map(({ x, y }) => (
        <path key={x} d={`M${places.x(x) - MEAN} ${places.y(y)}h${2 * MEAN}`} />
      ))}
    </g>
  );
}
