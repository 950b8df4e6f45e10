import { useEffect } from "react";

/** Go to the part that "#…" names once the page is there; the browser looked for it before. */
export function useAnchor(there: boolean): void {
  useEffect(() => {
    if (there && location.hash) document.getElementById(location.hash.slice(1))?.scrollIntoView();
  }, [there]);
}
