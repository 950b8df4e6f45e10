import { useMemo, useRef } from "react";

import type { Plot } from "../api";
import { Empty } from "../components/Empty";
import { Failure } from "../components/Failure";
import { Loading } from "../components/Loading";
import PlotView from "../plot/PlotView";
import { useColumns } from "../plot/useColumns";
import { setQuery } from "../shell/router";
import { useAnswer } from "../shell/useAnswer";
import { extrasText, type Asked } from "./asked";

const HEIGHT = 420;

/** All runs on one axis, in the colours of their places in the list. */
export function ComparedPlot({ asked, ids }: { asked: Asked; ids: string[] }) {
  const card = useRef<HTMLElement>(null);
  const width = useColumns(card);
  const { answer, error } = useAnswer<Plot>(width > 0 ? `compare/${asked.what}` : null, {
    runs: ids.join(","),
    with: extrasText(asked.fits, asked.predictions, ""),
    x: asked.x,
    from: asked.from,
    to: asked.to,
    width,
  });
  const zoom = (from: number | null, to: number | null) =>
    setQuery({ from: from === null ? null : String(from), to: to === null ? null : String(to) }, { replace: true });

  return (
    <section className="card" ref={card} aria-label="Plot">
      {error && <Failure error={error} />}
      {answer ? <Drawn plot={answer} ids={ids} onZoom={zoom} /> : error === null && <Loading what="the plot" />}
    </section>
  );
}

interface Props {
  plot: Plot;
  ids: string[];
  onZoom(from: number | null, to: number | null): void;
}

function Drawn({ plot, ids, onZoom }: Props) {
  const named = useMemo(() => withRuns(plot), [plot]);
  if (!plot.panels.some(({ lines, marks }) => lines.length + marks.length > 0)) {
    return <Empty title="These runs have no data for this plot." />;
  }
  const without = ids.filter((id) => !hasData(plot, id));
  return (
    <>
      <PlotView plot={named} onZoom={onZoom} height={HEIGHT} colourBy="run" legendByRun runs={ids} />
      {without.length > 0 && <p className="soft">No data for this plot: {without.join(", ")}</p>}
    </>
  );
}

const hasData = ({ panels }: Plot, id: string): boolean =>
  panels.some(({ lines, marks }) => [...lines, ...marks].some(({ run }) => run === id));

/** The plot with the run in the name of everything: lines of several runs are called alike. */
function withRuns(plot: Plot): Plot {
  const named = <T extends { name: string; run: string }>(one: T): T => ({ ...one, name: `${one.run}: ${one.name}` });
  const panels = plot.panels.map((panel) => ({
    ...panel,
    lines: panel.lines.map(named),
    marks: panel.marks.map(named),
  }));
  return { ...plot, panels };
}
