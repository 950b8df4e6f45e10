import { useEffect, useState } from "react";

import { ApiError } from "../api";
import { useWatch } from "../shell/revision";

type Attributes = Record<string, unknown>;

/** Where to open a file, or why it cannot be opened. */
export interface Opening {
  path: string | null;
  error: ApiError | null;
}

const DEEPEST = 8;

/** Ask for the attributes of a group or dataset; an `ApiError` where the file or the path is not there. */
async function attributes(file: string, path: string, signal: AbortSignal): Promise<Attributes> {
  const answer = await fetch(`/h5/attr?${new URLSearchParams({ file, path })}`, { signal });
  const body = (await answer.json().catch(() => ({}))) as Attributes;
  if (!answer.ok) throw new ApiError(answer.status, String(body.error ?? answer.statusText));
  return body;
}

/** Follow NeXus's @default from the root to what the file wants to be seen first. */
export async function preferred(file: string, signal: AbortSignal): Promise<string> {
  let path = "/";
  for (let depth = 0; depth < DEEPEST; depth++) {
    const { default: next } = await attributes(file, path, signal);
    if (typeof next !== "string" || next === "" || next === ".") break;
    path = `${path === "/" ? "" : path}/${next}`;
  }
  return path;
}

/** Where to open a file: at the path that is asked for, or at what it prefers. Looked at anew as the archive changes. */
export function useOpening(file: string, asked: string): Opening {
  const { changes } = useWatch();
  const [opening, setOpening] = useState<Opening>({ path: null, error: null });
  useEffect(() => {
    if (file === "") return;
    const abort = new AbortController();
    const found = asked === "" ? preferred(file, abort.signal) : attributes(file, asked, abort.signal).then(() => asked);
    found.then(
      (path) => setOpening({ path, error: null }),
      (error: unknown) => {
        if (!abort.signal.aborted) setOpening({ path: null, error: told(error) });
      },
    );
    return () => abort.abort();
  }, [file, asked, changes]);
  return opening;
}

const told = (error: unknown): ApiError =>
  error instanceof ApiError ? error : new ApiError(0, "The server does not respond; start `tribopipe browse` again.");
