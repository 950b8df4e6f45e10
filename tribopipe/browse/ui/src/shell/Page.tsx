import { lazy } from "react";

import { Empty } from "../components/Empty";
import { RunsPage } from "../table/RunsPage";
import { Link } from "./router";
import { useTitle } from "./useTitle";

// Each page is loaded when it is first opened; the HDF5 viewer alone is as large as all the rest.
const RunPage = lazy(() => import("../run/RunPage"));
const ScatterPage = lazy(() => import("../scatter/ScatterPage"));
const ComparePage = lazy(() => import("../compare/ComparePage"));
const StudiesPage = lazy(() => import("../study/StudiesPage"));
const StudyPage = lazy(() => import("../study/StudyPage"));
const ViewerPage = lazy(() => import("../viewer/ViewerPage"));

/** The page that stands at a path. */
export function Page({ path }: { path: string }) {
  const [kind, id, ...more] = path.split("/").slice(1).map(decoded);
  if (more.length) return <NoPage />;
  if (id !== undefined && id !== "") {
    if (kind === "runs") return <RunPage key={id} id={id} />;
    if (kind === "studies") return <StudyPage key={id} id={id} />;
    return <NoPage />;
  }
  switch (kind) {
    case "":
    case "runs":
      return <RunsPage />;
    case "scatter":
      return <ScatterPage />;
    case "compare":
      return <ComparePage />;
    case "studies":
      return <StudiesPage />;
    case "file":
      return <ViewerPage />;
    default:
      return <NoPage />;
  }
}

function decoded(part: string): string {
  try {
    return decodeURIComponent(part);
  } catch {
    return part; // "%" typed by hand; no run is called so, which the server will say.
  }
}

function NoPage() {
  useTitle("Page not found");
  return (
    <div className="page">
      <Empty title="Page not found.">
        <p>
          <Link href="/">All runs</Link>
        </p>
      </Empty>
    </div>
  );
}
