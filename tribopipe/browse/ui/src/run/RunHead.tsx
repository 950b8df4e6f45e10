import type { Run } from "../api";
import { Chip } from "../components/Chip";
import { Link, studyHref } from "../shell/router";
import { Actions } from "./Actions";
import { problems, progress } from "./status";
import { summary } from "./summary";
import { moment, unbroken } from "./words";

/** What run this is, whether to trust it, and what can be done with it. */
export function RunHead({ run }: { run: Run }) {
  return (
    <div className="subject">
      <div className="subject-names">
        <h1>{run.title}</h1>
        <p className="subject-line">
          {run.title !== run.id && <code>{run.id}</code>}
          <span>{unbroken(summary(run).join(" · "))}</span>
        </p>
        {run.tags.length > 0 && (
          <p className="chips">
            <span className="hidden">Tags:</span>
            {run.tags.map((tag) => (
              <Chip key={tag}>{tag}</Chip>
            ))}
          </p>
        )}
        <Status run={run} />
        <Studies ids={run.studies} />
      </div>
      <Actions run={run} />
      <Bad run={run} />
    </div>
  );
}

function Status({ run }: { run: Run }) {
  return (
    <p className="subject-line">
      <span>
        Status: {progress(run)}; <a href="#findings">{problems(run)}</a>
        {run.bad !== null && "; marked bad"}
      </span>
    </p>
  );
}

function Studies({ ids }: { ids: string[] }) {
  if (ids.length === 0) return null;
  return (
    <p className="subject-line">
      <span>Part of {ids.length === 1 ? "the study" : "the studies"}</span>
      {ids.map((id) => (
        <Link key={id} href={studyHref(id)}>
          {id}
        </Link>
      ))}
    </p>
  );
}

function Bad({ run }: { run: Run }) {
  if (run.bad === null) return null;
  const mark = run.remarks.findLast(({ kind }) => kind === "bad");
  const by = [mark?.operator, mark && moment(mark.date)].filter(Boolean).join(", ");
  return (
    <div className="notice notice-bad subject-bad">
      <strong>
        <span aria-hidden="true">✕</span> Marked bad
      </strong>{" "}
      {by && <span className="soft">({by})</span>}
      <p>{run.bad}</p>
    </div>
  );
}
