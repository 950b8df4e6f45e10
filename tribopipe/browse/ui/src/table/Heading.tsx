import type { Column } from "../api";
import type { Sort } from "./listing";

interface Props {
  column: Column;
  sort: Sort;
  onSort(sort: Sort): void;
}

/** Name and unit of a column; a click sorts by it, another the other way round. */
export function Heading({ column, sort, onSort }: Props) {
  const sorts = sort.column === column.name;
  const direction = sort.descending ? "descending" : "ascending";
  return (
    <th
      scope="col"
      className={`is-${column.kind}`}
      aria-sort={sorts ? direction : "none"}
      title={`${column.help} (${column.name})`}
    >
      <button
        type="button"
        onClick={() => onSort({ column: column.name, descending: sorts && !sort.descending })}
      >
        <span>
          {column.label}
          {sorts && <span aria-hidden="true">{sort.descending ? " ▼" : " ▲"}</span>}
        </span>
        {column.unit && <span className="unit">{column.unit}</span>}
      </button>
    </th>
  );
}
