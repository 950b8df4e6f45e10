import { useEffect, useState } from "react";

const WAIT_MS = 250;

/** A text as it is typed, and a way to type it; what it is kept in hears of it once the typing pauses. */
export function useDraft(value: string, keep: (text: string) => void): [string, (text: string) => void] {
  const [draft, setDraft] = useState(value);
  const [before, setBefore] = useState(value);
  if (value !== before) {
    setBefore(value);
    setDraft(value);
  }
  useEffect(() => {
    if (draft === value) return;
    const timer = window.setTimeout(() => keep(draft), WAIT_MS);
    return () => window.clearTimeout(timer);
  });
  return [draft, setDraft];
}
