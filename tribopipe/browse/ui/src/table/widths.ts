import type { Column } from "../api";
import type { Row } from "./listing";
import { WIDTH } from "./sparkline";

const AT_MOST_EM = 21;
/** The padding of a cell, and a little more. */
const ROOM_EM = 1.2;
/** The sign of sorting. */
const SIGN_EM = 0.9;
/** The box to tick. */
const BOX_EM = 1.8;

/** Measures texts as the table writes them. */
interface Pen {
  em: number;
  width(text: string, weight?: number): number;
}

function pen(): Pen {
  const { fontFamily } = getComputedStyle(document.body);
  const em = parseFloat(getComputedStyle(document.documentElement).fontSize);
  const context = document.createElement("canvas").getContext("2d");
  const width = (text: string, weight = 400): number => {
    if (!context) return text.length * em * 0.6;
    context.font = `${weight} ${em}px ${fontFamily}`;
    return context.measureText(text).width;
  };
  return { em, width };
}

const longest = (texts: string[]): string => texts.reduce((most, text) => (text.length > most.length ? text : most), "");

/** Widths of the first column, of the curves and of the others, in px: fixed for all rows, so that nothing jumps while scrolling. */
export function columnWidths(columns: Column[], rows: Row[]): number[] {
  const { em, width } = pen();
  const within = (px: number): number => Math.ceil(Math.min(AT_MOST_EM * em, px) + ROOM_EM * em);
  const ids = width(longest(rows.map(({ id }) => id)), 600);
  return [within(ids + BOX_EM * em), within(WIDTH), ...columns.map((column) => within(widest(column)))];

  function widest({ name, label, unit }: Column): number {
    const cell = width(longest(rows.map((row) => row.shown(name))));
    const head = Math.max(...label.split(" ").map((word) => width(word, 600)));
    return Math.max(cell, head + SIGN_EM * em, width(unit));
  }
}
