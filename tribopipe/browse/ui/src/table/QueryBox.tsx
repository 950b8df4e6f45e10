import { useMemo, useState, type FormEvent } from "react";

import type { ApiError, Column, Runs } from "../api";
import { setQuery } from "../shell/router";
import { useAnswer } from "../shell/useAnswer";
import { completions } from "./completions";
import { rowsOf } from "./listing";

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
  const { answer: all } = useAnswer<Runs>(typing ? "runs" : null, { where: "" });
  const rows = useMemo(() => (all ? rowsOf(all) : []), [all]);
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
        {completions(text, columns, rows).map(({ value, label }) => (
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
