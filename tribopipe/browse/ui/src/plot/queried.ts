import type { PlotOffer } from "../api";

/** What is asked of a plot; "" for the usual axis and the whole of it. */
export interface Queried {
  x: string;
  from: string;
  to: string;
}

/** What an address asks of a plot: its axis and range, where the plot has that axis; all of its usual one elsewhere. */
export function rangeFor({ axes }: PlotOffer, query: URLSearchParams): Queried {
  const x = query.get("x") ?? "";
  const usual = axes[0]?.name ?? "";
  if (!axes.some(({ name }) => name === x)) return { x: usual, from: "", to: "" };
  return { x, from: query.get("from") ?? "", to: query.get("to") ?? "" };
}
