import { createContext, useContext, type ReactNode } from "react";

import type { Archive } from "../api";
import type { Answered } from "./held";
import { useAnswer } from "./useAnswer";

const Held = createContext<Answered<Archive>>({ answer: null, error: null, loading: true, stale: false });

/** Ask for the archive once, for everything within. */
export function ArchiveProvider({ children }: { children: ReactNode }) {
  return <Held.Provider value={useAnswer<Archive>("archive")}>{children}</Held.Provider>;
}

/** What the archive is called, which columns its runs have, which files could not be read. */
export const useArchive = (): Answered<Archive> => useContext(Held);
