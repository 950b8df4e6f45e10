import { useEffect, useMemo, useState } from "react";

import { ApiError, get } from "../api";
import { useWatch } from "./revision";

export interface Answered<T> {
  /** The newest answer there is; after a change of the query, or a failure, the one before. */
  answer: T | null;
  error: ApiError | null;
  /** Nothing can be shown yet. */
  loading: boolean;
  /** The answer is of another query or an earlier state of the archive. */
  stale: boolean;
}

type Query = Record<string, string | number>;

interface Held {
  path: string;
  question: string;
  answer: unknown;
  error: ApiError | null;
}

/** Answers that pages left behind, so that going back shows them at once while they are asked for again. */
const left = new Map<string, unknown>();
const LEFT_AT_MOST = 12;

function remember(question: string, answer: unknown): void {
  left.delete(question);
  left.set(question, answer);
  const oldest = left.keys().next();
  if (left.size > LEFT_AT_MOST && !oldest.done) left.delete(oldest.value);
}

/** What failed; a thing that is gone takes its answer with it. */
function failed(path: string, question: string, error: ApiError): (held: Held | null) => Held {
  return (held) => {
    if (error.status === 404) left.delete(question);
    const kept = held?.path === path && error.status !== 404 ? held.answer : null;
    return { path, question, answer: kept, error };
  };
}

/** Ask the server; asked anew whenever path, query or archive change. A path of null asks nothing; "" is not sent. */
export function useAnswer<T>(path: string | null, query: Query = {}): Answered<T> {
  const { changes } = useWatch();
  const question = JSON.stringify([path, query]);
  const [held, setHeld] = useState<Held | null>(null);

  useEffect(() => {
    if (path === null) return;
    const abort = new AbortController();
    get<T>(path, said(question), abort.signal).then(
      (answer) => {
        if (abort.signal.aborted) return;
        remember(question, answer);
        setHeld({ path, question, answer, error: null });
      },
      (error: unknown) => {
        if (!abort.signal.aborted) setHeld(failed(path, question, asApiError(error)));
      },
    );
    return () => abort.abort();
  }, [path, question, changes]);

  return useMemo(() => toShow<T>(path, question, held), [path, question, held]);
}

/** The query of a question, without its empty parts. */
function said(question: string): Query {
  const [, query] = JSON.parse(question) as [string, Query];
  return Object.fromEntries(Object.entries(query).filter(([, value]) => value !== ""));
}

function asApiError(error: unknown): ApiError {
  return error instanceof ApiError ? error : new ApiError(0, String(error));
}

function toShow<T>(path: string | null, question: string, held: Held | null): Answered<T> {
  const current = held !== null && held.question === question;
  const error = current ? held.error : null;
  const kept = held !== null && held.path === path ? held.answer : null;
  const gone = error?.status === 404;
  const answer = (gone ? null : ((current ? kept : left.get(question)) ?? kept)) as T | null;
  return { answer, error, loading: path !== null && answer === null && error === null, stale: !current || error !== null };
}
