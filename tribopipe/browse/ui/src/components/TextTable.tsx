import type { ReactNode } from "react";

import type { TextTable as Table } from "../api";
import { unbroken } from "../run/words";

interface Props {
  table: Table;
  /** How the last cell of a row is shown, where not as text. */
  last?: (text: string) => ReactNode;
}

/** A table of texts, scrolled sideways where it does not fit. */
export function TextTable({ table, last = unbroken }: Props) {
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
                <td key={place}>{place === row.length - 1 ? last(text) : unbroken(text)}</td>
              ))}
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}
