import { useCallback, useMemo, useState } from "react";

import type { Runs } from "../api";
import { useAnswer } from "../shell/useAnswer";
import { rowsOf, type Row } from "./listing";

/** Runs that are asked for at once; no more are searched and sorted in the browser. As in browse/library.py. */
export const AT_ONCE = 500;

type Question = Record<string, string>;

/** The question for a part of the runs; the first one has the number 0. */
export const partOf = (question: Question, number: number): Record<string, string | number> => ({
  ...question,
  start: number * AT_ONCE,
  most: AT_ONCE,
});

interface Parts {
  /** Number of runs; null where it is not known yet. */
  total: number | null;
  /** A row by its place; none where it is not here yet. */
  rowAt(place: number): Row | undefined;
  stale: boolean;
  onSight(first: number, last: number): void;
}

/** Rows of a long list: those in sight are asked for, which are in two parts at most. */
export function useParts(question: Question): Parts {
  const [upper, setUpper] = useState(0);
  const [lower, setLower] = useState(0);
  const above = useAnswer<Runs>("runs", partOf(question, upper));
  const below = useAnswer<Runs>(lower === upper ? null : "runs", partOf(question, lower));
  const rowAt = useRows(above.answer, lower === upper ? null : below.answer);
  const onSight = useCallback((first: number, last: number) => {
    setUpper(Math.floor(first / AT_ONCE));
    setLower(Math.floor(last / AT_ONCE));
  }, []);
  return { total: above.answer?.total ?? null, rowAt, stale: above.stale || (lower !== upper && below.stale), onSight };
}

function useRows(above: Runs | null, below: Runs | null): (place: number) => Row | undefined {
  return useMemo(() => {
    const parts = [above, below].flatMap((runs) => (runs ? [{ start: runs.start, rows: rowsOf(runs) }] : []));
    return (place) => rowIn(parts, place);
  }, [above, below]);
}

/** The row at a place of the whole list. */
export function rowIn(parts: { start: number; rows: Row[] }[], place: number): Row | undefined {
  return parts.map(({ start, rows }) => rows[place - start]).find((row) => row !== undefined);
}
