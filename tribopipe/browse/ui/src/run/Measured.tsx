import type { Run } from "../api";
import { Facts } from "../components/Facts";
import { FoldedCard } from "./FoldedCard";

/** What was tested and how, and what was recorded. */
export function Measured({ run }: { run: Run }) {
  return (
    <FoldedCard title="Test and measurements" id="measured">
      {() => (
        <div className="groups">
          {run.facts.map(({ title, facts }, place) => (
            <section key={place} className="group">
              <h3>{title}</h3>
              <Facts facts={facts} />
            </section>
          ))}
        </div>
      )}
    </FoldedCard>
  );
}
