import { afterEach, describe, expect, it, vi } from "vitest";

import { preferred } from "./opening";

/** A server of one file: what @default says at each path; `undefined` where there is no such attribute. */
function serve(defaults: Record<string, unknown>): string[] {
  const asked: string[] = [];
  vi.stubGlobal("fetch", (address: string) => {
    const query = new URL(address, "http://localhost").searchParams;
    const path = query.get("path")!;
    asked.push(`${query.get("file")}:${path}`);
    const isThere = path in defaults;
    const body = isThere ? { default: defaults[path] } : { error: `found nothing at ${path}` };
    return Promise.resolve(new Response(JSON.stringify(body), { status: isThere ? 200 : 404 }));
  });
  return asked;
}

afterEach(() => vi.unstubAllGlobals());

const found = () => preferred("studies/a+b.h5", new AbortController().signal);

describe("preferred", () => {
  it("follows @default from the root to where there is none", async () => {
    const asked = serve({ "/": "entry", "/entry": "wear", "/entry/wear": undefined });
    expect(await found()).toBe("/entry/wear");
    expect(asked).toEqual(["studies/a+b.h5:/", "studies/a+b.h5:/entry", "studies/a+b.h5:/entry/wear"]);
  });

  it.each([[undefined], [""], ["."], [3], [null]])("stays where @default is %j", async (said) => {
    serve({ "/": said });
    expect(await found()).toBe("/");
  });

  it("gives up following after eight groups", async () => {
    const asked = serve(Object.fromEntries(Array.from({ length: 20 }, (_, depth) => ["/a".repeat(depth) || "/", "a"])));
    expect(await found()).toBe("/a".repeat(8));
    expect(asked).toHaveLength(8);
  });

  it("fails with the server's sentence where @default leads nowhere", async () => {
    serve({ "/": "gone" });
    await expect(found()).rejects.toThrow("found nothing at /gone");
  });
});
