import { useEffect, useRef, type RefObject } from "react";

import { mendRoles } from "./mend";

const SELECTED = '[role="treeitem"][aria-selected="true"]';

/** Tell which path is looked at as it changes; h5web has no event for that, but marks it in its tree. */
export function useShownPath(tell: (path: string) => void): RefObject<HTMLDivElement> {
  const box = useRef<HTMLDivElement>(null);
  useEffect(() => {
    const viewer = box.current!;
    const look = () => {
      mendRoles(viewer);
      const path = viewer.querySelector<HTMLElement>(SELECTED)?.dataset.path;
      if (path !== undefined) tell(path);
    };
    const observer = new MutationObserver(look);
    observer.observe(viewer, { subtree: true, childList: true, attributeFilter: ["aria-selected"] });
    return () => observer.disconnect();
  }, [tell]);
  return box;
}
