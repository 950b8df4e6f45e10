import type { Cell, Column, Runs } from "../api";
import { compareCells, textOf } from "./cells";

/** A run in the table, with its cells by name of column. */
export interface Row {
  id: string;
  cell(column: string): Cell;
  /** The text beneath others of its column, under the unit of the heading. */
  shown(column: string): string;
}

/** The rows of an answer. */
export function rowsOf(runs: Runs): Row[] {
  const places = new Map(runs.columns.map((name, place) => [name, place]));
  return runs.ids.map((id, number) => {
    const cell = (column: string): Cell => runs.rows[number]?.[places.get(column) ?? -1] ?? null;
    return { id, cell, shown: (column) => runs.aligned[column]?.texts[number] ?? textOf(cell(column)) };
  });
}

/** Columns with the units under which their rows are shown. */
export const headed = (columns: Column[], { aligned }: Runs): Column[] =>
  columns.map((column) => ({ ...column, unit: aligned[column.name]?.unit ?? column.unit }));

/** Columns named in the address, in the archive's order; without an address the usual ones that say something. */
export function chosenColumns(columns: Column[], named: string | null, rows: Row[]): Column[] {
  const names = named?.split(",");
  const isUsual = ({ name, shown }: Column) => shown && rows.some((row) => row.cell(name) !== null);
  return columns.filter((column) => column.name !== "id" && (names ? names.includes(column.name) : isUsual(column)));
}

/** Rows in which every word of a search stands, in the id or a shown column. */
export function matching(rows: Row[], columns: Column[], search: string): Row[] {
  const words = search.toLowerCase().split(/\s+/).filter(Boolean);
  if (words.length === 0) return rows;
  return rows.filter((row) => {
    const text = [row.id, ...columns.map(({ name }) => textOf(row.cell(name)))].join("\n").toLowerCase();
    return words.every((word) => text.includes(word));
  });
}

/** By which column the table is sorted; "-k_d" in an address is from the largest down. */
export interface Sort {
  column: string;
  descending: boolean;
}

export function sortOf(text: string | null): Sort {
  const descending = text?.startsWith("-") ?? false;
  return { column: (descending ? text?.slice(1) : text) || "id", descending };
}

export const sortText = ({ column, descending }: Sort): string => (descending ? `-${column}` : column);

/** Rows in order; equal ones stay as they were. */
export function sorted(rows: Row[], { column, descending }: Sort): Row[] {
  const cellOf = (row: Row): Cell => (column === "id" ? row.id : row.cell(column));
  return rows.toSorted((a, b) => compareCells(cellOf(a), cellOf(b), descending));
}
