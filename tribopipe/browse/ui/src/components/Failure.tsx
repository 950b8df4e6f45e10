import type { ReactNode } from "react";

import { ApiError } from "../api";

interface Props {
  error: ApiError;
  /** Where to go from here. */
  children?: ReactNode;
}

/** What stood in the way, in the server's own sentence. */
export function Failure({ error, children }: Props) {
  return (
    <div className="notice notice-bad" role="alert">
      <strong>{error.status === 404 ? "Not found" : "Request failed"}</strong>
      <p>{error.message}</p>
      {children}
    </div>
  );
}
