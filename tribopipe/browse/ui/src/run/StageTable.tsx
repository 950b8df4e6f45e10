import type { TextTable as Table } from "../api";
import { TextTable } from "../components/TextTable";
import { Budget } from "./Budget";

/** A table of a stage; a budget with its shares as bars. Nothing is said of a table without rows. */
export function StageTable({ table }: { table: Table }) {
  if (table.rows.length === 0) return null;
  return table.columns.at(-1)?.startsWith("share of ") ? <Budget table={table} /> : <TextTable table={table} />;
}
