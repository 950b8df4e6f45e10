import { memo, useMemo } from "react";

import type { Line, Mark, Panel, Plot } from "../api";
import type { Drawn, Pointed } from "./axes";
import { byRun, lineEntry, markEntry, runEntries, type Reading } from "./entries";
import { isResidual } from "./layout";
import { Legend } from "./Legend";
import { axisExponent, axisLabel } from "./numbers";
import { verticalRange } from "./range";
import type { Colouring } from "./strokes";
import { styledPanel, type Styled, type StyledPanel } from "./styled";
import { panelSummary } from "./summary";
import { useAxes } from "./useAxes";
import { useColours } from "./useColours";
import { useTallest } from "./useTallest";
import type { View } from "./view";

interface Props {
  panel: Panel;
  x: Plot["x"];
  view: View;
  height: number;
  /** Whether numbers stand at the horizontal axis. */
  numbered: boolean;
  colouring: Colouring;
  /** Whether the legend has one entry per run. */
  legendByRun: boolean;
  /** Keys and runs that are not drawn. */
  hidden: ReadonlySet<string>;
  /** Place on the horizontal axis that is read. */
  at: number | null;
  /** Panels of the same name share their pointer. */
  sync: string;
  pointed: Pointed;
  onToggle(key: string): void;
}

/** One vertical axis of a plot with its legend. */
export function PanelView(props: Props) {
  const { panel, x, view, height, numbered, colouring, legendByRun, hidden, at, sync, pointed, onToggle } = props;
  const colour = useColours();
  const styled = useMemo(() => styledPanel(panel, colouring, colour), [panel, colouring, colour]);
  const drawn = useMemo<Drawn>(() => {
    const [lines, marks] = [styled.lines.filter(isShown(hidden)), styled.marks.filter(isShown(hidden))];
    const range = verticalRange(lines.map(({ thing }) => thing), marks.map(({ thing }) => thing), view);
    const zero = isResidual(panel) ? colour("--line-strong") : null;
    const colours = { text: colour("--ink-soft"), grid: colour("--line"), zero };
    return { lines, marks, view, range, exponent: axisExponent(range), height, numbered, colours };
  }, [panel, styled, hidden, colour, view, height, numbered]);

  const head = useTallest(panel);
  const reading = { at, view, unit: 10 ** drawn.exponent };
  const groups = legendByRun
    ? [{ run: "", entries: runEntries(styled, hidden, reading) }]
    : groupsOf(styled, colouring, hidden, reading);

  return (
    <div className="plot-panel">
      <div className="plot-panel-head" ref={head}>
        <p className="plot-label">{axisLabel(panel.label, drawn.exponent)}</p>
        <Legend label={panel.label} groups={groups} onToggle={onToggle} />
      </div>
      <Axes drawn={drawn} pointed={pointed} sync={sync} label={panelSummary(panel, x, view, drawn.range)} />
    </div>
  );
}

interface AxesProps {
  drawn: Drawn;
  pointed: Pointed;
  sync: string;
  label: string;
}

/** Kept as it is while only the pointer moves. */
const Axes = memo(function Axes({ drawn, pointed, sync, label }: AxesProps) {
  const box = useAxes(drawn, pointed, sync);
  return <div ref={box} className="plot-axes" role="img" aria-label={label} style={{ height: drawn.height }} />;
});

const isShown =
  (hidden: ReadonlySet<string>) =>
  ({ key, thing }: Styled<Line | Mark>): boolean =>
    !hidden.has(key) && !hidden.has(thing.run);

function groupsOf({ lines, marks }: StyledPanel, colouring: Colouring, hidden: ReadonlySet<string>, reading: Reading) {
  const entries = [
    ...lines.map((line) => ({ run: line.thing.run, entry: lineEntry(line, !hidden.has(line.key), reading) })),
    ...marks.map((mark) => ({ run: mark.thing.run, entry: markEntry(mark, !hidden.has(mark.key)) })),
  ];
  return byRun(colouring === "role" ? entries.map(({ entry }) => ({ run: "", entry })) : entries);
}
