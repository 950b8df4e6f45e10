import { useSyncExternalStore } from "react";

export type Theme = "light" | "dark";

const KEY = "tribopipe-theme";
const CHANGED = "tribopipe:theme";
const system = window.matchMedia("(prefers-color-scheme: dark)");

/** What the user chose; null follows the system. */
function chosen(): Theme | null {
  try {
    const text = localStorage.getItem(KEY);
    return text === "light" || text === "dark" ? text : null;
  } catch {
    return null; // Storage may be forbidden; then the choice lasts as long as the page.
  }
}

function apply(theme: Theme): void {
  document.documentElement.dataset.theme = theme;
  window.dispatchEvent(new Event(CHANGED));
}

const current = (): Theme => (document.documentElement.dataset.theme === "dark" ? "dark" : "light");

const wanted = (): Theme => chosen() ?? (system.matches ? "dark" : "light");

/** Dress the page in a theme, or in what is wanted. */
export function dress(theme: Theme | null = null): void {
  apply(theme ?? wanted());
}

/** Follow the system while the user has not chosen. */
export function followSystem(): void {
  system.addEventListener("change", () => dress());
}

/** Choose; choosing what the system says follows the system again. */
export function chooseTheme(theme: Theme): void {
  const follows = theme === (system.matches ? "dark" : "light");
  try {
    if (follows) localStorage.removeItem(KEY);
    else localStorage.setItem(KEY, theme);
  } catch {
    // As above.
  }
  apply(theme);
}

function subscribe(changed: () => void): () => void {
  window.addEventListener(CHANGED, changed);
  return () => window.removeEventListener(CHANGED, changed);
}

/** The theme in force; whoever draws on a canvas reads the colours anew when it changes. */
export const useTheme = (): Theme => useSyncExternalStore(subscribe, current);
