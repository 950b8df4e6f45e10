import type { Panel, Plot } from "../api";
import { counted, read } from "./numbers";
import type { Range } from "./range";
import type { View } from "./view";

/** What a panel shows, for those who do not see it. */
export function panelSummary({ label, lines, marks }: Panel, x: Plot["x"], view: View, [low, high]: Range): string {
  const names = lines.map(({ name }) => name).join(", ");
  const values = marks.map(({ name, value }) => `${name}: ${value}`);
  return [
    `${label} from ${read(low)} to ${read(high)} against ${x.label} from ${read(view.from)} to ${read(view.to)}`,
    `lines: ${names || "none"}`,
    ...values,
  ].join("; ");
}

/** "2,400 points of 2,000,000 samples" */
export const sizeText = ({ points, samples }: Plot): string =>
  points < samples ? `${counted(points)} points of ${counted(samples)} samples` : `${counted(samples)} samples`;
