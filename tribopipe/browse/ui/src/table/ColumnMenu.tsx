import type { Column } from "../api";
import { Menu } from "../components/Menu";
import { setQuery } from "../shell/router";

interface Props {
  columns: Column[];
  chosen: Column[];
}

/** Which columns the table shows, with what each of them means and how a filter calls it. */
export function ColumnMenu({ columns, chosen }: Props) {
  const names = new Set(chosen.map(({ name }) => name));

  const toggle = (name: string) => {
    const next = columns.filter((column) => (column.name === name) !== names.has(column.name));
    setQuery({ columns: next.map((column) => column.name).join(",") || "id" }, { replace: true });
  };

  return (
    <Menu label="Columns">
      <fieldset className="column-menu">
        <legend className="hidden">Columns to show</legend>
        {columns
          .filter(({ name }) => name !== "id")
          .map(({ name, label, unit, help }) => (
            <label key={name}>
              <input type="checkbox" checked={names.has(name)} onChange={() => toggle(name)} />
              <span>
                {label}
                {unit && ` (${unit})`} {name !== label && <code>{name}</code>}
                <small>{help}</small>
              </span>
            </label>
          ))}
      </fieldset>
      <button type="button" className="button button-small" onClick={() => setQuery({ columns: null })}>
        Reset
      </button>
    </Menu>
  );
}
