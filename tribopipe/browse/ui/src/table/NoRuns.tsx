import type { Archive } from "../api";
import { Empty } from "../components/Empty";
import { setQuery } from "../shell/router";

/** An archive without runs, or a filter that leaves none. */
export function NoRuns({ archive }: { archive: Archive }) {
  if (archive.runs > 0) {
    return (
      <Empty title="No matching runs.">
        <button type="button" className="button" onClick={() => setQuery({ where: null, q: null })}>
          Show all runs
        </button>
      </Empty>
    );
  }
  return (
    <Empty title="This archive contains no runs yet.">
      <p>
        Archive a run folder with <code>tribopipe ingest run/ --archive {archive.folder}</code>
      </p>
      <p>The run is shown here as soon as it is archived.</p>
    </Empty>
  );
}
