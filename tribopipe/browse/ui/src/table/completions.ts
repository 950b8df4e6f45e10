import type { Column } from "../api";
import { textOf } from "./cells";
import type { Row } from "./listing";

export interface Completion {
  /** The whole filter, completed. */
  value: string;
  label: string;
}

const OFFERED = 50;
/** The last term of a filter: name, operator, and what is typed of the value. */
const TERM = /(?:^|\s)(?<name>[a-z]\w*)(?<operator>!=|[=~])(?<begun>[^=~<>!]*)$/i;
/** What must be quoted, as it looks like another term. */
const UNCLEAR = /["'=~<>!]/;

/** The filter with its last word completed: to the name of a column, or to a value that some run has. */
export function completions(text: string, columns: Column[], rows: Row[]): Completion[] {
  const { name = "", begun = "" } = TERM.exec(text)?.groups ?? {};
  const column = columns.find((one) => one.name === name.toLowerCase());
  if (column === undefined) return names(text, columns);
  const typed = begun.replace(/^"/, "").toLowerCase();
  const ahead = text.slice(0, text.length - begun.length);
  return values(column, rows)
    .filter((value) => value.toLowerCase().startsWith(typed) && value !== begun)
    .slice(0, OFFERED)
    .map((value) => ({ value: ahead + written(value), label: column.label }));
}

function names(text: string, columns: Column[]): Completion[] {
  const begun = /[^\s!]*$/.exec(text)?.[0] ?? "";
  const ahead = text.slice(0, text.length - begun.length);
  return columns
    .filter(({ name }) => name.startsWith(begun) && name !== begun)
    .map(({ name, label, unit }) => ({ value: ahead + name, label: unit ? `${label}, ${unit}` : label }));
}

/** Texts of the runs in a column, and days of its dates; numbers are not completed. */
function values({ name, kind, joint }: Column, rows: Row[]): string[] {
  if (kind === "number") return [];
  const texts = rows.map((row) => textOf(row.cell(name)));
  const parts = kind === "date" ? texts.map((date) => date.slice(0, 10)) : texts.flatMap((one) => split(one, joint));
  return [...new Set(parts)].filter(Boolean).toSorted((a, b) => a.localeCompare(b, "en", { numeric: true }));
}

const split = (text: string, joint: string | null | undefined): string[] => (joint ? text.split(joint) : [text]);

const written = (value: string): string => (UNCLEAR.test(value) ? `"${value.replaceAll('"', '""')}"` : value);
