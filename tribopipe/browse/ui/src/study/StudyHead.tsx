import type { Study } from "../api";
import { counted } from "../run/words";
import { printWhole } from "../shell/printing";
import { addressOf, fileHref, Link } from "../shell/router";
import { studyApi } from "./places";

/** What study this is, and what can be done with it. */
export function StudyHead({ study }: { study: Study }) {
  const runs = [...study.fitted, ...study.predicted];
  return (
    <div className="subject">
      <div className="subject-names">
        <h1>{study.title}</h1>
        <p className="subject-line">
          {study.title !== study.id && <code>{study.id}</code>}
          <span>
            {counted(study.fitted.length, "run")} fitted · {study.predicted.length} predicted
          </span>
        </p>
      </div>
      <div className="actions">
        <Link className="button button-main" href={addressOf("/compare", { runs: runs.join(",") })}>
          Compare these runs
        </Link>
        <a className="button" href={`/api/${studyApi(study.id)}/report`} target="_blank" rel="noopener">
          Report<span className="hidden"> (opens in a new tab)</span>
        </a>
        <Link className="button" href={fileHref(study.file, "")}>
          Open in viewer
        </Link>
        <button type="button" className="button" onClick={() => void printWhole()}>
          Print
        </button>
        <a className="button" href={`/api/${studyApi(study.id)}/file`} download>
          Download HDF5
        </a>
      </div>
    </div>
  );
}
