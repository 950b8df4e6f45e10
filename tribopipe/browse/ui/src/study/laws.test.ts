import { expect, it } from "vitest";

import { lawId } from "./laws";

it("names the parts of a page apart, with and without a run", () => {
  expect([lawId("archard"), lawId("archard", "run-1")]).toEqual(["law-archard", "law-archard-run-1"]);
});
