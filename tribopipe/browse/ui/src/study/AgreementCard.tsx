import type { Study } from "../api";
import { Card } from "../components/Card";
import { unbroken } from "../run/words";
import { Link, runHref } from "../shell/router";
import { lawId } from "./laws";
import { Outcome } from "./Outcome";

/** Agreement of each run with each law, and k_D under each. */
export function AgreementCard({ study }: { study: Study }) {
  return (
    <Card title="Agreement with the models" id="agreement">
      <div className="table-box" tabIndex={0} role="region" aria-label="Agreement of each run with each law">
        <table className="texts agreement">
          <thead>
            <tr>
              <th scope="col">run</th>
              <th scope="col">role</th>
              {study.laws.map(({ model, heading }) => (
                <th key={model} scope="col">
                  <a href={`#${lawId(model)}`}>{heading}</a>
                </th>
              ))}
            </tr>
          </thead>
          <tbody>
            {runsOf(study).map(({ id, role }) => (
              <tr key={id}>
                <th scope="row">
                  <Link href={runHref(id)}>{id}</Link>
                </th>
                <td>{role}</td>
                {study.laws.map((law) => (
                  <td key={law.model}>
                    <Given outcome={law.agreement.find((line) => line.run_id === id)?.outcome} />
                  </td>
                ))}
              </tr>
            ))}
          </tbody>
        </table>
      </div>
      <ul className="coefficients">
        {study.laws.map(({ model, title }) => (
          <li key={model}>{unbroken(title)}</li>
        ))}
      </ul>
    </Card>
  );
}

/** The runs of a study, those that identified k_D first. */
function runsOf({ fitted, predicted }: Study): { id: string; role: string }[] {
  return [...fitted.map((id) => ({ id, role: "fitted" })), ...predicted.map((id) => ({ id, role: "predicted" }))];
}

const Given = ({ outcome }: { outcome: string | undefined }) => (outcome ? <Outcome name={outcome} /> : <>–</>);
