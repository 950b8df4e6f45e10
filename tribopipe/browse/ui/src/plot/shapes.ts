/** Small figures that tell lines apart without colours. */
export type Shape = "circle" | "triangle" | "square" | "diamond" | "cross" | "point";

const SHAPES: (Shape | null)[] = [null, "circle", "triangle", "square", "diamond", "cross", "point"];

/** The figure of the n-th of its kind; the first has none. */
export const shapeOf = (place: number): Shape | null => SHAPES[place % SHAPES.length]!;

/** Corners around the middle, by radius. */
const CORNERS: Record<Exclude<Shape, "circle" | "cross">, [number, number][]> = {
  triangle: [[0, -1.15], [1.05, 0.75], [-1.05, 0.75]],
  point: [[0, 1.15], [1.05, -0.75], [-1.05, -0.75]],
  square: [[-0.85, -0.85], [0.85, -0.85], [0.85, 0.85], [-0.85, 0.85]],
  diamond: [[0, -1.2], [1.2, 0], [0, 1.2], [-1.2, 0]],
};

/** The figure as an SVG path around a place; a canvas draws it, too. */
export function shapePath(shape: Shape, x: number, y: number, radius: number): string {
  if (shape === "circle") {
    return `M${x - radius} ${y}a${radius} ${radius} 0 1 0 ${2 * radius} 0a${radius} ${radius} 0 1 0 ${-2 * radius} 0z`;
  }
  if (shape === "cross") {
    return `M${x - radius} ${y - radius}l${2 * radius} ${2 * radius}m0 ${-2 * radius}l${-2 * radius} ${2 * radius}`;
  }
  return `M${CORNERS[shape].map(([right, down]) => `${x + right * radius} ${y + down * radius}`).join("L")}z`;
}
