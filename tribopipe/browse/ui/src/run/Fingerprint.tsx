import { CopyButton } from "../components/CopyButton";

const SHOWN = 12;

/** The first digits of a SHA-256, and a way to copy it whole. */
export function Fingerprint({ sha256, of }: { sha256: string; of: string }) {
  return (
    <span className="fingerprint">
      <code title={sha256}>{sha256.slice(0, SHOWN)}…</code>
      <CopyButton text={sha256} what={`SHA-256 of ${of}`} />
    </span>
  );
}
