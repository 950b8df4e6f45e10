import type { Column } from "../api";
import { Card } from "../components/Card";
import { seriesVariable } from "../components/series";
import { Link, runHref } from "../shell/router";
import { textOf } from "../table/cells";
import type { Row } from "../table/listing";

/** What the runs' rows say, one run a column; lines that say nothing of any run are left out, the same in all are dimmed. */
export function SideBySide({ rows, columns }: { rows: Row[]; columns: Column[] }) {
  const told = columns.filter(({ name }) => name !== "id" && rows.some((row) => textOf(row.cell(name)) !== ""));
  return (
    <Card title="Side by side">
      <div className="table-box" tabIndex={0} role="region" aria-label="Numbers of the runs side by side">
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
            {told.map(({ name, label, unit, help }) => (
              <tr key={name} className={isSame(name, rows) ? "is-same" : undefined}>
                <th scope="row" title={help}>
                  {label}
                  {unit && <span className="soft"> ({unit})</span>}
                </th>
                {rows.map((row) => (
                  <td key={row.id}>{textOf(row.cell(name)) || "–"}</td>
                ))}
              </tr>
            ))}
          </tbody>
        </table>
      </div>
    </Card>
  );
}

const isSame = (name: string, rows: Row[]): boolean =>
  rows.length > 1 && new Set(rows.map((row) => textOf(row.cell(name)))).size === 1;
