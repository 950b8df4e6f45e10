import { Fingerprint } from "./Fingerprint";
import { moment } from "./words";

interface Props {
  made: { program_version: string; date: string; inputs_sha256: string; result_sha256?: string };
  /** What was made: "the study". */
  of: string;
}

/** Which program made something, when and of what. */
export function Origin({ made, of }: Props) {
  return (
    <dl className="origin">
      <dt>Program</dt>
      <dd>tribopipe {made.program_version}</dd>
      <dt>Computed</dt>
      <dd>
        <time dateTime={made.date}>{moment(made.date)}</time>
      </dd>
      <dt>Inputs</dt>
      <dd>
        <Fingerprint sha256={made.inputs_sha256} of={`the inputs of ${of}`} />
      </dd>
      {made.result_sha256 && (
        <>
          <dt>Result</dt>
          <dd>
            <Fingerprint sha256={made.result_sha256} of={`the result of ${of}`} />
          </dd>
        </>
      )}
    </dl>
  );
}
