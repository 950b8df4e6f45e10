import "./theme.css";
import "./components/components.css";
import "./shell/shell.css";

import { StrictMode } from "react";
import { createRoot } from "react-dom/client";

import { App } from "./shell/App";
import { watchPrinting } from "./shell/printing";
import { watchArchive } from "./shell/revision";
import { dress, followSystem } from "./shell/theme";

dress();
followSystem();
watchPrinting();
watchArchive();
createRoot(document.getElementById("root")!).render(
  <StrictMode>
    <App />
  </StrictMode>,
);
