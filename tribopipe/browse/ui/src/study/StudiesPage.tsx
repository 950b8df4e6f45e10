import "../run/run.css";
import "./study.css";

import type { StudyLine } from "../api";
import { Empty } from "../components/Empty";
import { Failure } from "../components/Failure";
import { Loading } from "../components/Loading";
import { useArchive } from "../shell/archive";
import { Link, runHref, studyHref } from "../shell/router";
import { useAnswer } from "../shell/useAnswer";
import { useTitle } from "../shell/useTitle";

/** All studies of the archive, each in a line. */
export default function StudiesPage() {
  useTitle("Studies");
  const { answer: studies, error } = useAnswer<StudyLine[]>("studies");
  return (
    <div className="page">
      <div className="page-head">
        <h1>Studies</h1>
      </div>
      {error && <Failure error={error} />}
      {studies === null && error === null && <Loading what="the studies" />}
      {studies && (studies.length === 0 ? <NoStudies /> : <Listed studies={studies} />)}
    </div>
  );
}

function Listed({ studies }: { studies: StudyLine[] }) {
  return (
    <ul className="studies">
      {studies.map((study) => (
        <li key={study.id} className="card">
          <h2>
            <Link href={studyHref(study.id)}>{study.title}</Link>
          </h2>
          {study.title !== study.id && <code>{study.id}</code>}
          <dl className="origin">
            <Runs said="Fitted" ids={study.fitted} />
            <Runs said="Predicted" ids={study.predicted} />
            <dt>Agreement</dt>
            <dd>
              {study.agreement.split("; ").map((law, place) => (
                <div key={place}>{law}</div>
              ))}
            </dd>
          </dl>
        </li>
      ))}
    </ul>
  );
}

function Runs({ said, ids }: { said: string; ids: string[] }) {
  if (ids.length === 0) return null;
  return (
    <>
      <dt>{said}</dt>
      <dd className="members">
        {ids.map((id) => (
          <Link key={id} href={runHref(id)}>
            {id}
          </Link>
        ))}
      </dd>
    </>
  );
}

function NoStudies() {
  const { answer: archive } = useArchive();
  return (
    <Empty title="No studies in this archive yet.">
      <p>A study fits k_D to some runs, predicts others, and shows where a wear law does not agree with the measurements.</p>
      <p>
        To draft one, run <code>tribopipe study new --archive {archive?.folder ?? "…"}</code>
      </p>
      <p>
        Then evaluate it with <code>tribopipe study run study.toml</code>
      </p>
    </Empty>
  );
}
