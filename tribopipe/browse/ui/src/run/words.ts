/** An ISO 8601 moment as people read it; any other text as it is. */
export function moment(date: string): string {
  const parts = /^(\d{4}-\d\d-\d\d)T(\d\d:\d\d)(?::\d\d(?:\.\d+)?)?(Z|[+-]\d\d:\d\d)?$/.exec(date);
  if (parts === null) return date;
  const [, day, time, zone = ""] = parts;
  return `${day} ${time} ${zone === "Z" || zone === "+00:00" ? "UTC" : zone}`.trim();
}

const UNITS = ["B", "kB", "MB", "GB"];

/** Bytes in the unit that suits them. */
export function size(bytes: number): string {
  const rounded = Number(bytes.toPrecision(3));
  const place = Math.min(Math.floor(Math.log10(Math.max(rounded, 1)) / 3), UNITS.length - 1);
  const value = bytes / 1000 ** place;
  return `${place === 0 || value >= 100 ? value.toFixed(0) : value.toPrecision(3)} ${UNITS[place]}`;
}

const WITHIN_NUMBER = /(?<=\d) (?=[±%°µmnNGM]|to -?\d)|(?<=\d to) (?=-?\d)|(?<=±) (?=\d)/g;

/** A text whose intervals, and numbers with uncertainty and unit, are not broken between two lines. */
export const unbroken = (text: string): string => text.replace(WITHIN_NUMBER, "\u00a0");

/** "3 runs", "1 run". */
export const counted = (count: number, what: string): string => `${count} ${what}${count === 1 ? "" : "s"}`;
