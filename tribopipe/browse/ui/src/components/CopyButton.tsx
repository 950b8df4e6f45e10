import { useEffect, useState } from "react";

interface Props {
  text: string;
  /** What is copied, for those who do not see it: "SHA-256 of motor.csv". */
  what: string;
}

const SAID_MS = 1500;

/** Puts a text on the clipboard and says so. */
export function CopyButton({ text, what }: Props) {
  const [said, say] = useState("");

  useEffect(() => {
    if (said === "") return;
    const timer = window.setTimeout(() => say(""), SAID_MS);
    return () => window.clearTimeout(timer);
  }, [said]);

  const copy = () =>
    navigator.clipboard.writeText(text).then(
      () => say("Copied"),
      () => say("Copying not permitted"),
    );

  return (
    <button type="button" className="button button-small" aria-label={`Copy ${what}`} onClick={() => void copy()}>
      <span aria-live="polite">{said || "Copy"}</span>
    </button>
  );
}
