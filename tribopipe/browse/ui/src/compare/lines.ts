import type { Column } from "../api";
import { textOf } from "../table/cells";
import type { Row } from "../table/listing";

/** Columns of the list that say something of some run, as lines side by side. */
export const linesOf = (columns: Column[], rows: Row[]): Column[] =>
  columns.filter(({ name }) => name !== "id" && rows.some((row) => textOf(row.cell(name)) !== ""));

/** Whether all of several runs have the same in a column. */
export const isSame = (name: string, rows: Row[]): boolean =>
  rows.length > 1 && new Set(rows.map((row) => textOf(row.cell(name)))).size === 1;
