import "../run/run.css";
import "./study.css";

import type { PlotOffer, Study } from "../api";
import { Card } from "../components/Card";
import { Failure } from "../components/Failure";
import PlotSection from "../plot/PlotSection";
import { Contents, type Section } from "../run/Contents";
import { NotThere } from "../run/NotThere";
import { Skeleton } from "../run/Skeleton";
import { TextList } from "../run/TextList";
import { useAnchor } from "../run/useAnchor";
import { useAnswer } from "../shell/useAnswer";
import { useTitle } from "../shell/useTitle";
import { AgreementCard } from "./AgreementCard";
import { lawId } from "./laws";
import { LawSection } from "./LawSection";
import { studyApi } from "./places";
import { StudyHead } from "./StudyHead";
import { StudyOrigin } from "./StudyOrigin";

/** One study: agreement with the models, then each law with its curves, tables and sentences. */
export default function StudyPage({ id }: { id: string }) {
  useTitle(id);
  const { answer: study, error } = useAnswer<Study>(studyApi(id));
  useAnchor(study !== null);
  if (study === null) {
    if (error === null) return <Skeleton what="the study" />;
    return <NotThere title={id} error={error} back={{ href: "/studies", label: "All studies" }} />;
  }
  return (
    <div className="page">
      {error && <Failure error={error} />}
      <StudyHead study={study} />
      <div className="with-contents">
        <Contents sections={sections(study)} />
        <div className="parts">
          <AgreementCard study={study} />
          <Said study={study} />
          {study.laws.map((law) => (
            <LawSection key={law.model} study={study} law={law} />
          ))}
          <StudyOrigin study={study} />
        </div>
      </div>
    </div>
  );
}

/** What is said of the study as a whole, and the plots that belong to no single law. */
function Said({ study }: { study: Study }) {
  const offers = ofAllLaws(study);
  if (study.sentences.length + offers.length === 0) return null;
  return (
    <Card title="Comparison of the laws" id="laws">
      <TextList texts={study.sentences} kind="sentences" />
      {offers.map((offer) => (
        <PlotSection key={offer.name} base={studyApi(study.id)} file={study.file} offer={offer} />
      ))}
    </Card>
  );
}

const ofAllLaws = ({ plots }: Study): PlotOffer[] => plots.filter(({ name }) => !name.startsWith("wear-"));

function sections(study: Study): Section[] {
  const said = study.sentences.length + ofAllLaws(study).length > 0;
  return [
    { id: "agreement", title: "Agreement with the models" },
    ...(said ? [{ id: "laws", title: "Comparison of the laws" }] : []),
    ...study.laws.map(({ model, heading }) => ({ id: lawId(model), title: heading })),
    { id: "provenance", title: "Provenance" },
  ];
}
