import { useLayoutEffect, useRef, type RefObject } from "react";

/** Keeps an element as tall as it was, while its width stays and other things fill it: what is below does not jump. */
export function useTallest(filling: unknown): RefObject<HTMLDivElement> {
  const element = useRef<HTMLDivElement>(null);
  const width = useRef(0);
  useLayoutEffect(() => {
    const box = element.current!;
    if (box.offsetWidth !== width.current) box.style.minHeight = "";
    width.current = box.offsetWidth;
    box.style.minHeight = `${box.offsetHeight}px`;
  }, [filling]);
  return element;
}
