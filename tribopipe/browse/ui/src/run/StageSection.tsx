import type { PlotOffer, Run, Stage } from "../api";
import { Facts } from "../components/Facts";
import PlotSection from "../plot/PlotSection";
import { fileHref, Link } from "../shell/router";
import { FoldedCard } from "./FoldedCard";
import { isWear } from "./Glance";
import { apiOf, stageId } from "./places";
import { StageTable } from "./StageTable";
import { TextList } from "./TextList";
import { unbroken } from "./words";

/** One step of the evaluation: what it found, its plots, its numbers. */
export function StageSection({ run, stage }: { run: Run; stage: Stage }) {
  const offers = run.plots.filter((offer) => offer.stage === stage.name);
  return (
    <FoldedCard title={stage.title} id={stageId(stage.name)}>
      {() => (
        <>
          {stage.sentence && <p className="sentence">{unbroken(stage.sentence)}</p>}
          <TextList texts={stage.notes} kind="notes" />
          {offers.map((offer) => (
            <StagePlot key={offer.name} run={run} offer={offer} />
          ))}
          {stage.facts.length > 0 && <Facts facts={stage.facts} />}
          {stage.tables.map((table, place) => (
            <StageTable key={place} table={table} />
          ))}
          <p>
            <Link className="small" href={fileHref(run.file, stage.path)} aria-label={`${stage.title}, in viewer`}>
              In viewer
            </Link>
          </p>
        </>
      )}
    </FoldedCard>
  );
}

function StagePlot({ run, offer }: { run: Run; offer: PlotOffer }) {
  if (isWear(offer)) {
    return (
      <p className="soft">
        The wear curve is shown <a href="#result">next to the result</a>.
      </p>
    );
  }
  return <PlotSection base={apiOf(run.id)} file={run.file} offer={offer} />;
}
