import { describe, expect, it } from "vitest";

import type { Column } from "../api";
import { begunValue, completions } from "./completions";

const columnOf = (name: string, given: Partial<Column> = {}): Column => ({
  name,
  label: name,
  unit: "",
  help: "",
  kind: "text",
  shown: true,
  ...given,
});
const COLUMNS = [
  columnOf("material", { joint: " / " }),
  columnOf("medium"),
  columnOf("load", { kind: "number", unit: "mN" }),
  columnOf("started", { kind: "date" }),
  columnOf("comment"),
];
const VALUES: Record<string, string[]> = {
  material: ["Si3N4", "steel", "WC-Co"],
  medium: ["air", "water vapor"],
  started: ["2026-03-01"],
  comment: ['the "old" pin'],
};
const completed = (text: string) =>
  completions(text, COLUMNS, VALUES[begunValue(text, COLUMNS)?.column.name ?? ""] ?? []).map(({ value }) => value);

describe("completions", () => {
  it("complete names of columns", () => {
    expect(completed("lo")).toEqual(["load"]);
    expect(completed("load>300mN m")).toEqual(["load>300mN material", "load>300mN medium"]);
  });

  it("complete values that runs have", () => {
    expect(completed("material=")).toEqual(["material=Si3N4", "material=steel", "material=WC-Co"]);
    expect(completed("load>1N material!=S")).toEqual(["load>1N material!=Si3N4", "load>1N material!=steel"]);
    expect(completed("medium=water v")).toEqual(["medium=water vapor"]);
    expect(completed('medium="wat')).toEqual(["medium=water vapor"]);
  });

  it("complete dates, and no numbers", () => {
    expect(completed("started=2026")).toEqual(["started=2026-03-01"]);
    expect(completed("load=2")).toEqual([]);
  });

  it("quote what looks like another term", () => {
    expect(completed("comment=the")).toEqual(['comment="the ""old"" pin"']);
  });

  it("offer nothing that is typed already", () => {
    expect(completed("medium=air")).toEqual([]);
  });
});
