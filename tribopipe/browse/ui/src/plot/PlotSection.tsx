import "./plot.css";

import { useId, useRef } from "react";

import type { Plot, PlotOffer } from "../api";
import { Failure } from "../components/Failure";
import { usePrinting } from "../shell/printing";
import { fileHref, Link, setQuery, useAddress } from "../shell/router";
import { useAnswer } from "../shell/useAnswer";
import { AxisChoice } from "./AxisChoice";
import { ofManyRuns } from "./entries";
import PlotView, { HEIGHT } from "./PlotView";
import { rangeFor } from "./queried";
import { useColumns } from "./useColumns";
import { useSeen } from "./useSeen";

interface Props {
  /** What of the archive it is a plot of, as the server knows it: "runs/ID", "studies/ID". */
  base: string;
  /** The HDF5 file it was read from. */
  file: string;
  offer: PlotOffer;
  height?: number;
  /** Texts elsewhere on the page; the words of the plot are not repeated. */
  said?: string[];
}

/** A plot with its heading; asked for once it comes into sight. Range and axis stand in the address. */
export default function PlotSection({ base, file, offer, height = HEIGHT, said = [] }: Props) {
  const heading = useId();
  const section = useRef<HTMLElement>(null);
  const seen = useSeen(section);
  const printing = usePrinting();
  const width = useColumns(section);
  const { query } = useAddress();
  const range = rangeFor(offer, query);
  const path = (seen || printing) && width > 0 ? `${base}/plots/${encodeURIComponent(offer.name)}` : null;
  const { answer, error, stale } = useAnswer<Plot>(path, { ...range, width });
  const waiting = path !== null && stale && error === null;

  const zoom = (from: number | null, to: number | null) =>
    setQuery({ x: range.x, from: text(from), to: text(to) }, { replace: true });

  return (
    <figure className="plot-section" ref={section} aria-labelledby={heading} aria-busy={waiting}>
      <header className="plot-head">
        <h3 id={heading}>{offer.title}</h3>
        <AxisChoice offer={offer} chosen={range.x} />
        <Link href={fileHref(file, offer.path)}>
          Open in viewer<span className="hidden">: {offer.title}</span>
        </Link>
      </header>
      {error && <Failure error={error} />}
      {answer ? (
        <div className={waiting ? "is-stale" : undefined}>
          {answer.words && !said.some((text) => text.includes(answer.words)) && (
            <p className="plot-words">{answer.words}</p>
          )}
          <PlotView plot={answer} onZoom={zoom} height={height} legendByRun={ofManyRuns(answer)} />
        </div>
      ) : (
        error === null && (
          <>
            <div className="plot-skeleton" style={{ height: `calc(${height}px + 8.2rem)` }} />
            <p className="only-on-paper">This plot has not been loaded yet. Print the page again with Ctrl+P.</p>
          </>
        )
      )}
    </figure>
  );
}

const text = (place: number | null): string | null => (place === null ? null : String(place));
