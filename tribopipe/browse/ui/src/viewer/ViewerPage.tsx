import "./viewer.css";

import { useCallback, useState } from "react";

import type { ApiError } from "../api";
import { Empty } from "../components/Empty";
import { Failure } from "../components/Failure";
import { Loading } from "../components/Loading";
import { fileHref, go, Link, useAddress } from "../shell/router";
import { useTitle } from "../shell/useTitle";
import { useOpening } from "./opening";
import { ownerOf } from "./owner";
import { Viewer } from "./Viewer";

/** The HDF5 viewer on a file of the archive, at a path that the address names. */
export default function ViewerPage() {
  const { query } = useAddress();
  const file = query.get("file") ?? "";
  useTitle(file || "Viewer");
  if (file === "") return <NoFile />;
  return (
    <div className="viewer-page">
      <Bar file={file} />
      <Opened key={file} file={file} asked={query.get("path") ?? ""} />
    </div>
  );
}

function Bar({ file }: { file: string }) {
  const { href, label } = ownerOf(file);
  return (
    <div className="viewer-bar">
      <Link href={href}>
        <span aria-hidden="true">←</span> {label}
      </Link>
      <code>{file}</code>
    </div>
  );
}

/** The path of the address is read once; from then on it is written there as the user goes about. */
function Opened({ file, asked: first }: { file: string; asked: string }) {
  const [asked] = useState(first);
  const { path, error } = useOpening(file, asked);
  const keep = useCallback((shown: string) => {
    if (new URLSearchParams(location.search).get("path") !== shown) go(fileHref(file, shown), { replace: true });
  }, [file]);
  if (error) return <NotOpened file={file} path={asked} error={error} />;
  if (path === null) return <Loading what="the file" />;
  return <Viewer file={file} path={path} onPath={keep} />;
}

function NotOpened({ file, path, error }: { file: string; path: string; error: ApiError }) {
  return (
    <div className="page">
      <div className="page-head">
        <h1>{file}</h1>
      </div>
      <Failure error={error}>
        <p className="ways">
          {path !== "" && <a href={fileHref(file, "")}>Open the file at its root</a>}
          <Link href="/">All runs</Link>
        </p>
      </Failure>
    </div>
  );
}

function NoFile() {
  return (
    <div className="page">
      <h1 className="hidden">Viewer</h1>
      <Empty title="No file selected.">
        <p>
          Select a run in the <Link href="/">table of runs</Link>, and open its file from its page.
        </p>
      </Empty>
    </div>
  );
}
