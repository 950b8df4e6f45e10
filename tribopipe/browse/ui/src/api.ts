/** What the server answers; browse/answers.py is the other side of it. Texts are plain and hold whatever a lab wrote. */

export interface Fact {
  name: string;
  value: string;
}

export interface FactGroup {
  title: string;
  facts: Fact[];
}

export interface TextTable {
  title: string;
  columns: string[];
  rows: string[][];
}

export interface Column {
  name: string;
  /** Heading, without the unit. */
  label: string;
  /** As people read it; empty for texts and plain numbers. */
  unit: string;
  help: string;
  kind: "number" | "text" | "date";
  /** Whether it is shown before the user chooses. */
  shown: boolean;
  /** What is between several texts of one run; null where there is one at most. */
  joint?: string | null;
  /** A number in the unit is `factor` times that in SI, plus `offset`; numbers only. */
  factor?: number;
  offset?: number;
}

export interface Archive {
  name: string;
  folder: string;
  version: string;
  revision: string;
  runs: number;
  studies: number;
  columns: Column[];
  unreadable: { file: string; error: string }[];
}

/** A text; or a number in SI, its text in the column's unit, and its standard uncertainty in SI if known; or nothing known. */
export type Cell = string | [number, string] | [number, string, number] | null;

export interface Runs {
  revision: string;
  /** How many runs match; the rows may be a part of them. */
  total: number;
  /** How many of them come before the first row. */
  start: number;
  /** Ids, in the order of the rows. */
  ids: string[];
  columns: string[];
  rows: Cell[][];
  /** Where all runs are here: columns of numbers that need a power of ten: their unit with one power for all, and their texts under it. */
  aligned: Record<string, { unit: string; texts: string[] }>;
}

/** The first curve of a run in a few points; null where nothing was recorded, no points where it has no curve. */
export interface Sparkline {
  /** What the curve shows: "pin wear depth / µm". */
  name: string;
  x: (number | null)[];
  y: (number | null)[];
}


export interface Remark {
  kind: "bad" | "good" | "tag" | "untag" | "note" | "amended";
  text: string;
  date: string;
  operator: string | null;
}

export interface Stage {
  name: string;
  title: string;
  sentence: string;
  facts: Fact[];
  notes: string[];
  tables: TextTable[];
  /** Where it stands in the HDF5 file. */
  path: string;
  program_version: string;
  date: string;
  options: Record<string, unknown>;
  inputs_sha256: string;
  result_sha256: string;
}

export interface Source {
  number: number;
  name: string;
  size: number;
  sha256: string;
}

export interface PlotOffer {
  name: string;
  title: string;
  /** The stage beside which it is shown. */
  stage: string;
  /** What the viewer opens for it. */
  path: string;
  /** Axes it can be drawn against, the usual one first. */
  axes: { name: string; label: string }[];
}

export interface Run {
  id: string;
  /** The HDF5 file, relative to the archive folder. */
  file: string;
  title: string;
  tribometer: string | null;
  bad: string | null;
  tags: string[];
  remarks: Remark[];
  facts: FactGroup[];
  /** With the topic of `tribopipe help` that explains it; null for a check of another package. */
  findings: { severity: string; text: string; help: string | null }[];
  stages: Stage[];
  sources: Source[];
  raw_sha256: string;
  studies: string[];
  plots: PlotOffer[];
  /** Tables to download as CSV. */
  csv: { name: string; meaning: string }[];
}

export interface Line {
  name: string;
  /** Which run it belongs to. */
  run: string;
  /** How it is drawn: "measured" thin, "fit" solid, "prediction" dashed, "drift" dashed, "wander" faint, "residual" thin. */
  role: "measured" | "fit" | "prediction" | "drift" | "wander" | "residual";
  law: "archard" | "sarkar" | null;
  x: number[];
  /** null where nothing was recorded. */
  y: (number | null)[];
  /** 95 % band, where there is one. */
  lower: number[] | null;
  upper: number[] | null;
  /** The dataset it was read from, if it is one as it stands. */
  path: string | null;
}

/** A measured end value with its 95 % interval. */
export interface Mark {
  name: string;
  run: string;
  x: number;
  y: number;
  /** Of the 95 % interval, which is drawn. */
  half_width: number;
  /** As people read it, with its standard uncertainty: "33.16 ± 0.30 µm (± u)". */
  value: string;
}

export interface Panel {
  label: string;
  lines: Line[];
  marks: Mark[];
}

export interface Plot {
  name: string;
  title: string;
  words: string;
  x: { name: string; label: string; from: number; to: number };
  panels: Panel[];
  /** Samples in the range that is shown, and points that stand for them. */
  samples: number;
  points: number;
}

export interface StudyLine {
  id: string;
  title: string;
  fitted: string[];
  predicted: string[];
  agreement: string;
}

export interface AgreementLine {
  run_id: string;
  role: string;
  outcome: string;
  sentence: string;
  notes: string[];
}

export interface LawPage {
  model: string;
  /** "Archard's law". */
  heading: string;
  /** The same with its k_D and interval. */
  title: string;
  tables: TextTable[];
  sentences: string[];
  agreement: AgreementLine[];
}

export interface Study {
  id: string;
  file: string;
  title: string;
  fitted: string[];
  predicted: string[];
  laws: LawPage[];
  sentences: string[];
  program_version: string;
  date: string;
  inputs_sha256: string;
  plots: PlotOffer[];
}

/** What stood in the way, in one sentence of the server's. */
export class ApiError extends Error {
  readonly status: number;

  constructor(status: number, message: string) {
    super(message);
    this.status = status;
  }
}

/** Get a JSON answer; a failure is an `ApiError` with the server's own sentence. */
export async function get<T>(path: string, query: Record<string, string | number> = {}, signal?: AbortSignal): Promise<T> {
  const search = new URLSearchParams(Object.entries(query).map(([name, value]) => [name, String(value)]));
  const suffix = search.size ? `?${search}` : "";
  let answer: Response;
  try {
    answer = await fetch(`/api/${path}${suffix}`, signal ? { signal } : {});
  } catch (error) {
    if (error instanceof DOMException && error.name === "AbortError") throw error;
    throw new ApiError(0, "The server does not respond; it may have been stopped. Start `tribopipe browse` again.");
  }
  const body: unknown = await answer.json().catch(() => null);
  if (!answer.ok) {
    const said = body && typeof body === "object" && "error" in body ? String(body.error) : answer.statusText;
    throw new ApiError(answer.status, said);
  }
  return body as T;
}
