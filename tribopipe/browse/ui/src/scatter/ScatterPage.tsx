import "../plot/plot.css";
import "../table/table.css";
import "./scatter.css";

import { useMemo } from "react";

import type { Archive, Column, Runs } from "../api";
import { Card } from "../components/Card";
import { Empty } from "../components/Empty";
import { Failure } from "../components/Failure";
import { Loading } from "../components/Loading";
import { useArchive } from "../shell/archive";
import { setQuery, useAddress } from "../shell/router";
import { useAnswer } from "../shell/useAnswer";
import { useTitle } from "../shell/useTitle";
import { rowsOf, type Row } from "../table/listing";
import { QueryBox } from "../table/QueryBox";
import { grouped, missing, quantities, quantityLabel, type Group } from "./points";
import { isLogarithmic } from "./scale";
import { ScatterPlot } from "./ScatterPlot";

/** Any number of the runs against any other. */
export default function ScatterPage() {
  useTitle("Scatter plot");
  const { query } = useAddress();
  const archive = useArchive();
  const where = query.get("where") ?? "";
  const runs = useAnswer<Runs>("runs", { where });
  const failure = archive.error ?? (runs.answer ? null : runs.error);

  if (archive.answer === null) return failure ? <Failure error={failure} /> : <Loading what="the archive" />;
  return (
    <div className="page">
      <div className="page-head">
        <h1>Scatter plot</h1>
      </div>
      <QueryBox columns={archive.answer.columns} where={where} error={runs.error} />
      {runs.answer ? <Asked archive={archive.answer} runs={runs.answer} /> : runs.loading && <Loading what="the runs" />}
    </div>
  );
}

const USUAL = { x: "load", y: "k_d" };

function Asked({ archive, runs }: { archive: Archive; runs: Runs }) {
  const { query } = useAddress();
  const rows = useMemo(() => rowsOf(runs), [runs]);
  const offered = useMemo(() => quantities(archive.columns, rows), [archive.columns, rows]);
  const chosen = (axis: "x" | "y") => {
    const named = (name: string | null) => offered.find((column) => column.name === name);
    return named(query.get(axis)) ?? named(USUAL[axis]) ?? offered[0];
  };
  const [x, y] = [chosen("x"), chosen("y")];
  if (x === undefined || y === undefined) {
    return (
      <Empty title={rows.length ? "No numerical values to plot for these runs." : "No runs to plot."}>
        <p>
          Change the filter, or process runs with <code>tribopipe process</code>.
        </p>
      </Empty>
    );
  }
  const points = grouped(rows, x, y).flatMap((group) => group.points);
  const isLog = (axis: "x" | "y") => isLogarithmic(query.get(logName(axis)), points.map((point) => point[axis].value));
  const log = { x: isLog("x"), y: isLog("y") };
  return (
    <Card title={`${y.label} against ${x.label}`}>
      <div className="scatter-axes">
        <AxisChoice axis="y" label="Vertical axis" offered={offered} chosen={y} log={log.y} />
        <AxisChoice axis="x" label="Horizontal axis" offered={offered} chosen={x} log={log.x} />
      </div>
      <Plotted rows={rows} x={x} y={y} log={log} />
    </Card>
  );
}

interface ChoiceProps {
  axis: "x" | "y";
  label: string;
  offered: Column[];
  chosen: Column;
  log: boolean;
}

const logName = (axis: "x" | "y"): string => `log${axis}`;

function AxisChoice({ axis, label, offered, chosen, log }: ChoiceProps) {
  return (
    <div className="scatter-axis">
      <label>
        <span>{label}</span>{" "}
        <select value={chosen.name} onChange={(event) =>
            setQuery({ [axis]: event.target.value, [logName(axis)]: null }, { replace: true })
          }>
          {offered.map((column) => (
            <option key={column.name} value={column.name}>
              {quantityLabel(column)}
            </option>
          ))}
        </select>
      </label>
      <label>
        <input
          type="checkbox"
          checked={log}
          onChange={() => setQuery({ [logName(axis)]: log ? "0" : "1" }, { replace: true })}
        />
        logarithmic<span className="hidden"> {label.toLowerCase()}</span>
      </label>
    </div>
  );
}

interface PlottedProps {
  rows: Row[];
  x: Column;
  y: Column;
  log: { x: boolean; y: boolean };
}

function Plotted({ rows, x, y, log }: PlottedProps) {
  const all = useMemo(() => grouped(rows, x, y), [rows, x, y]);
  const groups = all.map((group) => ({ ...group, points: group.points.filter((point) => isOnAxes(point, log)) }));
  const left = count(all) - count(groups);
  const notes = missing(rows, [x, y]);
  if (left > 0) notes.push(`${left === 1 ? "1 run is" : `${left} runs are`} not shown: logarithmic axes require positive values.`);

  return (
    <>
      {count(groups) === 0 ? (
        <Empty title="No run has both quantities." />
      ) : (
        <ScatterPlot groups={groups} x={x} y={y} log={log} />
      )}
      {notes.length > 0 && <p className="soft">{notes.join(" ")}</p>}
    </>
  );
}

const count = (groups: Group[]): number => groups.reduce((sum, { points }) => sum + points.length, 0);

const isOnAxes = ({ x, y }: Group["points"][number], log: { x: boolean; y: boolean }): boolean =>
  (!log.x || x.value > 0) && (!log.y || y.value > 0);
