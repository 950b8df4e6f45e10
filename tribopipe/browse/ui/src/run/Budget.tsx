import type { TextTable as Table } from "../api";
import { TextTable } from "../components/TextTable";

const numberOf = (share: string | undefined): number => Number.parseFloat(share ?? "") || 0;

/** What the variance of a result is made of: the last column as numbers, and as bars. */
export function Budget({ table }: { table: Table }) {
  const largest = Math.max(...table.rows.map((row) => numberOf(row.at(-1)))) || 1;
  return <TextTable table={table} last={(share) => <Share text={share} part={numberOf(share) / largest} />} />;
}

function Share({ text, part }: { text: string; part: number }) {
  return (
    <div className="share">
      <span>{text}</span>
      <span className="bar" aria-hidden="true">
        <span style={{ width: `${100 * part}%` }} />
      </span>
    </div>
  );
}
