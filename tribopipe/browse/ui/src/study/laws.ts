/** "Archard's law". */
export const lawName = (model: string): string => `${model.charAt(0).toUpperCase()}${model.slice(1)}'s law`;

/** What an address with "#…" calls the part on a law, or on a run within it. */
export const lawId = (model: string, run = ""): string => ["law", model, run].filter(Boolean).join("-");
