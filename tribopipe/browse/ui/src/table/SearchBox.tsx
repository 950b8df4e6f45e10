interface Props {
  text: string;
  onType(text: string): void;
}

/** Words that must stand somewhere in a row. */
export function SearchBox({ text, onType }: Props) {
  return (
    <div className="search">
      <label htmlFor="search">Search</label>
      <input
        id="search"
        type="search"
        placeholder="text in any column"
        autoComplete="off"
        spellCheck={false}
        value={text}
        onChange={(event) => onType(event.target.value)}
      />
    </div>
  );
}
