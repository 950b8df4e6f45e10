import { Chip } from "../components/Chip";

/** A cell as it is shown: tags and bad marks as chips, all else as it is written. */
export function Shown({ column, text }: { column: string; text: string }) {
  if (text === "") return null;
  if (column === "mark") return <Chip tone="bad">{text}</Chip>;
  if (column === "tags") return text.split(", ").map((tag) => <Chip key={tag}>{tag}</Chip>);
  return <span title={text}>{text}</span>;
}
