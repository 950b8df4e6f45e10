import type { Run, Stage } from "../api";
import { Card } from "../components/Card";
import { Disclosure } from "./Disclosure";
import { Fingerprint } from "./Fingerprint";
import { moment } from "./words";

/** Which program made each result, when, of what, and how it was told to. */
export function Provenance({ run }: { run: Run }) {
  return (
    <Card title="Provenance" id="provenance">
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
    </Card>
  );
}

function StageOrigin({ stage }: { stage: Stage }) {
  return (
    <li>
      <h3>{stage.title}</h3>
      <dl className="origin">
        <dt>Program</dt>
        <dd>tribopipe {stage.program_version}</dd>
        <dt>Made</dt>
        <dd>
          <time dateTime={stage.date}>{moment(stage.date)}</time>
        </dd>
        <dt>Inputs</dt>
        <dd>
          <Fingerprint sha256={stage.inputs_sha256} of={`the inputs of ${stage.title}`} />
        </dd>
        <dt>Result</dt>
        <dd>
          <Fingerprint sha256={stage.result_sha256} of={`the result of ${stage.title}`} />
        </dd>
      </dl>
      <Disclosure title="Options">
        {() => (
          <pre className="options" tabIndex={0} aria-label={`Options of ${stage.title}`} role="region">
            {JSON.stringify(stage.options, null, 2)}
          </pre>
        )}
      </Disclosure>
    </li>
  );
}
