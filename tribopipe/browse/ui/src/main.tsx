import "@h5web/app/styles.css";
import { App, H5GroveProvider } from "@h5web/app";
import { createRoot } from "react-dom/client";

createRoot(document.getElementById("root")!).render(
  <H5GroveProvider url="/h5" filepath="x.h5">
    <App initialPath="/entry" />
  </H5GroveProvider>,
);
