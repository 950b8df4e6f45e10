import type { Column } from "../api";

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

/** A value that is being typed. */
export interface BegunValue {
  column: Column;
  /** As it stands in the filter. */
  written: string;
  /** Without the quotation mark. */
  begins: string;
}

/** The value with which a filter ends; null where it ends with something else. */
export function begunValue(text: string, columns: Column[]): BegunValue | null {
  const { name = "", begun = "" } = TERM.exec(text)?.groups ?? {};
  const column = columns.find((one) => one.name === name.toLowerCase());
  return column === undefined ? null : { column, written: begun, begins: begun.replace(/^"/, "") };
}

/** The filter with its last word completed: to the name of a column, or to one of the values that runs have in it. */
export function completions(text: string, columns: Column[], values: string[]): Completion[] {
  const begun = begunValue(text, columns);
  if (begun === null) return names(text, columns);
  const { column, begins } = begun;
  const ahead = text.slice(0, text.length - begun.written.length);
  return values
    .filter((value) => value.toLowerCase().startsWith(begins.toLowerCase()) && value !== begun.written)
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

const written = (value: string): string => (UNCLEAR.test(value) ? `"${value.replaceAll('"', '""')}"` : value);
