import { describe, expect, it } from "vitest";

import type { Cell, Column } from "../api";
import { isSame, linesOf } from "./lines";

const columnOf = (name: string): Column => ({ name, label: name, unit: "", help: "", kind: "text", shown: true });
const rowOf = (id: string, cells: Record<string, Cell>) => ({ id, cell: (name: string) => cells[name] ?? null, shown: () => "" });

const ROWS = [
  rowOf("a", { id: "a", run_toml: "1c8f", medium: "air", load: [0.2, "200"], slip: [0.04, "4"] }),
  rowOf("b", { id: "b", medium: "air", load: [0.4, "400"] }),
];

describe("lines side by side", () => {
  it("are those that some run has", () => {
    expect(linesOf(["id", "run_toml", "medium", "load", "slip", "k_d"].map(columnOf), ROWS).map(({ name }) => name)).toEqual([
      "medium",
      "load",
      "slip",
    ]);
  });

  it("differ where one run has another text, or none", () => {
    expect(["medium", "load", "slip"].map((name) => isSame(name, ROWS))).toEqual([true, false, false]);
    expect(isSame("medium", ROWS.slice(1))).toBe(false);
  });
});
