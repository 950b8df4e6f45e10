import { useState } from "react";

import type { Column } from "../api";
import { Card } from "../components/Card";
import { seriesVariable } from "../components/series";
import { Link, runHref } from "../shell/router";
import { textOf } from "../table/cells";
import type { Row } from "../table/listing";
import { isSame, linesOf } from "./lines";

/** From this number of runs on, only what differs is shown at first. */
const MANY = 3;

/** What the runs' rows say, one run a column. */
export function SideBySide({ rows, columns }: { rows: Row[]; columns: Column[] }) {
  const [chosen, choose] = useState<boolean | null>(null);
  const differences = chosen ?? rows.length >= MANY;
  const known = linesOf(columns, rows);
  const lines = differences ? known.filter(({ name }) => !isSame(name, rows)) : known;
  return (
    <Card
      title="Side by side"
      actions={
        rows.length > 1 && (
          <label className="differences">
            <input type="checkbox" checked={differences} onChange={() => choose(!differences)} />
            Differences only <span className="soft">({known.length - lines.length} of {known.length} rows hidden)</span>
          </label>
        )
      }
    >
      <div className="table-box" tabIndex={0} role="region" aria-label="Values of the runs side by side">
        <table className="texts side-by-side">
          <thead>
            <tr>
              <td />
              {rows.map(({ id }, place) => (
                <th key={id} scope="col">
                  <span className="swatch" aria-hidden="true" style={{ background: `var(${seriesVariable(place)})` }} />
                  <Link href={runHref(id)}>{id}</Link>
                </th>
              ))}
            </tr>
          </thead>
          <tbody>
            {lines.map(({ name, label, unit, help, kind }) => (
              <tr key={name} className={isSame(name, rows) ? "is-same" : undefined}>
                <th scope="row" title={help}>
                  {label}
                  {unit && <span className="soft"> ({unit})</span>}
                </th>
                {rows.map((row) => (
                  <td key={row.id} className={`is-${kind}`}>{textOf(row.cell(name)) || "–"}</td>
                ))}
              </tr>
            ))}
          </tbody>
        </table>
      </div>
    </Card>
  );
}
