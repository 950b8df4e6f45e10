import { useSyncExternalStore } from "react";

/** As table.css has it: on a phone a name takes two lines. */
const NARROW = window.matchMedia("(width <= 700px)");
const ROW_REM = 2.2;
const NARROW_ROW_REM = 3;

function subscribe(changed: () => void): () => void {
  NARROW.addEventListener("change", changed);
  return () => NARROW.removeEventListener("change", changed);
}

/** Height of a row in px. */
export function useRowHeight(): number {
  const narrow = useSyncExternalStore(subscribe, () => NARROW.matches);
  const rem = parseFloat(getComputedStyle(document.documentElement).fontSize);
  return rem * (narrow ? NARROW_ROW_REM : ROW_REM);
}
