import type { Column } from "../api";
import { textOf } from "../table/cells";
import type { Row } from "../table/listing";

/** What heads the columns, and a checksum, which differs between any two runs. */
const OMITTED = new Set(["id", "run_toml"]);

/** Columns of the list that say something of some run, as lines side by side. */
export const linesOf = (columns: Column[], rows: Row[]): Column[] =>
  columns.filter(({ name }) => !OMITTED.has(name) && rows.some((row) => textOf(row.cell(name)) !== ""));

/** Whether all of several runs have the same in a column. */
export const isSame = (name: string, rows: Row[]): boolean =>
  rows.length > 1 && new Set(rows.map((row) => textOf(row.cell(name)))).size === 1;
