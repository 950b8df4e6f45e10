import type { Study } from "../api";
import { Card } from "../components/Card";
import { Origin } from "../run/Origin";

/** Which program evaluated a study, when and of what. */
export function StudyOrigin({ study }: { study: Study }) {
  return (
    <Card title="Provenance" id="provenance">
      <Origin made={study} of="the study" />
    </Card>
  );
}
