import type { AgreementLine, LawPage, PlotOffer, Study } from "../api";
import { Card } from "../components/Card";
import { TextTable } from "../components/TextTable";
import PlotSection from "../plot/PlotSection";
import { Disclosure } from "../run/Disclosure";
import { TextList } from "../run/TextList";
import { unbroken } from "../run/words";
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
        <strong>{unbroken(law.title)}</strong>
      </p>
      {together && <PlotSection base={studyApi(study.id)} file={study.file} offer={together} />}
      <ul className="judged">
        {law.agreement.map((line) => (
          <Judged key={line.run_id} study={study} line={line} offer={offerOf(study, law, line)} />
        ))}
      </ul>
      <TextList texts={law.sentences} kind="sentences" />
      {law.tables.map((table, place) => table.rows.length > 0 && <TextTable key={place} table={table} />)}
    </Card>
  );
}

const offerOf = (study: Study, law: LawPage, { run_id }: AgreementLine): PlotOffer | undefined =>
  study.plots.find(({ name }) => name === `wear-${law.model}-${run_id}`);

interface Props {
  study: Study;
  line: AgreementLine;
  offer: PlotOffer | undefined;
}

function Judged({ study, line, offer }: Props) {
  return (
    <li>
      <p className="judged-head">
        <Outcome name={line.outcome} />
        <Link href={runHref(line.run_id)}>{line.run_id}</Link>
        <span className="soft">{line.role}</span>
      </p>
      <p className="sentence">{unbroken(line.sentence)}</p>
      <TextList texts={line.notes} kind="notes" />
      {offer && (
        <Disclosure title={`Wear curve of ${line.run_id}`}>
          {() => <PlotSection base={studyApi(study.id)} file={study.file} offer={offer} />}
        </Disclosure>
      )}
    </li>
  );
}
