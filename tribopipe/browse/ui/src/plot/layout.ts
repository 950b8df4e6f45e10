import type { Panel } from "../api";

const RESIDUAL = 0.45;
const OF_EACH_MORE = 0.45;

/** Heights of panels that stand below each other, in pixels; residuals take less. Two have the height of one. */
export function heights(panels: Panel[], height: number): number[] {
  const all = height * Math.max(1, panels.length * OF_EACH_MORE);
  const weights = panels.map((panel) => (isResidual(panel) ? RESIDUAL : 1));
  const sum = weights.reduce((one, other) => one + other, 0);
  return weights.map((weight) => Math.round((all * weight) / sum));
}

export const isResidual = ({ lines }: Panel): boolean =>
  lines.length > 0 && lines.every(({ role }) => role === "residual");
