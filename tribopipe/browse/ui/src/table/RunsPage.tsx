import "./table.css";

import { useCallback, useMemo } from "react";

import type { ApiError, Archive, Column, Runs } from "../api";
import { Failure } from "../components/Failure";
import { Loading } from "../components/Loading";
import { useArchive } from "../shell/archive";
import { addressOf, Link, setQuery, useAddress } from "../shell/router";
import { useAnswer } from "../shell/useAnswer";
import { useDraft } from "../shell/useDraft";
import { useTitle } from "../shell/useTitle";
import { ColumnMenu } from "./ColumnMenu";
import { chosenColumns, headed, matching, rowsOf, sorted, sortOf, sortText, type Row } from "./listing";
import { NoRuns } from "./NoRuns";
import { QueryBox } from "./QueryBox";
import { RunsTable } from "./RunsTable";
import { SearchBox } from "./SearchBox";
import { Selection } from "./Selection";
import { Unreadable } from "./Unreadable";
import { partOf, useParts } from "./parts";

/** All runs of the archive in one table. */
export function RunsPage() {
  useTitle("Runs");
  const { query } = useAddress();
  const { answer: archive, error } = useArchive();
  const where = query.get("where") ?? "";
  const runs = useAnswer<Runs>("runs", partOf({ where }, 0));
  const [search, setSearch] = useDraft(query.get("q") ?? "", (q) => setQuery({ q }, { replace: true }));

  if (archive === null) return error ? <FailedPage error={error} /> : <Loading what="the archive" />;
  return (
    <div className="runs-page">
      <h1 className="hidden">Runs</h1>
      <Unreadable files={archive.unreadable} />
      <div className="runs-asking">
        <QueryBox columns={archive.columns} where={where} error={runs.error} />
        <SearchBox text={search} onType={setSearch} />
      </div>
      {runs.answer ? (
        <Listing archive={archive} runs={runs.answer} search={search} stale={runs.stale} failed={runs.error !== null} />
      ) : (
        runs.loading && <Loading what="the runs" />
      )}
    </div>
  );
}

const FailedPage = ({ error }: { error: ApiError }) => (
  <div className="page">
    <Failure error={error} />
  </div>
);

interface Props {
  archive: Archive;
  /** The first runs that the filter leaves, or all of them. */
  runs: Runs;
  search: string;
  stale: boolean;
  /** Whether these are the rows from before a question that was not answered. */
  failed: boolean;
}

/** What the filter leaves: the server searches and sorts it where it is too much for the browser. */
function Listing(props: Props) {
  return props.runs.total > props.runs.ids.length ? <InParts {...props} /> : <Whole {...props} />;
}

/** All runs that the filter leaves are here. */
function Whole({ runs, search, ...props }: Props) {
  const { all, columns, sort } = useChosen(props.archive, runs);
  const headings = useMemo(() => headed(columns, runs), [columns, runs]);
  const rows = useMemo(() => sorted(matching(all, columns, search), sort), [all, columns, search, sort]);
  const rowAt = useCallback((place: number) => rows[place], [rows]);
  return <Results {...props} all={all} columns={headings} count={rows.length} rowAt={rowAt} />;
}

/** The runs in sight are asked for. */
function InParts({ runs, ...props }: Props) {
  const { query } = useAddress();
  const search = (query.get("q") ?? "").trim();
  const { all, columns, sort } = useChosen(props.archive, runs);
  const searched = search && ["id", ...columns.map(({ name }) => name)].join(",");
  const order = sort.column === "id" && !sort.descending ? "" : sortText(sort);
  const parts = useParts({ where: query.get("where") ?? "", sort: order, search, columns: searched });
  return (
    <Results
      {...props}
      all={all}
      columns={columns}
      count={parts.total ?? runs.total}
      rowAt={parts.rowAt}
      stale={props.stale || parts.stale}
      onSight={parts.onSight}
    />
  );
}

/** Rows of an answer, and what the address asks for. */
function useChosen(archive: Archive, runs: Runs) {
  const { query } = useAddress();
  const all = useMemo(() => rowsOf(runs), [runs]);
  const named = query.get("columns");
  const columns = useMemo(() => chosenColumns(archive.columns, named, all), [archive.columns, named, all]);
  const sort = useMemo(() => sortOf(query.get("sort")), [query]);
  return { all, columns, sort };
}

interface ResultsProps {
  archive: Archive;
  all: Row[];
  columns: Column[];
  count: number;
  rowAt(place: number): Row | undefined;
  stale: boolean;
  failed: boolean;
  onSight?(first: number, last: number): void;
}

/** The table, and what can be done with it. */
function Results({ archive, all, columns, count, rowAt, stale, failed, onSight }: ResultsProps) {
  const { query } = useAddress();
  const sort = useMemo(() => sortOf(query.get("sort")), [query]);
  const selected = useMemo(() => listed(query.get("selected")), [query]);
  const toggle = useCallback((id: string) => {
    const next = listed(new URLSearchParams(location.search).get("selected"));
    if (!next.delete(id)) next.add(id);
    setQuery({ selected: [...next].join(",") }, { replace: true });
  }, []);

  return (
    <>
      <div className="runs-tools">
        <p className="count" role="status">
          <strong>{count}</strong> of {archive.runs} {archive.runs === 1 ? "run" : "runs"}
          {failed && " (previous result)"}
        </p>
        {archive.runs > 0 && <Selection ids={[...selected]} />}
        <ColumnMenu columns={archive.columns} chosen={columns} />
        <Link className="button" href={addressOf("/scatter", { where: query.get("where") ?? "" })}>
          Scatter plot
        </Link>
        <a className="button" href={addressOf("/api/runs.csv", { where: query.get("where") ?? "" })} download>
          Download CSV
        </a>
      </div>
      {count === 0 ? (
        <NoRuns archive={archive} />
      ) : (
        <RunsTable
          columns={columns}
          all={all}
          count={count}
          rowAt={rowAt}
          sort={sort}
          stale={stale}
          selected={selected}
          onSort={(next) => setQuery({ sort: sortText(next) }, { replace: true })}
          onSelect={toggle}
          {...(onSight && { onSight })}
        />
      )}
    </>
  );
}

const listed = (text: string | null): Set<string> => new Set(text?.split(",").filter(Boolean));
