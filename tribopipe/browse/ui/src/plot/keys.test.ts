import type { KeyboardEvent } from "react";
import { describe, expect, it } from "vitest";

import { stepOf } from "./keys";

describe("stepOf", () => {
  const step = (key: string, modifiers = {}) => stepOf({ key, ...modifiers } as KeyboardEvent);

  it("knows the keys of the plot, and leaves all others to the page", () => {
    expect(["+", "=", "-", "ArrowLeft", "ArrowRight", "0", "Home"].map((key) => step(key))).toEqual([
      "in",
      "in",
      "out",
      "left",
      "right",
      "whole",
      "whole",
    ]);
    expect(["a", "Enter", "Tab", "ArrowUp"].map((key) => step(key))).toEqual([null, null, null, null]);
  });

  it("leaves what is pressed with a modifier to the browser", () => {
    expect(["ctrlKey", "metaKey", "altKey"].map((modifier) => step("+", { [modifier]: true }))).toEqual([
      null,
      null,
      null,
    ]);
  });
});
