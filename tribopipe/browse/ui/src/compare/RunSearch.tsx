import { useMemo, useState } from "react";

import type { Column } from "../api";
import { textOf } from "../table/cells";
import { matching, type Row } from "../table/listing";

interface Props {
  rows: Row[];
  columns: Column[];
  chosen: string[];
  onAdd(id: string): void;
}

const OFFERED = 8;
const TOLD = ["tags", "material", "medium", "load"];

/** Finds runs by any words and adds them. */
export function RunSearch({ rows, columns, chosen, onAdd }: Props) {
  const [text, setText] = useState("");
  const told = useMemo(() => columns.filter(({ name }) => TOLD.includes(name)), [columns]);
  const found = useMemo(
    () => (text.trim() ? matching(rows, told, text).filter(({ id }) => !chosen.includes(id)) : []),
    [rows, told, text, chosen],
  );

  return (
    <div className="run-search">
      <label htmlFor="add-run">Add a run</label>
      <input
        id="add-run"
        type="search"
        placeholder="name, material, tag …"
        autoComplete="off"
        spellCheck={false}
        value={text}
        onChange={(event) => setText(event.target.value)}
        onKeyDown={(event) => event.key === "Escape" && setText("")}
      />
      <p className="hidden" role="status">
        {text.trim() && `${found.length} runs found`}
      </p>
      {text.trim() && (
        <ul className="found">
          {found.slice(0, OFFERED).map((row) => (
            <li key={row.id}>
              <button type="button" onClick={() => onAdd(row.id)}>
                <strong>{row.id}</strong> <span className="soft">{about(row, told)}</span>
              </button>
            </li>
          ))}
          {found.length > OFFERED && <li className="soft">… and {found.length - OFFERED} more</li>}
          {found.length === 0 && <li className="soft">No other matching runs.</li>}
        </ul>
      )}
    </div>
  );
}

/** "Si3N4, deionised water, 200.0 mN" */
function about(row: Row, columns: Column[]): string {
  return columns
    .map(({ name, unit }) => [textOf(row.cell(name)), unit])
    .filter(([text]) => text !== "")
    .map(([text, unit]) => (unit ? `${text} ${unit}` : text))
    .join(", ");
}
