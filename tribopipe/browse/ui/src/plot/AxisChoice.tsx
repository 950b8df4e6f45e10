import type { PlotOffer } from "../api";
import { setQuery } from "../shell/router";

/** What the plots of a page are drawn against, where there is a choice. */
export function AxisChoice({ offer: { axes, title }, chosen }: { offer: PlotOffer; chosen: string }) {
  if (axes.length < 2) return null;
  return (
    <label className="plot-axis">
      <span>
        against<span className="hidden"> (horizontal axis of {title})</span>
      </span>
      <select value={chosen} onChange={(event) => setQuery({ x: event.target.value, from: null, to: null })}>
        {axes.map(({ name, label }) => (
          <option key={name} value={name}>
            {label}
          </option>
        ))}
      </select>
    </label>
  );
}
