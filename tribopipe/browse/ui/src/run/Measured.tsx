import type { Run } from "../api";
import { Card } from "../components/Card";
import { Facts } from "../components/Facts";
import { Findings } from "./Findings";

/** What was tested and how, what was recorded, and what the checks and the fits found in it. */
export function Measured({ run }: { run: Run }) {
  return (
    <Card title="Test and measurements" id="measured">
      <Findings findings={run.findings} />
      <div className="groups">
        {run.facts.map(({ title, facts }, place) => (
          <section key={place} className="group">
            <h3>{title}</h3>
            <Facts facts={facts} />
          </section>
        ))}
      </div>
    </Card>
  );
}
