import "./theme.css";
import "./components/components.css";
import "./shell/shell.css";

import { StrictMode } from "react";
import { createRoot } from "react-dom/client";

import { App } from "./shell/App";
import { watchArchive } from "./shell/revision";
import { dress } from "./shell/theme";

dress();
watchArchive();
createRoot(document.getElementById("root")!).render(
  <StrictMode>
    <App />
  </StrictMode>,
);
