import { useCallback, useState } from "react";

/** How far a box was scrolled in each entry of the history; the window itself is the browser's care. */
const kept = new Map<string, number>();

const entry = (): string => (history.state as { entry?: string } | null)?.entry ?? "first";

/** What marks a new entry of the history. */
export const newEntry = (): { entry: string } => ({ entry: String(Date.now()) });

/** How far a box was scrolled when this entry of the history was left, and a way to keep it as it is scrolled. */
export function useKeptScroll(): [number, (top: number) => void] {
  const [initial] = useState(() => kept.get(entry()) ?? 0);
  const keep = useCallback((top: number) => void kept.set(entry(), top), []);
  return [initial, keep];
}
