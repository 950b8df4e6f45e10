import { useLayoutEffect, useState, type RefObject } from "react";

const STEP = 200;
/** The server makes no finer plot. */
const MOST = 4000;

/** How many pixels of the screen an element has side by side; in steps, so that resizing seldom asks anew. */
export function useColumns(element: RefObject<HTMLElement>): number {
  const [columns, setColumns] = useState(0);
  useLayoutEffect(() => {
    const box = element.current!;
    const measure = () => setColumns(inSteps(box.clientWidth * devicePixelRatio));
    measure();
    const observer = new ResizeObserver(measure);
    observer.observe(box);
    return () => observer.disconnect();
  }, [element]);
  return columns;
}

const inSteps = (pixels: number): number => Math.min(Math.ceil(pixels / STEP) * STEP, MOST);
