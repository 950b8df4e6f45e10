import type { Remark } from "../api";
import { Card } from "../components/Card";
import { Chip } from "../components/Chip";
import { moment } from "./words";

const SAID: Record<Remark["kind"], { word: string; sign: string; tone: "plain" | "bad" | "good" }> = {
  bad: { word: "marked bad", sign: "✕", tone: "bad" },
  good: { word: "bad mark removed", sign: "✓", tone: "good" },
  tag: { word: "tagged", sign: "+", tone: "plain" },
  untag: { word: "tag removed", sign: "−", tone: "plain" },
  note: { word: "note", sign: "“", tone: "plain" },
  amended: { word: "run.toml amended", sign: "✎", tone: "plain" },
};

/** Everything people said of a run, the newest first. */
export function Remarks({ remarks }: { remarks: Remark[] }) {
  return (
    <Card title="Remarks" id="remarks">
      <ol className="remarks">
        {remarks.toReversed().map((remark, place) => (
          <Said key={place} remark={remark} />
        ))}
      </ol>
    </Card>
  );
}

function Said({ remark: { kind, text, date, operator } }: { remark: Remark }) {
  const { word, sign, tone } = SAID[kind];
  return (
    <li>
      <Chip tone={tone}>
        <span aria-hidden="true">{sign}</span> {word}
      </Chip>
      <span className="remark-text">{text}</span>
      <span className="soft">
        <time dateTime={date}>{moment(date)}</time>
        {operator && `, ${operator}`}
      </span>
    </li>
  );
}
