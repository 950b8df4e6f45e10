import type { Study } from "../api";
import { Card } from "../components/Card";
import { Fingerprint } from "../run/Fingerprint";
import { moment } from "../run/words";

/** Which program evaluated a study, when and of what. */
export function StudyOrigin({ study }: { study: Study }) {
  return (
    <Card title="Provenance" id="provenance">
      <dl className="origin">
        <dt>Program</dt>
        <dd>tribopipe {study.program_version}</dd>
        <dt>Made</dt>
        <dd>
          <time dateTime={study.date}>{moment(study.date)}</time>
        </dd>
        <dt>Inputs</dt>
        <dd>
          <Fingerprint sha256={study.inputs_sha256} of="the inputs of the study" />
        </dd>
      </dl>
    </Card>
  );
}
