/** Something is on its way; announced politely, and shown only once it takes a moment. */
export function Loading({ what }: { what: string }) {
  return (
    <p className="loading" role="status">
      <span className="loading-dot" aria-hidden="true" />
      Loading {what} …
    </p>
  );
}
