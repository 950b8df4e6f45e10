import type { ReactNode } from "react";

interface Props {
  tone?: "plain" | "bad" | "warn" | "good";
  children: ReactNode;
}

/** A short word on something: a tag, an outcome, a mark. */
export function Chip({ tone = "plain", children }: Props) {
  return <span className={`chip chip-${tone}`}>{children}</span>;
}
