import "uplot/dist/uPlot.min.css";
import "./plot.css";

import { useCallback, useId, useMemo, useState, type KeyboardEvent } from "react";

import type { Panel, Plot } from "../api";
import type { Pointed } from "./axes";
import { kindEntries } from "./entries";
import { stepOf } from "./keys";
import { heights } from "./layout";
import { read } from "./numbers";
import { PanelView } from "./PanelView";
import { Sample } from "./Sample";
import { colouringOf, type Colouring } from "./strokes";
import { styledPanel } from "./styled";
import { sizeText } from "./summary";
import { useColours } from "./useColours";
import { useView } from "./useView";
import { ZoomTools } from "./ZoomTools";

interface Props {
  plot: Plot;
  /** Asks for a part of the horizontal axis, in its unit; null for all of it. */
  onZoom(from: number | null, to: number | null): void;
  /** Of one panel, in pixels. */
  height?: number;
  /** What colours tell apart; runs, where there are several. */
  colourBy?: "role" | "run";
  /** Whether the legend has one entry per run instead of one per line. */
  legendByRun?: boolean;
  /** Runs in the order of their colours; as they come in the plot by default. */
  runs?: string[];
}

export const HEIGHT = 380;

/** A plot: panels on one horizontal axis, zoomed by dragging, keys and buttons. */
export default function PlotView({ plot, onZoom, height = HEIGHT, colourBy, legendByRun = false, runs }: Props) {
  const { view, zoom, step } = useView(plot, onZoom);
  const [at, point] = useState<number | null>(null);
  const [hidden, toggle] = useToggles();
  const [sync, help] = [useId(), useId()];
  const panels = useMemo(() => plot.panels.filter(({ lines, marks }) => lines.length + marks.length > 0), [plot]);
  const tall = heights(panels, height);
  const order = runs?.join("\n");
  const colouring = useMemo(() => colouringOf(plot, colourBy, runs), [plot, colourBy, order]);
  const pointed = useMemo<Pointed>(
    () => ({ onSelect: zoom, onWhole: () => step("whole"), onPoint: point }),
    [zoom, step],
  );

  const stepByKey = (event: KeyboardEvent) => {
    const wanted = event.target === event.currentTarget ? stepOf(event) : null;
    if (wanted === null) return;
    event.preventDefault();
    step(wanted);
  };

  return (
    <div className="plot">
      <div className="plot-bar">
        <span className="soft">{sizeText(plot)}</span>
        <ZoomTools title={plot.title} onStep={step} />
      </div>
      {legendByRun && <LineKinds panels={panels} colouring={colouring} />}
      <div
        className="plot-panels"
        role="group"
        aria-label={plot.title}
        aria-describedby={help}
        tabIndex={0}
        onKeyDown={stepByKey}
      >
        {panels.map((panel, place) => (
          <PanelView
            key={`${place} ${panel.label}`}
            panel={panel}
            x={plot.x}
            view={view}
            height={tall[place]!}
            numbered={place === panels.length - 1}
            colouring={colouring}
            legendByRun={legendByRun}
            hidden={hidden}
            at={at}
            sync={sync}
            pointed={pointed}
            onToggle={toggle}
          />
        ))}
      </div>
      <div className="plot-foot">
        <p className="plot-x">{plot.x.label}</p>
        <p className="plot-value">{at === null ? "" : read(at)}</p>
        <p id={help} className="plot-help">
          Drag to zoom, double-click for the full range. Keys: <kbd>+</kbd> <kbd>−</kbd> <kbd>←</kbd> <kbd>→</kbd>{" "}
          <kbd>0</kbd>
        </p>
      </div>
    </div>
  );
}

/** What thin, solid and dashed lines are, for all runs at once. */
function LineKinds({ panels, colouring }: { panels: Panel[]; colouring: Colouring }) {
  const colour = useColours();
  const kinds = kindEntries(panels.map((panel) => styledPanel(panel, colouring, colour)));
  return (
    <ul className="plot-kinds" aria-label="Line styles">
      {kinds.map(({ key, name, stroke, kind }) => (
        <li key={key}>
          <Sample stroke={stroke} kind={kind} />
          {name}
        </li>
      ))}
    </ul>
  );
}

/** Keys of what is hidden, and a way to hide one or show it again. */
function useToggles(): [ReadonlySet<string>, (key: string) => void] {
  const [hidden, setHidden] = useState<ReadonlySet<string>>(() => new Set<string>());
  const toggle = useCallback((key: string) => {
    setHidden((before) => {
      const after = new Set(before);
      if (!after.delete(key)) after.add(key);
      return after;
    });
  }, []);
  return [hidden, toggle];
}
