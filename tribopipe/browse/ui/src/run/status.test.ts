import { describe, expect, it } from "vitest";

import type { Run } from "../api";
import { problems, progress, unmeasured } from "./status";

const group = (title: string, ...names: string[]) => ({ title, facts: names.map((name) => ({ name, value: "1" })) });
const found = (name: string) => (name.startsWith("wear_fit_") ? [{ name: "k_D of the pin", value: "1" }] : []);
const runOf = (stages: string[], severities: string[] = [], facts: Run["facts"] = []) =>
  ({
    stages: stages.map((name) => ({ name, facts: found(name) })),
    findings: severities.map((severity) => ({ severity, text: "", help: null })),
    facts,
  }) as Run;

describe("progress", () => {
  it.each([
    [[], "archived, not evaluated"],
    [["clean_up", "friction_fit"], "no wear coefficient identified"],
    [["wear_fit_archard"], "wear coefficient identified"],
    [["wear_fit_archard", "prediction_archard"], "wear coefficient identified, wear predicted"],
    [["prediction_archard"], "no wear coefficient identified, wear predicted"],
  ])("of a run with the steps %j is %j", (stages, words) => {
    expect(progress(runOf(stages))).toBe(words);
  });
});

describe("problems", () => {
  it("are counted, the gravest first", () => {
    expect(problems(runOf([], ["note", "warning", "error", "warning"]))).toBe("1 error, 2 warnings, 1 note");
    expect(problems(runOf([]))).toBe("no problems found");
  });
});

describe("unmeasured", () => {
  it("says what is not there", () => {
    expect(unmeasured(runOf([])).map(({ what }) => what)).toEqual(["Wear scar after the test", "Depth", "Friction"]);
    const all = [group("Signals", "time", "depth", "friction force"), group("Post-test measurements", "pin scar diameter")];
    expect(unmeasured(runOf([], [], all))).toEqual([]);
    expect(unmeasured(runOf([], [], [group("Signals", "friction coefficient"), all[1]!]))).toMatchObject([
      { what: "Depth" },
    ]);
  });
});
