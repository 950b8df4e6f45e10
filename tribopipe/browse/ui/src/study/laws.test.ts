import { expect, it } from "vitest";

import { lawId, lawName } from "./laws";

it("names a law after whom it is from", () => {
  expect(lawName("archard")).toBe("Archard's law");
});

it("names the parts of a page apart, with and without a run", () => {
  expect([lawId("archard"), lawId("archard", "run-1")]).toEqual(["law-archard", "law-archard-run-1"]);
});
