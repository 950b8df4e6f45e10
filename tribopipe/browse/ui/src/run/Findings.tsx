import type { Run } from "../api";
import { Chip } from "../components/Chip";
import { FoldedCard } from "./FoldedCard";
import { isFitted } from "./glance";
import { problems } from "./status";
import { unbroken } from "./words";

type Finding = Run["findings"][number];

const SIGNS = { error: "✕", warning: "!", note: "i" } as const;
const TONES = { error: "bad", warning: "warn", note: "plain" } as const;

/** What a person should know of a run before trusting it, the gravest first. */
export function Findings({ run }: { run: Run }) {
  const open = !isFitted(run.stages) || run.findings.some(({ severity }) => severity === "error");
  return (
    <FoldedCard title={`Findings: ${problems(run)}`} id="findings" open={open}>
      {() => <FindingList findings={run.findings} />}
    </FoldedCard>
  );
}

function FindingList({ findings }: { findings: Finding[] }) {
  if (findings.length === 0) return <p className="soft">No problems found by checks or fits.</p>;
  const grave = Object.keys(SIGNS);
  const ordered = [...findings].sort((a, b) => grave.indexOf(a.severity) - grave.indexOf(b.severity));
  return (
    <ul className="findings" aria-label="Findings from checks and fits">
      {ordered.map(({ severity, text, help }, place) => (
        <li key={place}>
          <Severity name={severity} />
          <span>
            {unbroken(text)}
            {help && (
              <span className="finding-help">
                Causes and remedies: <code>tribopipe help {help}</code>
              </span>
            )}
          </span>
        </li>
      ))}
    </ul>
  );
}

function Severity({ name }: { name: string }) {
  const known = Object.hasOwn(SIGNS, name) ? (name as keyof typeof SIGNS) : "note";
  return (
    <Chip tone={TONES[known]}>
      <span aria-hidden="true">{SIGNS[known]}</span> {name}
    </Chip>
  );
}
