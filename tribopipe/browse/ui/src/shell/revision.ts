import { useSyncExternalStore } from "react";

import { get } from "../api";

/** What is known of the archive while the page stands open. */
export interface Watch {
  /** Counts the changes of the archive seen so far. */
  changes: number;
  /** Whether the server answered when last asked. */
  reachable: boolean;
}

const EVERY_MS = 3000;

let watch: Watch = { changes: 0, reachable: true };
let known: string | null = null;
let timer: number | undefined;
const listeners = new Set<() => void>();

function tell(next: Watch): void {
  watch = next;
  listeners.forEach((changed) => changed());
}

/** A change, or a server that is back: whatever is shown may be out of date. */
function learn(revision: string): void {
  const before = known;
  known = revision;
  if ((before !== null && before !== revision) || !watch.reachable) {
    tell({ changes: watch.changes + 1, reachable: true });
  }
}

async function ask(): Promise<void> {
  window.clearTimeout(timer);
  try {
    learn((await get<{ revision: string }>("revision")).revision);
  } catch {
    if (watch.reachable) tell({ ...watch, reachable: false });
  }
  window.clearTimeout(timer);
  if (!document.hidden) timer = window.setTimeout(() => void ask(), EVERY_MS);
}

/** Ask for the archive's revision now and every few seconds; a hidden tab asks nothing. */
export function watchArchive(): void {
  document.addEventListener("visibilitychange", () => {
    if (!document.hidden) void ask();
  });
  void ask();
}

function subscribe(changed: () => void): () => void {
  listeners.add(changed);
  return () => listeners.delete(changed);
}

export const useWatch = (): Watch => useSyncExternalStore(subscribe, () => watch);
