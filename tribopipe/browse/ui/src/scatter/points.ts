import type { Column } from "../api";
import { textOf } from "../table/cells";
import type { Row } from "../table/listing";

/** A number in the unit of its column, as it is written, and its standard uncertainty where known. */
export interface Coordinate {
  value: number;
  text: string;
  u: number | null;
}

export interface Point {
  id: string;
  x: Coordinate;
  y: Coordinate;
  bad: boolean;
  /** Bodies and conditions, the same for replicates. */
  test: string;
}

/** Points of one pair of materials, in one color. */
export interface Group {
  name: string;
  points: Point[];
}

/** The mean of replicates. */
export interface Mean {
  x: number;
  y: number;
  count: number;
}

/** Columns of numbers that at least one run has. */
export function quantities(columns: Column[], rows: Row[]): Column[] {
  return columns.filter(({ name, kind }) => kind === "number" && rows.some((row) => Array.isArray(row.cell(name))));
}

/** "k_D / mm³/(N·mm)" */
export const quantityLabel = ({ label, unit }: Column): string => (unit ? `${label} / ${unit}` : label);

/** "Si3N4 on steel": the materials of the two bodies. */
export function materialPair(row: Row): string {
  const first = textOf(row.cell("pin_material")) || textOf(row.cell("curved_disc_material"));
  const second = textOf(row.cell("disc_material")) || textOf(row.cell("flat_disc_material"));
  return [first, second].filter(Boolean).join(" on ") || "unknown materials";
}

export function coordinate(row: Row, { name, factor = 1, offset = 0 }: Column): Coordinate | null {
  const cell = row.cell(name);
  if (!Array.isArray(cell) || !Number.isFinite(cell[0])) return null;
  const [value, text, u] = cell;
  return { value: factor * value + offset, text, u: u === undefined ? null : factor * u };
}

const ALIKE = ["tribometer", "shape", "radius", "medium", "load", "speed", "slip", "distance", "rotations"];

/** What replicates have in common, next to their materials. */
const testOf = (row: Row): string => JSON.stringify(ALIKE.map((name) => textOf(row.cell(name))));

/** Runs with both quantities, grouped by materials in the order of their names. */
export function grouped(rows: Row[], x: Column, y: Column): Group[] {
  const pointsOf = (row: Row): Point[] => {
    const [across, up] = [coordinate(row, x), coordinate(row, y)];
    if (across === null || up === null) return [];
    return [{ id: row.id, x: across, y: up, bad: textOf(row.cell("mark")) !== "", test: testOf(row) }];
  };
  return [...groupedBy(rows, materialPair)]
    .map(([name, alike]) => ({ name, points: alike.flatMap(pointsOf).toSorted((a, b) => a.x.value - b.x.value) }))
    .filter(({ points }) => points.length > 0)
    .toSorted((a, b) => a.name.localeCompare(b.name, "en"));
}

/** Means of replicates that are not marked bad. */
export function replicateMeans({ points }: Group): Mean[] {
  return [...groupedBy(points.filter(({ bad }) => !bad), ({ test }) => test).values()]
    .filter((replicates) => replicates.length > 1)
    .map((replicates) => ({
      x: mean(replicates.map(({ x }) => x.value)),
      y: mean(replicates.map(({ y }) => y.value)),
      count: replicates.length,
    }));
}

function groupedBy<T>(all: T[], keyOf: (one: T) => string): Map<string, T[]> {
  const groups = new Map<string, T[]>();
  for (const one of all) {
    const group = groups.get(keyOf(one));
    if (group) group.push(one);
    else groups.set(keyOf(one), [one]);
  }
  return groups;
}

const mean = (values: number[]): number => values.reduce((sum, value) => sum + value, 0) / values.length;

/** What is not in the plot: "2 runs have no k_D." */
export function missing(rows: Row[], columns: Column[]): string[] {
  return [...new Set(columns)].flatMap((column) => {
    const count = rows.filter((row) => coordinate(row, column) === null).length;
    return count === 0 ? [] : [`${count === 1 ? "1 run has" : `${count} runs have`} no ${column.label}.`];
  });
}
