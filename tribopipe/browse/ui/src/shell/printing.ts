import { useSyncExternalStore } from "react";
import { flushSync } from "react-dom";

import { dress } from "./theme";

const WAIT_MS = 150;
const LONGEST_MS = 20_000;
const listeners = new Set<() => void>();
let printing = false;

function tell(now: boolean): void {
  printing = now;
  dress(now ? "light" : null);
  // Browsers print the document as it is when the event returns.
  flushSync(() => listeners.forEach((changed) => changed()));
}

/**
 * Follow the browser's own printing; what is folded or out of sight is shown for it, in the light theme.
 *
 * A browser does not wait for plots that were never in sight, so that its key is taken over; its menu cannot be.
 */
export function watchPrinting(): void {
  window.addEventListener("beforeprint", () => tell(true));
  window.addEventListener("afterprint", () => tell(false));
  window.addEventListener("keydown", (event) => {
    if (!(event.ctrlKey || event.metaKey) || event.shiftKey || event.altKey || event.key.toLowerCase() !== "p") return;
    event.preventDefault();
    void printWhole();
  });
}

/** Print the whole page: wait for the plots that were not in sight yet. */
export async function printWhole(): Promise<void> {
  tell(true);
  const end = Date.now() + LONGEST_MS;
  do {
    await new Promise((resolve) => window.setTimeout(resolve, WAIT_MS));
  } while (document.querySelector("[aria-busy=true]") !== null && Date.now() < end);
  window.print();
}

function subscribe(changed: () => void): () => void {
  listeners.add(changed);
  return () => listeners.delete(changed);
}

/** Whether the page is being printed. */
export const usePrinting = (): boolean => useSyncExternalStore(subscribe, () => printing);
