import { describe, expect, it } from "vitest";

import { ApiError } from "../api";
import { failed, remember, toShow, type Held } from "./held";

const held = (path: string, question: string, answer: unknown = question): Held => ({
  path,
  question,
  answer,
  error: null,
});

const gone = new ApiError(404, "found no such run");
const broken = new ApiError(500, "the disk is full");

describe("toShow", () => {
  it("is loading until anything came; a page that asks nothing is not", () => {
    expect(toShow("runs", "q0", null)).toEqual({ answer: null, error: null, loading: true, stale: true });
    expect(toShow(null, "q0", null).loading).toBe(false);
  });

  it("is the answer to the question, fresh", () => {
    expect(toShow("runs", "q1", held("runs", "q1"))).toEqual({
      answer: "q1",
      error: null,
      loading: false,
      stale: false,
    });
  });

  it("is the answer before while another query of the same path is asked", () => {
    expect(toShow("runs", "q2", held("runs", "q1"))).toEqual({
      answer: "q1",
      error: null,
      loading: false,
      stale: true,
    });
  });

  it("is never the answer of another path", () => {
    expect(toShow("runs/a", "q3", held("runs/b", "q1"))).toMatchObject({ answer: null, loading: true });
  });

  it("is what an earlier page left behind, until it is asked for again", () => {
    remember("back", "left");
    expect(toShow("runs", "back", null)).toMatchObject({ answer: "left", loading: false, stale: true });
    expect(toShow("runs", "back", held("runs", "back", "new"))).toMatchObject({ answer: "new", stale: false });
  });
});

describe("failed", () => {
  it("keeps the answer before, with the error beside it", () => {
    const after = failed("runs", "q2", broken)(held("runs", "q1"));
    expect(toShow("runs", "q2", after)).toEqual({ answer: "q1", error: broken, loading: false, stale: true });
    expect(failed("runs", "q2", broken)(held("studies", "q1")).answer).toBeNull();
  });

  it("shows nothing of what is gone, not even once it is asked for again", () => {
    remember("q4", "old");
    const after = failed("runs/a", "q4", gone)(held("runs/a", "q4", "old"));
    expect(toShow("runs/a", "q4", after)).toEqual({ answer: null, error: gone, loading: false, stale: true });
    expect(toShow("runs/a", "q4", null).answer).toBeNull();
  });

  it("says nothing of the failure of an earlier question", () => {
    const after = failed("runs", "q5", broken)(null);
    expect(toShow("runs", "q6", after)).toMatchObject({ error: null, loading: true });
  });
});

describe("remember", () => {
  it("keeps the last twelve, counted from when they last came", () => {
    for (let number = 0; number < 12; number++) remember(`r${number}`, number);
    remember("r0", "again");
    remember("r12", 12);
    const kept = (question: string) => toShow("runs", question, null).answer;
    expect([kept("r0"), kept("r1"), kept("r2"), kept("r12")]).toEqual(["again", null, 2, 12]);
  });
});
