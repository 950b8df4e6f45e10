import type { Run } from "../api";
import { Card } from "../components/Card";
import PlotSection from "../plot/PlotSection";
import { apiOf, stageId } from "./places";
import { isFitted, missing, tiles, type Tile } from "./glance";
import { unmeasured } from "./status";
import { unbroken } from "./words";

/** The results of a run, and the curve that they are about. */
export function Glance({ run }: { run: Run }) {
  const results = tiles(run.stages);
  const wear = run.plots.find(isWear);
  return (
    <Card title="Result" id="result">
      {!isFitted(run.stages) && <Unfitted run={run} />}
      {results.length > 0 && (
        <ul className="tiles">
          {results.map((result, place) => (
            <Result key={place} tile={result} />
          ))}
        </ul>
      )}
      <NotMeasured run={run} />
      {wear && (
        <PlotSection base={apiOf(run.id)} file={run.file} offer={wear} said={run.findings.map(({ text }) => text)} />
      )}
    </Card>
  );
}

/** The wear curve stands beside the results, not beside its stage. */
export const isWear = ({ name }: { name: string }): boolean => name === "wear";

function Result({ tile }: { tile: Tile }) {
  return (
    <li className="tile">
      <a className="tile-label" href={`#${stageId(tile.stage)}`}>
        {tile.label}
      </a>
      <span className="tile-value">{unbroken(tile.value)}</span>
      {tile.more && <span className="tile-more">{unbroken(tile.more)}</span>}
    </li>
  );
}

function NotMeasured({ run }: { run: Run }) {
  const left = unmeasured(run);
  if (left.length === 0) return null;
  return (
    <ul className="not-measured" aria-label="Not measured">
      {left.map(({ what, remedy }) => (
        <li key={what}>
          <strong>{what}:</strong> not measured; {withCode(remedy)}.
        </li>
      ))}
    </ul>
  );
}

/** A text with its parts in backticks as code. */
const withCode = (text: string) =>
  text.split("`").map((part, place) => (place % 2 ? <code key={place}>{part}</code> : part));

function Unfitted({ run }: { run: Run }) {
  return (
    <p className="notice notice-warn">
      <strong>No wear coefficient was identified from this run.</strong> {withCode(reason(run))}
    </p>
  );
}

function reason({ stages }: Run): string {
  if (stages.length === 0) return "It was archived but not evaluated; run `tribopipe process` on its run folder.";
  const lack = missing(stages);
  return lack
    ? `Missing: ${lack}. To add it, edit run.toml and run \`tribopipe process RUN_FOLDER --amend\`.`
    : "See the steps and the findings below for the reason.";
}
