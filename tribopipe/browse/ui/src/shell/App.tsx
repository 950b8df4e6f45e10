import { Suspense, useEffect, useRef } from "react";

import { Loading } from "../components/Loading";
import { ArchiveProvider } from "./archive";
import { Boundary } from "./Boundary";
import { Header } from "./Header";
import { Page } from "./Page";
import { useWatch } from "./revision";
import { useAddress } from "./router";

/** Header, and below it the page that the address names. */
export function App() {
  const { path } = useAddress();
  const main = useFocusOnMove(path);
  return (
    <ArchiveProvider>
      <a className="skip" href="#main">
        Skip to content
      </a>
      <Header path={path} />
      <main id="main" ref={main} tabIndex={-1}>
        <Unreachable />
        <Boundary key={path}>
          <Suspense fallback={<Loading what="the page" />}>
            <Page path={path} />
          </Suspense>
        </Boundary>
      </main>
    </ArchiveProvider>
  );
}

/** Another page takes the focus, so that keyboard and screen reader go on from its beginning. */
function useFocusOnMove(path: string) {
  const main = useRef<HTMLElement>(null);
  const before = useRef(path);
  useEffect(() => {
    if (before.current !== path) main.current?.focus({ preventScroll: true });
    before.current = path;
  }, [path]);
  return main;
}

function Unreachable() {
  const { reachable } = useWatch();
  if (reachable) return null;
  return (
    <div className="notice notice-warn notice-wide" role="status">
      <strong>The server does not respond.</strong> The page shows the last data received; start <code>tribopipe browse</code> again
      to continue.
    </div>
  );
}
