import { describe, expect, it } from "vitest";

import { rangeFor } from "./queried";

describe("rangeFor", () => {
  const axis = (name: string) => ({ name, label: name });
  const offer = { name: "wear", title: "Wear", stage: "", path: "", axes: [axis("time"), axis("distance")] };
  const asked = (query: string) => rangeFor(offer, new URLSearchParams(query));

  it("takes axis and range from the address where the plot has that axis", () => {
    expect(asked("x=distance&from=1&to=2")).toEqual({ x: "distance", from: "1", to: "2" });
    expect(asked("x=cycles&from=1&to=2")).toEqual({ x: "time", from: "", to: "" });
    expect(asked("")).toEqual({ x: "time", from: "", to: "" });
  });
});
