import { Chip } from "../components/Chip";

const KNOWN = {
  consistent: { sign: "✓", tone: "good" },
  "over-predicted": { sign: "▲", tone: "bad" },
  "under-predicted": { sign: "▼", tone: "bad" },
  inconclusive: { sign: "?", tone: "warn" },
} as const;

/** Agreement of a run with a law in one word, with its sign. */
export function Outcome({ name }: { name: string }) {
  const { sign, tone } = Object.hasOwn(KNOWN, name) ? KNOWN[name as keyof typeof KNOWN] : KNOWN.inconclusive;
  return (
    <Chip tone={tone}>
      <span aria-hidden="true">{sign}</span> {name}
    </Chip>
  );
}
