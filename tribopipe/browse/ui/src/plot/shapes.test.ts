import { describe, expect, it } from "vitest";

import { shapeOf, shapePath, type Shape } from "./shapes";

describe("shapes", () => {
  it("differ seven times before they come round, the first having none", () => {
    const found = Array.from({ length: 14 }, (_, place) => shapeOf(place));
    expect(found[0]).toBeNull();
    expect(new Set(found.slice(0, 7)).size).toBe(7);
    expect(found.slice(7)).toEqual(found.slice(0, 7));
  });

  it("have their middle where they are drawn, whatever the radius", () => {
    for (const shape of ["triangle", "point", "square", "diamond"] satisfies Shape[]) {
      const corners = shapePath(shape, 10, 20, 2)
        .slice(1, -1)
        .split("L")
        .map((corner) => corner.split(" ").map(Number));
      const reach = corners.map(([x, y]) => Math.hypot(x! - 10, y! - 20));
      expect(Math.max(...reach)).toBeLessThan(2 * 1.35);
      expect(Math.min(...reach)).toBeGreaterThan(2 * 0.95);
    }
    expect(shapePath("circle", 10, 20, 2)).toBe("M8 20a2 2 0 1 0 4 0a2 2 0 1 0 -4 0z");
    expect(shapePath("cross", 10, 20, 2)).toBe("M8 18l4 4m0 -4l-4 4");
  });
});
