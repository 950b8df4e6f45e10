import type { Entry, Group } from "./entries";
import { Sample } from "./Sample";

interface Props {
  label: string;
  groups: Group[];
  onToggle(key: string): void;
}

/** What each line is and its value at the pointer, run by run where there are several. */
export function Legend({ label, groups, onToggle }: Props) {
  return (
    <div className="plot-legend">
      {groups.map(({ run, entries }) => (
        <div key={run} className="plot-legend-run">
          {run && <span className="plot-run">{run}</span>}
          <ul aria-label={run ? `Lines of ${run}: ${label}` : `Lines of ${label}`}>
            {entries.map((entry) => (
              <Item key={entry.key} entry={entry} onToggle={onToggle} />
            ))}
          </ul>
        </div>
      ))}
    </div>
  );
}

/** A press hides the line or shows it again. */
function Item({ entry, onToggle }: { entry: Entry; onToggle(key: string): void }) {
  const { key, name, stroke, kind, value, shown } = entry;
  return (
    <li>
      <button type="button" aria-pressed={shown} onClick={() => onToggle(key)}>
        <Sample stroke={stroke} kind={kind} />
        <span className="plot-name">{name}</span>
        <span className="plot-value">{value}</span>
      </button>
    </li>
  );
}
