import { describe, expect, it } from "vitest";

import { panelSummary, sizeText } from "./summary";
import { lineOf, markOf, panelOf, plotOf } from "./testing";

describe("summary", () => {
  it("say what a panel spans, its lines and its end values", () => {
    const panel = panelOf({
      lines: [lineOf({ name: "measured" }), lineOf({ name: "fit" })],
      marks: [markOf({ name: "profile", y: 2, half_width: 0.5, value: "2.00 ± 0.26 µm (± u)" })],
    });
    expect(panelSummary(panel, plotOf().x, { from: 0, to: 100 }, [-1, 12.5])).toBe(
      "wear / µm from −1 to 12.5 against time / s from 0 to 100; lines: measured, fit; profile: 2.00 ± 0.26 µm (± u)",
    );
    expect(panelSummary(panelOf(), plotOf().x, { from: 0, to: 1 }, [0, 1])).toContain("lines: none");
  });

  it("say how many samples the points stand for", () => {
    expect(sizeText(plotOf({ points: 2400, samples: 2_000_000 }))).toBe("2,400 points of 2,000,000 samples");
    expect(sizeText(plotOf({ points: 1200, samples: 1200 }))).toBe("1,200 samples");
  });
});
