import type { Cell } from "../api";

/** A cell as it is written; "" where nothing is known. */
export function textOf(cell: Cell | undefined): string {
  if (cell === null || cell === undefined) return "";
  return typeof cell === "string" ? cell : cell[1];
}

const collator = new Intl.Collator("en", { numeric: true, sensitivity: "base" });

/** Numbers by size, texts as people sort them; what is unknown comes last, whichever way round. */
export function compareCells(a: Cell, b: Cell, descending: boolean): number {
  if (isUnknown(a) || isUnknown(b)) return Number(isUnknown(a)) - Number(isUnknown(b));
  const way = descending ? -1 : 1;
  if (Array.isArray(a) && Array.isArray(b)) return way * (a[0] - b[0]);
  return way * collator.compare(textOf(a), textOf(b));
}

const isUnknown = (cell: Cell): boolean => cell === null || cell === "";
