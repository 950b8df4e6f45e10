import "./compare.css";

import { useMemo } from "react";

import type { Archive, Runs } from "../api";
import { Empty } from "../components/Empty";
import { Failure } from "../components/Failure";
import { Loading } from "../components/Loading";
import { useArchive } from "../shell/archive";
import { Link, setQuery, useAddress } from "../shell/router";
import { useAnswer } from "../shell/useAnswer";
import { useTitle } from "../shell/useTitle";
import { rowsOf, type Row } from "../table/listing";
import { askedFor, type Asked } from "./asked";
import { ChosenRuns } from "./ChosenRuns";
import { Choices } from "./Choices";
import { ComparedPlot } from "./ComparedPlot";
import { RunSearch } from "./RunSearch";
import { SideBySide } from "./SideBySide";

/** Any runs on one axis, and their main numbers side by side. */
export default function ComparePage() {
  useTitle("Compare");
  const { query } = useAddress();
  const asked = useMemo(() => askedFor(query), [query]);
  const archive = useArchive();
  const runs = useAnswer<Runs>("runs", { where: "" });
  const error = archive.error ?? runs.error;

  return (
    <div className="page">
      <div className="page-head">
        <h1>Compare runs</h1>
      </div>
      {archive.answer && runs.answer ? (
        <Compared asked={asked} archive={archive.answer} runs={runs.answer} />
      ) : error ? (
        <Failure error={error} />
      ) : (
        <Loading what="the runs" />
      )}
    </div>
  );
}

interface Props {
  asked: Asked;
  archive: Archive;
  runs: Runs;
}

function Compared({ asked, archive, runs }: Props) {
  const all = useMemo(() => rowsOf(runs), [runs]);
  const byId = useMemo(() => new Map(all.map((row) => [row.id, row])), [all]);
  const there = asked.runs.map((id) => byId.get(id)).filter((row): row is Row => row !== undefined);
  const first = there[0];
  const choose = (ids: string[]) => setQuery({ runs: ids.join(","), from: null, to: null });

  return (
    <>
      <div className="compare-runs">
        <ChosenRuns ids={asked.runs} known={byId} onChange={choose} />
        <RunSearch rows={all} columns={archive.columns} chosen={asked.runs} onAdd={(id) => choose([...asked.runs, id])} />
      </div>
      <Gone ids={asked.runs.filter((id) => !byId.has(id))} />
      {first === undefined ? (
        <Empty title="No runs selected.">
          <p>
            Search for runs above, or select them in the <Link href="/">table of runs</Link>.
          </p>
        </Empty>
      ) : (
        <>
          <Choices asked={asked} first={first.id} />
          <ComparedPlot asked={asked} ids={there.map(({ id }) => id)} />
          <SideBySide rows={there} columns={archive.columns} />
        </>
      )}
    </>
  );
}

function Gone({ ids }: { ids: string[] }) {
  if (ids.length === 0) return null;
  return (
    <p className="notice notice-warn" role="status">
      <strong>{ids.length === 1 ? "One run is" : `${ids.length} runs are`} not in the archive:</strong> {ids.join(", ")}
    </p>
  );
}
