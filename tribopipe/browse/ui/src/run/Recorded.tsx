import type { PlotOffer, Run } from "../api";
import PlotSection from "../plot/PlotSection";
import { Disclosure } from "./Disclosure";
import { FoldedCard } from "./FoldedCard";
import { isWear } from "./Glance";
import { apiOf } from "./places";

/** Plots that belong to no stage. */
export function recorded(run: Run): PlotOffer[] {
  const stages = new Set(run.stages.map(({ name }) => name));
  return run.plots.filter((offer) => !stages.has(offer.stage) && !isWear(offer));
}

const isOther = ({ name }: PlotOffer): boolean => name.startsWith("column-");

/** What was recorded; columns without a meaning are drawn only when they are asked for. */
export function Recorded({ run, offers }: { run: Run; offers: PlotOffer[] }) {
  const others = offers.filter(isOther);
  const plot = (offer: PlotOffer) => (
    <PlotSection key={offer.name} base={apiOf(run.id)} file={run.file} offer={offer} />
  );
  return (
    <FoldedCard title="Recorded signals" id="recorded">
      {() => (
        <>
          {offers.filter((offer) => !isOther(offer)).map(plot)}
          {others.length > 0 && (
            <Disclosure title={`Columns without an assigned signal (${others.length})`}>
              {() => others.map(plot)}
            </Disclosure>
          )}
        </>
      )}
    </FoldedCard>
  );
}
