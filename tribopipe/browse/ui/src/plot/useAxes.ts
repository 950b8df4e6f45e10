import { useLayoutEffect, useRef, type RefObject } from "react";
import uPlot from "uplot";

import { axesOptions, NO_SERIES, type Drawn, type Pointed } from "./axes";

/** Draws on the element that takes the reference, as wide as it is, and anew whenever what is drawn changes. */
export function useAxes(drawn: Drawn, pointed: Pointed, sync: string): RefObject<HTMLDivElement> {
  const box = useRef<HTMLDivElement>(null);
  const plot = useRef<uPlot | null>(null);
  const latest = useRef({ drawn, pointed });
  latest.current = { drawn, pointed };

  useLayoutEffect(() => {
    const element = box.current!;
    const size = () => ({ width: element.clientWidth, height: latest.current.drawn.height });
    const options = axesOptions(() => latest.current.drawn, () => latest.current.pointed, sync);
    const made = new uPlot({ ...options, ...size() }, NO_SERIES, element);
    plot.current = made;
    const observer = new ResizeObserver(() => {
      if (element.clientWidth !== made.width) made.setSize(size());
    });
    observer.observe(element);
    return () => {
      observer.disconnect();
      made.destroy();
      plot.current = null;
    };
  }, [sync]);

  useLayoutEffect(() => {
    if (plot.current) show(plot.current, drawn);
  }, [drawn]);

  return box;
}

function show(plot: uPlot, { view, range, height }: Drawn): void {
  plot.batch(() => {
    if (height !== plot.height) plot.setSize({ width: plot.width, height });
    plot.setScale("x", { min: view.from, max: view.to });
    plot.setScale("y", { min: range[0], max: range[1] });
  });
}
