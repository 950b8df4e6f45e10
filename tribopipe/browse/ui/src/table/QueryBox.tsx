import { useState, type FormEvent } from "react";

import type { ApiError, Column } from "../api";
import { setQuery } from "../shell/router";
import { useAnswer } from "../shell/useAnswer";
import { begunValue, completions } from "./completions";

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
  const [typing, setTyping] = useState(false);
  const begun = typing ? begunValue(text, columns) : null;
  const { answer: values } = useAnswer<string[]>(begun && `values/${begun.column.name}`, { begins: begun?.begins ?? "" });
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
        onFocus={() => setTyping(true)}
        onChange={(event) => setText(event.target.value)}
      />
      <datalist id="completions">
        {completions(text, columns, values ?? []).map(({ value, label }) => (
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
