import type { Run } from "../api";
import { Menu } from "../components/Menu";
import { printWhole } from "../shell/printing";
import { addressOf, fileHref, Link } from "../shell/router";
import { apiOf } from "./places";

/** What can be done with a run. */
export function Actions({ run }: { run: Run }) {
  const api = `/api/${apiOf(run.id)}`;
  return (
    <div className="actions">
      <Link className="button button-main" href={addressOf("/compare", { runs: run.id })}>
        Compare with …
      </Link>
      <a className="button" href={`${api}/report`} target="_blank" rel="noopener">
        Report<span className="hidden"> (opens in a new tab)</span>
      </a>
      <Link className="button" href={fileHref(run.file, "")}>
        Open in viewer
      </Link>
      <button type="button" className="button" onClick={() => void printWhole()}>
        Print
      </button>
      <Menu label="Download">
        <ul className="downloads">
          <Download href={`${api}/file`} name={run.file} meaning="complete run, HDF5" />
          {run.csv.map(({ name, meaning }) => (
            <Download key={name} href={`${api}/csv/${encodeURIComponent(name)}`} name={`${name}.csv`} meaning={meaning} />
          ))}
        </ul>
      </Menu>
    </div>
  );
}

function Download({ href, name, meaning }: { href: string; name: string; meaning: string }) {
  return (
    <li>
      <a href={href} download>
        <strong>{name}</strong>
        <span>{meaning}</span>
      </a>
    </li>
  );
}
