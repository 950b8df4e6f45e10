import type { TextTable as Table } from "../api";
import { TextTable } from "../components/TextTable";

const numberOf = (share: string | undefined): number => Number.parseFloat(share ?? "") || 0;

/** How much each input adds to the uncertainty of a result: the last column as numbers, and as bars from zero. */
export function Budget({ table }: { table: Table }) {
  const largest = Math.max(...table.rows.map((row) => Math.abs(numberOf(row.at(-1))))) || 1;
  return (
    <>
      <TextTable table={table} last={(share) => <Share text={share} part={numberOf(share) / largest} />} />
      <p className="soft small">Bars to the right: the result grows with the input; to the left: it falls.</p>
    </>
  );
}

function Share({ text, part }: { text: string; part: number }) {
  return (
    <div className="share">
      <span>{text}</span>
      <Bar part={part} />
    </div>
  );
}

/** To the right of zero where the result grows with the input, to the left where it falls. */
function Bar({ part }: { part: number }) {
  const side = part < 0 ? { right: "50%" } : { left: "50%" };
  return (
    <span className="bar" aria-hidden="true">
      <span className={part < 0 ? "bar-falls" : "bar-grows"} style={{ ...side, width: `${50 * Math.abs(part)}%` }} />
    </span>
  );
}
