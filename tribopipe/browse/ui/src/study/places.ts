/** Where a study is asked for, below /api. */
export const studyApi = (id: string): `studies/${string}` => `studies/${encodeURIComponent(id)}`;
