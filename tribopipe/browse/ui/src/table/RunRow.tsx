import { memo, type MouseEvent } from "react";

import type { Column } from "../api";
import { go, Link, runHref } from "../shell/router";
import { Shown } from "./Shown";
import { SparklineCell } from "./SparklineCell";
import type { Row } from "./listing";
import { textOf } from "./cells";

interface Props {
  row: Row;
  /** Its place in the whole table, for those who hear it. */
  number: number;
  columns: Column[];
  selected: boolean;
  onSelect(id: string): void;
}

/** One run: its name leads to its page, and so does a click beside it. */
export const RunRow = memo(function RunRow({ row, number, columns, selected, onSelect }: Props) {
  const bad = textOf(row.cell("mark"));
  return (
    <tr aria-rowindex={number} className={rowClass(bad !== "", selected)} onClick={open(row.id)}>
      <th scope="row">
        <input
          type="checkbox"
          checked={selected}
          aria-label={`Select ${row.id}`}
          onChange={() => onSelect(row.id)}
        />
        <Link href={runHref(row.id)}>{row.id}</Link>
      </th>
      <SparklineCell id={row.id} />
      {columns.map(({ name, kind }) => (
        <td key={name} className={`is-${kind}`}>
          <Shown column={name} text={row.shown(name)} />
        </td>
      ))}
    </tr>
  );
});

const rowClass = (bad: boolean, selected: boolean): string =>
  ["run", bad && "is-bad", selected && "is-selected"].filter(Boolean).join(" ");

/** What a click on a row does; links, boxes and texts being selected go before. */
function open(id: string) {
  return (event: MouseEvent) => {
    const onControl = (event.target as Element).closest("a, input, label, button") !== null;
    if (onControl || String(window.getSelection())) return;
    if (event.metaKey || event.ctrlKey) window.open(runHref(id), "_blank", "noopener");
    else go(runHref(id));
  };
}
