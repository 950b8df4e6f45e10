import { useEffect, useMemo, useState } from "react";

import { ApiError, get } from "../api";
import { failed, remember, toShow, type Answered, type Held } from "./held";
import { useWatch } from "./revision";

type Query = Record<string, string | number>;

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
