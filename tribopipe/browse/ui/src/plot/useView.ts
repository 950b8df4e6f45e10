import { useCallback, useRef, useState } from "react";

import type { Plot } from "../api";
import { ANYWHERE, learnt, rounded, stepped, viewOf, type Step, type View } from "./view";

interface Viewed {
  view: View;
  zoom(view: View): void;
  step(step: Step): void;
}

interface Held {
  plot: Plot;
  /** What was asked for since that plot came. */
  asked: View | null;
  /** Where the axis ends, as far as is known. */
  ends: View;
}

/** What is looked at: at once what was asked for, drawn from the points there are, until the finer ones come. */
export function useView(plot: Plot, onZoom: (from: number | null, to: number | null) => void): Viewed {
  const [held, setHeld] = useState<Held>(() => ({ plot, asked: null, ends: learnt(ANYWHERE, plot) }));
  if (held.plot !== plot) setHeld(taken(plot, held));
  const view = held.asked ?? viewOf(plot);
  const latest = useRef({ view, ends: held.ends, onZoom });
  latest.current = { view, ends: held.ends, onZoom };

  const zoom = useCallback((wanted: View) => {
    const asked = rounded(wanted);
    if (asked === null) return;
    setHeld((before) => ({ ...before, asked }));
    latest.current.onZoom(asked.from, asked.to);
  }, []);

  const step = useCallback(
    (wanted: Step) => {
      const now = latest.current;
      const next = stepped(now.view, wanted, now.ends);
      if (next === null) now.onZoom(null, null);
      else if (next !== now.view) zoom(next);
    },
    [zoom],
  );

  return { view, zoom, step };
}

/** Take another plot: what was asked for is there once another range came; another axis ends elsewhere. */
function taken(plot: Plot, { plot: before, asked, ends }: Held): Held {
  const isAxis = plot.name === before.name && plot.x.name === before.x.name;
  const isRange = isAxis && plot.x.from === before.x.from && plot.x.to === before.x.to;
  return { plot, asked: isRange ? asked : null, ends: learnt(isAxis ? ends : ANYWHERE, plot) };
}
