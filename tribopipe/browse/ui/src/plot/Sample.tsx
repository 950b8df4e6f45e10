import { shapePath } from "./shapes";
import type { Stroke } from "./strokes";

const WIDTH = 34;
const HEIGHT = 16;
const RADIUS = 3.5;

/** A piece of a line as it is drawn: stroke, figure, band; or a mark with its error bar. */
export function Sample({ stroke, kind }: { stroke: Stroke; kind: "line" | "band" | "mark" }) {
  const colour = `var(${stroke.colour})`;
  const [x, y] = [WIDTH / 2, HEIGHT / 2];
  const shape = kind === "mark" ? (stroke.shape ?? "circle") : stroke.shape;
  return (
    <svg width={WIDTH} height={HEIGHT} aria-hidden="true" fill={colour} stroke={colour}>
      {kind === "band" && <rect x="0" y="2" width={WIDTH} height={HEIGHT - 4} stroke="none" fillOpacity="0.2" />}
      {kind === "mark" ? (
        <path d={`M${x} 1V${HEIGHT - 1}M${x - 3} 1h6M${x - 3} ${HEIGHT - 1}h6`} strokeWidth="1.5" />
      ) : (
        <path
          d={`M1 ${y}H${WIDTH - 1}`}
          strokeWidth={Math.max(stroke.width, 1.25)}
          strokeOpacity={stroke.alpha}
          strokeDasharray={stroke.dash.join(" ") || undefined}
        />
      )}
      {shape && <path d={shapePath(shape, x, y, RADIUS)} strokeWidth="1" />}
    </svg>
  );
}
