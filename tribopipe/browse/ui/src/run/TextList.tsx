import { unbroken } from "./words";

interface Props {
  texts: string[];
  /** "notes": what to beware of; "sentences": what is said. */
  kind: "notes" | "sentences";
}

const isGrave = (text: string): boolean => /^(error|warning): /.test(text);

/** Texts, each in a line of its own; nothing where there is none. */
export function TextList({ texts, kind }: Props) {
  if (texts.length === 0) return null;
  return (
    <ul className={texts.some(isGrave) ? `${kind} is-grave` : kind}>
      {texts.map((text, place) => (
        <li key={place}>{unbroken(text)}</li>
      ))}
    </ul>
  );
}
