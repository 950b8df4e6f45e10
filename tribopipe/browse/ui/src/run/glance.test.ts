import { describe, expect, it } from "vitest";

import type { Stage } from "../api";
import { isFitted, missing, tiles } from "./glance";

function stageOf(name: string, title: string, facts: Record<string, string>): Stage {
  const rest = {
    sentence: "",
    notes: [],
    tables: [],
    path: "",
    program_version: "",
    date: "",
    options: {},
    inputs_sha256: "",
    result_sha256: "",
  };
  return { ...rest, name, title, facts: Object.entries(facts).map(([fact, value]) => ({ name: fact, value })) };
}

const fit = stageOf("wear_fit_archard", "Wear coefficient (Archard's law)", {
  "k_D (Archard's law)": "(2.0 ± 0.1)×10⁻⁹ mm³/(N·mm)",
  "same value in mm³/(N·m)": "(2.0 ± 0.1)×10⁻⁶ mm³/(N·m)",
  "95 % CI": "1.8 to 2.2",
});
const unfitted = {
  ...stageOf("wear_fit_archard", "Wear coefficient (Archard's law)", {}),
  sentence: "archard: no wear coefficient: missing the two bodies ([contact])",
};
const drift = stageOf("drift_correction", "Drift correction", {
  "drift rate": "12 nm/min",
  "discrepancy at the end": "0.3 µm",
  "wear depth at the end": "25 µm",
  "contribution of the pin": "20 µm",
  "contribution of the disc": "5 µm",
});
const friction = stageOf("friction_fit", "Friction", { "b, steady state": "0.61", "mean of μ over the run": "0.58" });
const rates = stageOf("specific_wear", "Specific wear rate", {
  "wear rate of the pin": "3",
  "wear rate of both bodies": "4",
  "wear volume of the pin": "0.1 mm³, from the profile",
});

describe("tiles", () => {
  it("tell coefficient, depth, friction, rate and drift in this order, whatever that of the stages", () => {
    const expected = [
      "k_D (Archard's law)",
      "Wear depth at the end",
      "Steady-state μ",
      "Specific wear rate of the pin",
      "Specific wear rate of both bodies",
      "Drift rate",
    ];
    expect(tiles([drift, rates, friction, fit]).map(({ label }) => label)).toEqual(expected);
  });

  it("tell what belongs to a result in small letters", () => {
    const more = new Map(tiles([fit, drift, friction, rates]).map(({ label, more }) => [label, more]));
    expect(more.get("k_D (Archard's law)")).toBe("95 % CI: 1.8 to 2.2");
    expect(more.get("Wear depth at the end")).toBe("pin 20 µm, disc 5 µm");
    expect(more.get("Drift rate")).toBe("discrepancy 0.3 µm");
    expect(more.get("Steady-state μ")).toBe("mean over the run 0.58");
    expect(more.get("Specific wear rate of the pin")).toBe("wear volume 0.1 mm³");
    expect(more.get("Specific wear rate of both bodies")).toBe("");
  });

  it("name the bodies of a depth as the contact does", () => {
    const balls = {
      "wear depth at the end": "9 µm",
      "contribution of the ball": "8 µm",
      "contribution of the top ball": "1 µm",
    };
    const [found] = tiles([stageOf("drift_correction", "Drift correction", balls)]);
    expect(found?.more).toBe("ball 8 µm, top ball 1 µm");
  });

  it("give both discs one tile per law, each disc with its own interval", () => {
    const discs = stageOf("wear_fit_sarkar", "Wear coefficient (Sarkar's law)", {
      "k_D of the crowned disc": "1",
      "95 % CI, crowned disc": "0.9 to 1.1",
      "k_D of the cylindrical disc": "2",
      pressure: "even",
    });
    expect(tiles([discs])).toEqual([
      {
        label: "k_D (Sarkar's law)",
        value: "crowned disc: 1\ncylindrical disc: 2",
        more: "crowned disc: 95 % CI: 0.9 to 1.1",
        stage: "wear_fit_sarkar",
      },
    ]);
  });

  it("give the law to names without one", () => {
    const pin = stageOf("wear_fit_sarkar", "Wear coefficient (Sarkar's law)", { "k_D of the pin": "1" });
    expect(tiles([pin]).map(({ label }) => label)).toEqual(["k_D of the pin (Sarkar's law)"]);
  });

  it("say nothing of what was not found", () => {
    expect(
      tiles([stageOf("drift_correction", "Drift correction", {}), stageOf("friction_fit", "Friction", {})]),
    ).toEqual([]);
  });
});

describe("isFitted", () => {
  it("asks for k_D under any law", () => {
    expect([isFitted([drift, fit]), isFitted([drift]), isFitted([])]).toEqual([true, false, false]);
    expect(isFitted([drift, unfitted, fit])).toBe(true);
    expect(isFitted([drift, unfitted])).toBe(false);
  });
});

describe("missing", () => {
  it("is what a fit without k_D states", () => {
    expect(missing([drift, unfitted])).toBe("the two bodies ([contact])");
    expect([missing([drift, fit]), missing([])]).toEqual(["", ""]);
  });
});
