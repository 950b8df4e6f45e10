import type { Run, Stage } from "../api";
import { Disclosure } from "./Disclosure";
import { FoldedCard } from "./FoldedCard";
import { Fingerprint } from "./Fingerprint";
import { Origin } from "./Origin";

/** Which program made each result, when, of what, and how it was told to. */
export function Provenance({ run }: { run: Run }) {
  return (
    <FoldedCard title="Provenance" id="provenance">
      {() => (
        <>
            <dl className="origin">
              <dt>Signals as ingested</dt>
              <dd>
                <Fingerprint sha256={run.raw_sha256} of="the signals as ingested" />
              </dd>
            </dl>
            <ol className="origins">
              {run.stages.map((stage) => (
                <StageOrigin key={stage.name} stage={stage} />
              ))}
            </ol>
        </>
      )}
    </FoldedCard>
  );
}

function StageOrigin({ stage }: { stage: Stage }) {
  return (
    <li>
      <h3>{stage.title}</h3>
      <Origin made={stage} of={stage.title} />
      <Disclosure title="Options" printed={false}>
        {() => (
          <pre className="options" tabIndex={0} aria-label={`Options of ${stage.title}`} role="region">
            {JSON.stringify(stage.options, null, 2)}
          </pre>
        )}
      </Disclosure>
    </li>
  );
}
