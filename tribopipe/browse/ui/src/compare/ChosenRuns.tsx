import { seriesVariable } from "../components/series";
import { Link, runHref } from "../shell/router";
import type { Row } from "../table/listing";

interface Props {
  ids: string[];
  known: ReadonlyMap<string, Row>;
  onChange(ids: string[]): void;
}

/** The runs that are compared, in the colours they are drawn in. */
export function ChosenRuns({ ids, known, onChange }: Props) {
  if (ids.length === 0) return null;
  const there = ids.filter((id) => known.has(id));
  return (
    <ul className="chosen" aria-label="Compared runs">
      {ids.map((id) => (
        <li key={id} className={known.has(id) ? undefined : "is-gone"}>
          <span className="swatch" aria-hidden="true" style={{ background: colour(there.indexOf(id)) }} />
          {known.has(id) ? <Link href={runHref(id)}>{id}</Link> : <span>{id}</span>}
          <button
            type="button"
            aria-label={`Remove ${id}`}
            onClick={() => onChange(ids.filter((other) => other !== id))}
          >
            ×
          </button>
        </li>
      ))}
    </ul>
  );
}

const colour = (place: number): string => (place < 0 ? "transparent" : `var(${seriesVariable(place)})`);
