import { describe, expect, it } from "vitest";

import { polylines } from "./sparkline";

describe("polylines", () => {
  it("fill the drawing, the largest value on top", () => {
    expect(polylines({ name: "depth", x: [0, 5, 10], y: [0, 2, 4] })).toEqual(["2.0,18.0 40.0,10.0 78.0,2.0"]);
  });

  it("begin anew after a gap", () => {
    const drawn = polylines({ name: "depth", x: [0, 1, 2, 3, 4], y: [0, 1, null, 1, 0] });
    expect(drawn.map((line) => line.split(" ").length)).toEqual([2, 2]);
  });

  it("lie in the middle where nothing changes, and are none of less than two points", () => {
    expect(polylines({ name: "depth", x: [0, 1], y: [3, 3] })).toEqual(["2.0,10.0 78.0,10.0"]);
    expect(polylines({ name: "", x: [], y: [] })).toEqual([]);
    expect(polylines({ name: "depth", x: [1], y: [1] })).toEqual([]);
  });
});
