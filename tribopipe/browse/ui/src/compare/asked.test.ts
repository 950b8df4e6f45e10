import { describe, expect, it } from "vitest";

import { askedFor, extrasText } from "./asked";

const asked = (query: string) => askedFor(new URLSearchParams(query));

describe("askedFor", () => {
  it("is wear with fits on the usual axis where the address says nothing", () => {
    expect(asked("")).toEqual({ runs: [], what: "wear", fits: true, predictions: false, x: "", from: "", to: "" });
  });

  it("reads all parts", () => {
    expect(asked("runs=b,a&what=depth&with=prediction&x=distance&from=1&to=2.5")).toEqual({
      runs: ["b", "a"],
      what: "depth",
      fits: false,
      predictions: true,
      x: "distance",
      from: "1",
      to: "2.5",
    });
  });

  it("asks for every run once, in the order they come", () => {
    expect(asked("runs=b,,a,b,").runs).toEqual(["b", "a"]);
  });

  it("is wear where the address names nothing that is known", () => {
    expect(asked("what=colour").what).toBe("wear");
  });
});

describe("extrasText", () => {
  it("is read back as it was written", () => {
    for (const fits of [false, true]) {
      for (const predictions of [false, true]) {
        expect(asked(`with=${extrasText(fits, predictions)}`)).toMatchObject({ fits, predictions });
      }
    }
  });
});
