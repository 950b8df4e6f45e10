import type { Archive } from "../api";

/** Files of the archive that could not be read, each with what is wrong with it. */
export function Unreadable({ files }: { files: Archive["unreadable"] }) {
  if (files.length === 0) return null;
  return (
    <details className="notice notice-warn" role="status" open={files.length <= 3}>
      <summary>
        <strong>{files.length === 1 ? "One file" : `${files.length} files`} could not be read</strong>; all others are
        listed.
      </summary>
      <ul>
        {files.map(({ file, error }) => (
          <li key={file}>{error}</li>
        ))}
      </ul>
    </details>
  );
}
