/** What an address with "#…" calls the part on a law, or on a run within it. */
export const lawId = (model: string, run = ""): string => ["law", model, run].filter(Boolean).join("-");
