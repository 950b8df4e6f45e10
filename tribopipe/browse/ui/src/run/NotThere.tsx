import type { ApiError } from "../api";
import { Failure } from "../components/Failure";
import { Link } from "../shell/router";

interface Props {
  title: string;
  error: ApiError;
  /** Where to go on from here. */
  back: { href: string; label: string };
}

/** What is shown in the place of something that is gone, never was, or cannot be read. */
export function NotThere({ title, error, back }: Props) {
  return (
    <div className="page">
      <div className="page-head">
        <h1>{title}</h1>
      </div>
      <Failure error={error}>
        <p>
          <Link href={back.href}>{back.label}</Link>
        </p>
      </Failure>
    </div>
  );
}
