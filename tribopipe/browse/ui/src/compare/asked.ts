/** What the compare page is asked for; all of it stands in the address. */
export interface Asked {
  runs: string[];
  what: What;
  fits: boolean;
  predictions: boolean;
  /** Axis; "" for the usual one. */
  x: string;
  from: string;
  to: string;
}

export const WHATS = [
  { name: "wear", label: "Wear" },
  { name: "friction", label: "Friction" },
  { name: "depth", label: "Depth" },
] as const;

export type What = (typeof WHATS)[number]["name"];

const NONE = "none";

/** Reads a query; fits are drawn unless it says otherwise. */
export function askedFor(query: URLSearchParams): Asked {
  const what = WHATS.find(({ name }) => name === query.get("what"))?.name ?? "wear";
  const extras = (query.get("with") ?? "fit").split(",");
  return {
    runs: listed(query.get("runs")),
    what,
    fits: extras.includes("fit"),
    predictions: extras.includes("prediction"),
    x: query.get("x") ?? "",
    from: query.get("from") ?? "",
    to: query.get("to") ?? "",
  };
}

/** Every id once. */
const listed = (text: string | null): string[] => [...new Set(text?.split(",").filter(Boolean))];

/** What is drawn beside the measurements, as an address says it. */
export function extrasText(fits: boolean, predictions: boolean, none = NONE): string {
  return [fits && "fit", predictions && "prediction"].filter(Boolean).join(",") || none;
}
