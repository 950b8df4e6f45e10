/** What to beware of. */
export function Notes({ notes }: { notes: string[] }) {
  if (notes.length === 0) return null;
  return (
    <ul className="notes">
      {notes.map((note, place) => (
        <li key={place}>{note}</li>
      ))}
    </ul>
  );
}
