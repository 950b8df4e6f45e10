import { Loading } from "../components/Loading";

/** The outline of a page that is on its way. */
export function Skeleton({ what }: { what: string }) {
  return (
    <div className="page">
      <Loading what={what} />
      <div className="skeleton" aria-hidden="true">
        <span className="skeleton-title" />
        <span className="skeleton-line" />
        <span className="skeleton-block" />
        <span className="skeleton-block" />
      </div>
    </div>
  );
}
