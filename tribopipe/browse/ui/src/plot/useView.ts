import { useCallback, useMemo, useRef, useState } from "react";

import type { Plot } from "../api";
import { extentOf, rounded, stepped, viewOf, type Step, type View } from "./view";

interface Viewed {
  view: View;
  zoom(view: View): void;
  step(step: Step): void;
}

/** What is looked at: at once what was asked for, drawn from the points there are, until the finer ones come. */
export function useView(plot: Plot, onZoom: (from: number | null, to: number | null) => void): Viewed {
  const answered = `${plot.name} ${plot.x.name} ${plot.x.from} ${plot.x.to}`;
  const [asked, setAsked] = useState<View | null>(null);
  const [before, setBefore] = useState(answered);
  if (answered !== before) {
    setBefore(answered);
    setAsked(null);
  }
  const whole = useMemo(() => viewOf(plot), [plot]);
  const view = asked ?? whole;
  const latest = useRef({ view, plot, onZoom });
  latest.current = { view, plot, onZoom };

  const zoom = useCallback((wanted: View) => {
    const next = rounded(wanted);
    if (next === null) return;
    setAsked(next);
    latest.current.onZoom(next.from, next.to);
  }, []);

  const step = useCallback(
    (wanted: Step) => {
      const { view: now, plot: drawn } = latest.current;
      const next = stepped(now, wanted, extentOf(drawn));
      if (next === null) latest.current.onZoom(null, null);
      else if (next !== now) zoom(next);
    },
    [zoom],
  );

  return { view, zoom, step };
}
