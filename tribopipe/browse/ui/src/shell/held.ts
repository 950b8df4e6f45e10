import type { ApiError } from "../api";

export interface Answered<T> {
  /** The newest answer there is; after a change of the query, or a failure, the one before. */
  answer: T | null;
  error: ApiError | null;
  /** Nothing can be shown yet. */
  loading: boolean;
  /** The answer is of another query or an earlier state of the archive. */
  stale: boolean;
}

/** What came of the last question that was settled. */
export interface Held {
  path: string;
  question: string;
  answer: unknown;
  error: ApiError | null;
}

/** Answers that pages left behind, so that going back shows them at once while they are asked for again. */
const left = new Map<string, unknown>();
const LEFT_AT_MOST = 12;

/** Keep an answer for pages to come; the one that was left longest ago makes room. */
export function remember(question: string, answer: unknown): void {
  left.delete(question);
  left.set(question, answer);
  const oldest = left.keys().next();
  if (left.size > LEFT_AT_MOST && !oldest.done) left.delete(oldest.value);
}

/** What failed; a thing that is gone takes its answer with it. */
export function failed(path: string, question: string, error: ApiError): (held: Held | null) => Held {
  return (held) => {
    if (error.status === 404) left.delete(question);
    const kept = held?.path === path && error.status !== 404 ? held.answer : null;
    return { path, question, answer: kept, error };
  };
}

/** What a page shows for a question, by what it holds and by what earlier pages left behind. */
export function toShow<T>(path: string | null, question: string, held: Held | null): Answered<T> {
  const current = held !== null && held.question === question;
  const error = current ? held.error : null;
  const kept = held !== null && held.path === path ? held.answer : null;
  const gone = error?.status === 404;
  const answer = (gone ? null : ((current ? kept : left.get(question)) ?? kept)) as T | null;
  return { answer, error, loading: path !== null && answer === null && error === null, stale: !current || error !== null };
}
