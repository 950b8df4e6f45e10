import { Chip } from "../components/Chip";

const KNOWN = {
  supported: { sign: "✓", tone: "good" },
  "over-predicts": { sign: "▲", tone: "bad" },
  "under-predicts": { sign: "▼", tone: "bad" },
  "not decidable": { sign: "?", tone: "warn" },
} as const;

/** A verdict in a word, with a sign of its own. */
export function Outcome({ name }: { name: string }) {
  const { sign, tone } = Object.hasOwn(KNOWN, name) ? KNOWN[name as keyof typeof KNOWN] : KNOWN["not decidable"];
  return (
    <Chip tone={tone}>
      <span aria-hidden="true">{sign}</span> {name}
    </Chip>
  );
}
