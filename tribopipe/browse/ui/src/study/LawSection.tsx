import type { LawPage, PlotOffer, Study, VerdictLine } from "../api";
import { Card } from "../components/Card";
import { TextTable } from "../components/TextTable";
import PlotSection from "../plot/PlotSection";
import { Disclosure } from "../run/Disclosure";
import { TextList } from "../run/TextList";
import { Link, runHref } from "../shell/router";
import { lawId } from "./laws";
import { Outcome } from "./Outcome";
import { studyApi } from "./places";

/** One law in a study: k_D, its curves, what is said of each run, tables. */
export function LawSection({ study, law }: { study: Study; law: LawPage }) {
  const together = study.plots.find(({ name }) => name === `wear-${law.model}`);
  return (
    <Card title={law.heading} id={lawId(law.model)}>
      <p className="sentence">
        <strong>{law.title}</strong>
      </p>
      {together && <PlotSection base={studyApi(study.id)} file={study.file} offer={together} />}
      <ul className="judged">
        {law.verdicts.map((verdict) => (
          <Judged key={verdict.run_id} study={study} verdict={verdict} offer={offerOf(study, law, verdict)} />
        ))}
      </ul>
      <TextList texts={law.sentences} kind="sentences" />
      {law.tables.map((table, place) => table.rows.length > 0 && <TextTable key={place} table={table} />)}
    </Card>
  );
}

const offerOf = (study: Study, law: LawPage, { run_id }: VerdictLine): PlotOffer | undefined =>
  study.plots.find(({ name }) => name === `wear-${law.model}-${run_id}`);

interface Props {
  study: Study;
  verdict: VerdictLine;
  offer: PlotOffer | undefined;
}

function Judged({ study, verdict, offer }: Props) {
  return (
    <li>
      <p className="judged-head">
        <Outcome name={verdict.outcome} />
        <Link href={runHref(verdict.run_id)}>{verdict.run_id}</Link>
        <span className="soft">{verdict.role}</span>
      </p>
      <p className="sentence">{verdict.sentence}</p>
      <TextList texts={verdict.notes} kind="notes" />
      {offer && (
        <Disclosure title={`Wear curve of ${verdict.run_id}`}>
          {() => <PlotSection base={studyApi(study.id)} file={study.file} offer={offer} />}
        </Disclosure>
      )}
    </li>
  );
}
