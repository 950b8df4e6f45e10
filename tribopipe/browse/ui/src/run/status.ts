import type { Run } from "../api";
import { isFitted } from "./glance";
import { counted } from "./words";

/** How far a run was evaluated, in a few words. */
export function progress({ stages }: Run): string {
  if (stages.length === 0) return "archived, not evaluated";
  const predicted = stages.some(({ name }) => name.startsWith("prediction_"));
  const fitted = isFitted(stages) ? "wear coefficient identified" : "no wear coefficient identified";
  return predicted ? `${fitted}, wear predicted` : fitted;
}

const SEVERITIES = ["error", "warning", "note"];

/** "1 error, 2 warnings", or that there are no problems. */
export function problems({ findings }: Run): string {
  const counts = SEVERITIES.map((name) => [name, findings.filter(({ severity }) => severity === name).length] as const);
  const found = counts.filter(([, count]) => count > 0).map(([name, count]) => counted(count, name));
  return found.join(", ") || "no problems found";
}

/** Something that was not measured, and what to do about it. */
export interface Unmeasured {
  what: string;
  remedy: string;
}

/** What was not measured in a run and how it can still be added. */
export function unmeasured({ facts }: Run): Unmeasured[] {
  const group = (title: string) => facts.find((one) => one.title === title)?.facts ?? [];
  const signals = new Set(group("Signals").map(({ name }) => name));
  const friction = signals.has("friction force") || signals.has("friction coefficient");
  return [
    ...(group("Post-test measurements").length > 0
      ? []
      : [
          {
            what: "Wear scar after the test",
            remedy: "enter the measurement under [end_values] in run.toml and run `tribopipe process RUN_FOLDER --amend`",
          },
        ]),
    ...(signals.has("depth") ? [] : [{ what: "Depth", remedy: "record a depth signal for a wear curve" }]),
    ...(friction ? [] : [{ what: "Friction", remedy: "record the friction force for a friction coefficient" }]),
  ];
}
