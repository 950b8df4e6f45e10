import { expect, it } from "vitest";

import { ownerOf } from "./owner";

it("leads from a file to the page of its run or study", () => {
  expect(ownerOf("run-1.h5")).toEqual({ href: "/runs/run-1", label: "Run run-1" });
  expect(ownerOf("studies/life.h5")).toEqual({ href: "/studies/life", label: "Study life" });
});
