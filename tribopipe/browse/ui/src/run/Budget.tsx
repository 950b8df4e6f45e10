import type { TextTable as Table } from "../api";

const share = (row: string[]): number => Number.parseFloat(row.at(-1) ?? "") || 0;

/** How much each input adds to the uncertainty of a result: the last column as numbers, and as bars from zero. */
export function Budget({ table }: { table: Table }) {
  const largest = Math.max(...table.rows.map((row) => Math.abs(share(row)))) || 1;
  return (
    <div className="table-box" tabIndex={0} role="region" aria-label={table.title}>
      <table className="texts budget">
        <caption>{table.title}</caption>
        <thead>
          <tr>
            {table.columns.map((name, place) => (
              <th key={place} scope="col">
                {name}
              </th>
            ))}
          </tr>
        </thead>
        <tbody>
          {table.rows.map((row, place) => (
            <tr key={place}>
              {row.slice(0, -1).map((text, column) => (
                <td key={column}>{text}</td>
              ))}
              <td>
                <div className="share">
                  <span>{row.at(-1)}</span>
                  <Bar part={share(row) / largest} />
                </div>
              </td>
            </tr>
          ))}
        </tbody>
      </table>
      <p className="soft small">Bars to the right: the result grows with the input; to the left: it falls.</p>
    </div>
  );
}

/** To the right of zero where the result grows with the input, to the left where it falls. */
function Bar({ part }: { part: number }) {
  const side = part < 0 ? { right: "50%" } : { left: "50%" };
  return (
    <span className="bar" aria-hidden="true">
      <span className={part < 0 ? "bar-falls" : "bar-grows"} style={{ ...side, width: `${50 * Math.abs(part)}%` }} />
    </span>
  );
}
