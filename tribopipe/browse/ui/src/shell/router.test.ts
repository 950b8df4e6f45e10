import fc from "fast-check";
import { describe, expect, it } from "vitest";

import { addressOf, fileHref, runHref, studyHref } from "./router";

describe("addressOf", () => {
  it("is read back as it was written, empty values left out", () => {
    fc.assert(
      fc.property(fc.dictionary(fc.string({ unit: "grapheme" }), fc.string({ unit: "grapheme" })), (query) => {
        const read = Object.fromEntries(new URL(addressOf("/runs", query), "http://localhost").searchParams);
        expect(read).toEqual(Object.fromEntries(Object.entries(query).filter(([, value]) => value !== "")));
      }),
      { seed: 7 },
    );
  });

  it("keeps commas readable and other signs safe", () => {
    expect(addressOf("/compare", { runs: "a,b", x: "", where: "load > 1 & a%2Cb" })).toBe(
      "/compare?runs=a,b&where=load+%3E+1+%26+a%252Cb",
    );
    expect(addressOf("/", { q: "" })).toBe("/");
  });
});

describe("links", () => {
  it("hold any id as one part of the path", () => {
    expect([runHref("a/b?c#d"), studyHref("2+2")]).toEqual(["/runs/a%2Fb%3Fc%23d", "/studies/2%2B2"]);
  });

  it("open a path of a file", () => {
    expect(fileHref("studies/life.h5", "/entry")).toBe("/file?file=studies%2Flife.h5&path=%2Fentry");
  });
});
