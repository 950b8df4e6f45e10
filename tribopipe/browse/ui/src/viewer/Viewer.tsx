import "@h5web/app/styles.css";

import { App, H5GroveProvider } from "@h5web/app";
import { useState } from "react";

import { useShownPath } from "./useShownPath";

interface Props {
  file: string;
  /** Where it opens; later on the user goes where they like. */
  path: string;
  onPath: (path: string) => void;
}

/** h5web on one file of the archive. */
export function Viewer({ file, path, onPath }: Props) {
  const [first] = useState(path);
  const box = useShownPath(onPath);
  return (
    <div className="viewer" ref={box}>
      <H5GroveProvider url={`${location.origin}/h5`} filepath={file}>
        <App initialPath={first} sidebarOpen={window.matchMedia("(width > 800px)").matches} disableDarkMode />
      </H5GroveProvider>
    </div>
  );
}
