import { useState, type FormEvent } from "react";

import type { ApiError, Column } from "../api";
import { setQuery } from "../shell/router";

interface Props {
  columns: Column[];
  where: string;
  /** Why the server did not take it. */
  error: ApiError | null;
}

/** A filter in the language of `tribopipe ls --where`; the server reads it. */
export function QueryBox({ columns, where, error }: Props) {
  const [text, setText] = useState(where);
  const [before, setBefore] = useState(where);
  if (where !== before) {
    setBefore(where);
    setText(where);
  }

  const ask = (event: FormEvent) => {
    event.preventDefault();
    setQuery({ where: text.trim() });
  };

  return (
    <form className="query" role="search" aria-label="Filter" onSubmit={ask}>
      <label htmlFor="where">Filter</label>
      <input
        id="where"
        type="search"
        list="completions"
        placeholder="material=Si3N4 load>300mN"
        autoComplete="off"
        autoCapitalize="none"
        spellCheck={false}
        value={text}
        aria-invalid={error !== null}
        aria-describedby={error ? "where-error" : undefined}
        onChange={(event) => setText(event.target.value)}
      />
      <datalist id="completions">
        {completions(text, columns).map(({ value, label }) => (
          <option key={value} value={value}>
            {label}
          </option>
        ))}
      </datalist>
      <button type="submit" className="button">
        Apply
      </button>
      {error && (
        <p id="where-error" className="query-error" role="alert">
          {error.message}
        </p>
      )}
    </form>
  );
}

/** The text with its last word completed to a name of a column. */
function completions(text: string, columns: Column[]): { value: string; label: string }[] {
  const begun = /[^\s!]*$/.exec(text)?.[0] ?? "";
  const ahead = text.slice(0, text.length - begun.length);
  return columns
    .filter(({ name }) => name.startsWith(begun) && name !== begun)
    .map(({ name, label, unit }) => ({ value: ahead + name, label: unit ? `${label}, ${unit}` : label }));
}
