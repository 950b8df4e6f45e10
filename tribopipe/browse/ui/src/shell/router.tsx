import { useMemo, useSyncExternalStore, type AnchorHTMLAttributes, type MouseEvent } from "react";

import { newEntry } from "./scroll";

/** Where the user is. Everything a page shows follows from it, so an address can be shared. */
export interface Address {
  path: string;
  query: URLSearchParams;
}

type Query = URLSearchParams | Record<string, string>;

const MOVED = "tribopipe:moved";

/** The address of a page; commas stay readable, and empty values are left out. */
export function addressOf(path: string, query: Query = {}): string {
  const kept = new URLSearchParams([...new URLSearchParams(query)].filter(([, value]) => value !== ""));
  return kept.size ? `${path}?${kept.toString().replaceAll("%2C", ",")}` : path;
}

export const runHref = (id: string): string => `/runs/${encodeURIComponent(id)}`;
export const studyHref = (id: string): string => `/studies/${encodeURIComponent(id)}`;
export const fileHref = (file: string, path: string): string => addressOf("/file", { file, path });

/** Go to another address; another page begins at its top. */
export function go(href: string, { replace = false } = {}): void {
  const before = location.pathname;
  if (replace) history.replaceState(history.state, "", href);
  else history.pushState(newEntry(), "", href);
  window.dispatchEvent(new Event(MOVED));
  if (location.pathname !== before) window.scrollTo(0, 0);
}

/** Change parts of the query and stay on the page; null or "" takes a part out. */
export function setQuery(changes: Record<string, string | null>, options: { replace?: boolean } = {}): void {
  const query = new URLSearchParams(location.search);
  for (const [name, value] of Object.entries(changes)) query.set(name, value ?? "");
  go(addressOf(location.pathname, query), options);
}

function subscribe(changed: () => void): () => void {
  window.addEventListener(MOVED, changed);
  window.addEventListener("popstate", changed);
  return () => {
    window.removeEventListener(MOVED, changed);
    window.removeEventListener("popstate", changed);
  };
}

/** The address, followed as it changes. */
export function useAddress(): Address {
  const path = useSyncExternalStore(subscribe, () => location.pathname);
  const search = useSyncExternalStore(subscribe, () => location.search);
  const query = useMemo(() => new URLSearchParams(search), [search]);
  return { path, query };
}

type LinkProps = AnchorHTMLAttributes<HTMLAnchorElement> & { href: string };

/** A link to a page of the client: opens in place; with a modifier key or another button as links do. */
export function Link({ href, onClick, ...rest }: LinkProps) {
  const follow = (event: MouseEvent<HTMLAnchorElement>) => {
    onClick?.(event);
    const plain = event.button === 0 && !(event.metaKey || event.ctrlKey || event.shiftKey || event.altKey);
    if (event.defaultPrevented || !plain) return;
    event.preventDefault();
    go(href);
  };
  return <a href={href} onClick={follow} {...rest} />;
}
