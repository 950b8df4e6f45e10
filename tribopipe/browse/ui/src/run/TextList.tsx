interface Props {
  texts: string[];
  /** "notes": what to beware of; "sentences": what is said. */
  kind: "notes" | "sentences";
}

/** Texts, each in a line of its own; nothing where there is none. */
export function TextList({ texts, kind }: Props) {
  if (texts.length === 0) return null;
  return (
    <ul className={kind}>
      {texts.map((text, place) => (
        <li key={place}>{text}</li>
      ))}
    </ul>
  );
}
