/** Where a run is asked for, below /api. */
export const apiOf = (id: string): `runs/${string}` => `runs/${encodeURIComponent(id)}`;

/** What an address with "#…" calls a stage. */
export const stageId = (stage: string): string => `stage-${stage}`;
