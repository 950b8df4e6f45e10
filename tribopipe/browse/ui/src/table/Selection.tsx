import { addressOf, Link, setQuery } from "../shell/router";

/** What can be done with the runs that are ticked. */
export function Selection({ ids }: { ids: string[] }) {
  if (ids.length === 0) return <p className="soft tool-hint">Select runs to compare them.</p>;
  return (
    <div className="selection">
      <Link className="button button-main" href={addressOf("/compare", { runs: ids.join(",") })}>
        Compare {ids.length}
      </Link>
      <button type="button" className="button" onClick={() => setQuery({ selected: null }, { replace: true })}>
        Clear selection
      </button>
    </div>
  );
}
