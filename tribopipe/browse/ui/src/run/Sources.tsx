import type { Run } from "../api";
import { FoldedCard } from "./FoldedCard";
import { Fingerprint } from "./Fingerprint";
import { apiOf } from "./places";
import { size } from "./words";

/** The files as they came, byte for byte. */
export function Sources({ run }: { run: Run }) {
  return (
    <FoldedCard title="Source files" id="sources">
      {() => (
        <>
          <p className="soft">Kept in the archive byte for byte.</p>
          <div className="table-box" tabIndex={0} role="region" aria-label="Source files">
            <table className="texts">
              <thead>
                <tr>
                  <th scope="col">file</th>
                  <th scope="col">size</th>
                  <th scope="col">SHA-256</th>
                </tr>
              </thead>
              <tbody>
                {run.sources.map((source) => (
                  <tr key={source.number}>
                    <td>
                      <a className="file-name" href={`/api/${apiOf(run.id)}/sources/${source.number}`} download>
                        {source.name}
                      </a>
                    </td>
                    <td title={`${source.size.toLocaleString("en")} bytes`}>{size(source.size)}</td>
                    <td>
                      <Fingerprint sha256={source.sha256} of={source.name} />
                    </td>
                  </tr>
                ))}
              </tbody>
            </table>
          </div>
        </>
      )}
    </FoldedCard>
  );
}
