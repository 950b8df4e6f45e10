import type { Run } from "../api";
import { Switch } from "../components/Switch";
import { AxisChoice } from "../plot/AxisChoice";
import { setQuery } from "../shell/router";
import { useAnswer } from "../shell/useAnswer";
import { extrasText, WHATS, type Asked } from "./asked";

/** What is drawn of the runs, and against what: the axes of the first of them. */
export function Choices({ asked, first }: { asked: Asked; first: string }) {
  const { answer: run } = useAnswer<Run>(`runs/${encodeURIComponent(first)}`);
  const offer = run?.plots.find(({ name }) => name === asked.what);
  const draw = (fits: boolean, predictions: boolean) =>
    setQuery({ with: extrasText(fits, predictions) }, { replace: true });

  return (
    <div className="choices">
      <Switch
        label="Quantity to compare"
        choices={[...WHATS]}
        value={asked.what}
        onChoose={(what) => setQuery({ what, x: null, from: null, to: null })}
      />
      <label>
        <input type="checkbox" checked={asked.fits} onChange={() => draw(!asked.fits, asked.predictions)} />
        fits
      </label>
      <label>
        <input type="checkbox" checked={asked.predictions} onChange={() => draw(asked.fits, !asked.predictions)} />
        predictions
      </label>
      {offer && <AxisChoice offer={offer} chosen={asked.x || (offer.axes[0]?.name ?? "")} />}
    </div>
  );
}
