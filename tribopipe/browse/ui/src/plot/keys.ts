import type { KeyboardEvent } from "react";

import type { Step } from "./view";

const STEPS: Record<string, Step> = {
  "+": "in",
  "=": "in",
  "-": "out",
  "−": "out",
  ArrowLeft: "left",
  ArrowRight: "right",
  "0": "whole",
  Home: "whole",
};

/** The step that a key asks for; none with a modifier, which belongs to the browser. */
export function stepOf({ key, ctrlKey, metaKey, altKey }: KeyboardEvent): Step | null {
  return ctrlKey || metaKey || altKey ? null : (STEPS[key] ?? null);
}
