import { useVirtualizer } from "@tanstack/react-virtual";
import { useEffect, useMemo, useRef } from "react";

import type { Column } from "../api";
import { usePrinting } from "../shell/printing";
import { useKeptScroll } from "../shell/scroll";
import { Heading } from "./Heading";
import type { Row, Sort } from "./listing";
import { RunRow } from "./RunRow";
import { useRowHeight } from "./useRowHeight";
import { columnWidths } from "./widths";

interface Props {
  columns: Column[];
  /** All rows that are here, for the widths: what is filtered out must not make the columns jump. */
  all: Row[];
  /** Number of rows of the table. */
  count: number;
  /** A row by its place; none where it is not here yet. */
  rowAt(place: number): Row | undefined;
  sort: Sort;
  /** Whether newer rows are on their way. */
  stale: boolean;
  selected: ReadonlySet<string>;
  onSort(sort: Sort): void;
  onSelect(id: string): void;
  /** Is told which rows are in sight, the first and the last. */
  onSight?(first: number, last: number): void;
}

const BEYOND = 15;
const ID: Column = { name: "id", label: "run", unit: "", help: "ID of the run", kind: "text", shown: true };

/** The runs; only the rows in sight are in the document. */
export function RunsTable({ columns, all, count, rowAt, sort, stale, selected, onSort, onSelect, onSight }: Props) {
  const box = useRef<HTMLDivElement>(null);
  const [initialOffset, keepScroll] = useKeptScroll();
  const height = useRowHeight();
  const widths = useMemo(() => columnWidths(columns, all), [columns, all]);
  const virtual = useVirtualizer({
    count,
    getScrollElement: () => box.current,
    estimateSize: () => height,
    initialOffset,
    overscan: BEYOND,
    useFlushSync: false,
  });
  useEffect(() => virtual.measure(), [virtual, height]);
  const printing = usePrinting();
  const inSight = printing
    ? Array.from({ length: count }, (_, index) => ({ index, start: 0, end: 0 })).filter(({ index }) => rowAt(index))
    : virtual.getVirtualItems();
  const [first, last] = [inSight[0]?.index ?? 0, inSight.at(-1)?.index ?? 0];
  useEffect(() => {
    if (!printing) onSight?.(first, last);
  }, [printing, onSight, first, last]);
  const above = inSight[0]?.start ?? 0;
  const below = printing ? 0 : virtual.getTotalSize() - (inSight.at(-1)?.end ?? 0);

  return (
    <div className="runs-box" ref={box} onScroll={(event) => keepScroll(event.currentTarget.scrollTop)} tabIndex={0} role="region" aria-label="Runs">
      <table
        className="runs"
        aria-rowcount={count + 1}
        aria-busy={stale}
        style={{ width: widths.reduce((a, b) => a + b) }}
      >
        <colgroup>
          {widths.map((width, place) => (
            <col key={place} style={{ width }} />
          ))}
        </colgroup>
        <thead>
          <tr aria-rowindex={1}>
            <Heading column={ID} sort={sort} onSort={onSort} />
            <th scope="col" className="sparkline" title="Wear during the test, or the first recorded signal">
              curve
            </th>
            {columns.map((column) => (
              <Heading key={column.name} column={column} sort={sort} onSort={onSort} />
            ))}
          </tr>
        </thead>
        <tbody>
          <Gap height={above} columns={widths.length} />
          {inSight.map(({ index }) => {
            const row = rowAt(index);
            return row ? (
              <RunRow
                key={row.id}
                row={row}
                number={index + 2}
                columns={columns}
                selected={selected.has(row.id)}
                onSelect={onSelect}
              />
            ) : (
              <Gap key={index} height={height} columns={widths.length} />
            );
          })}
          <Gap height={below} columns={widths.length} />
        </tbody>
      </table>
    </div>
  );
}

/** Stands for the rows that are out of sight, or not here yet. */
function Gap({ height, columns }: { height: number; columns: number }) {
  if (height <= 0) return null;
  return (
    <tr aria-hidden="true" className="gap">
      <td colSpan={columns} style={{ height }} />
    </tr>
  );
}
