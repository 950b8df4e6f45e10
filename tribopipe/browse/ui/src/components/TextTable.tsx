import type { TextTable as Table } from "../api";

/** A table of texts, scrolled sideways where it does not fit. */
export function TextTable({ table }: { table: Table }) {
  return (
    <div className="table-box" tabIndex={0} role="region" aria-label={table.title}>
      <table className="texts">
        {table.title && <caption>{table.title}</caption>}
        <thead>
          <tr>
            {table.columns.map((name, index) => (
              <th key={index} scope="col">
                {name}
              </th>
            ))}
          </tr>
        </thead>
        <tbody>
          {table.rows.map((row, index) => (
            <tr key={index}>
              {row.map((text, place) => (
                <td key={place}>{text}</td>
              ))}
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}
