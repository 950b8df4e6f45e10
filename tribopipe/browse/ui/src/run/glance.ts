import type { Fact, Stage } from "../api";

/** One result in large letters. */
export interface Tile {
  label: string;
  value: string;
  /** In small letters below: its interval, what it is made of. */
  more: string;
  stage: string;
}

type Said = Omit<Tile, "stage">;

const tile = (label: string, value: string, more = ""): Said => ({ label, value, more });

/** What each kind of stage tells first, in the order in which it is looked for. */
const TOLD: [stage: string, tell: (stage: Stage) => Said[]][] = [
  ["wear_fit_", coefficients],
  ["drift_correction", depth],
  ["friction_fit", friction],
  ["specific_wear", rates],
  ["drift_correction", drift],
];

/** The results of a run: k_D, end depth, friction, specific wear rate, drift. */
export function tiles(stages: Stage[]): Tile[] {
  return TOLD.flatMap(([name, tell]) =>
    stages.filter((stage) => stage.name.startsWith(name)).flatMap((stage) => placed(tell(stage), stage)),
  );
}

const placed = (said: Said[], { name }: Stage): Tile[] => said.map((one) => ({ ...one, stage: name }));

const fitsOf = (stages: Stage[]): Stage[] => stages.filter(({ name }) => name.startsWith("wear_fit_"));

/** Whether k_D was identified under any law. */
export const isFitted = (stages: Stage[]): boolean =>
  fitsOf(stages).some(({ facts }) => facts.some(({ name }) => name.startsWith("k_D")));

/** What is missing for k_D; empty where no fit states it. */
export const missing = (stages: Stage[]): string =>
  fitsOf(stages)
    .map(({ sentence }) => /: missing (.+)$/.exec(sentence)?.[1] ?? "")
    .find(Boolean) ?? "";

const valueOf = (stage: Stage, name: string): string | undefined =>
  stage.facts.find((fact) => fact.name === name)?.value;

/** The k_D of a law, of each body in a line of its own, with the interval that is told after it, before the next. */
function coefficients(stage: Stage): Said[] {
  const law = /\((.+)\)$/.exec(stage.title)?.[1] ?? "";
  const found = stage.facts.flatMap(({ name, value }, place) =>
    name.startsWith("k_D") ? [{ name, value, more: interval(stage.facts.slice(place + 1)) }] : [],
  );
  if (found.length > 1) {
    const lines = (text: (one: (typeof found)[number]) => string) =>
      found.map((one) => text(one) && `${bodyOf(one.name)}: ${text(one)}`).filter(Boolean).join("\n");
    return [tile(`k_D (${law})`, lines(({ value }) => value), lines(({ more }) => more))];
  }
  return found.map(({ name, value, more }) => tile(name.includes(law) ? name : `${name} (${law})`, value, more));
}

/** "crowned disc" of "k_D of the crowned disc (Archard's law)" */
const bodyOf = (name: string): string => name.replace(/^k_D of the /, "").replace(/ \(.*$/, "");

function interval(after: Fact[]): string {
  const next = after.find(({ name }) => /^(k_D|95 % CI)/.test(name));
  return next?.name.startsWith("95 %") ? `95 % CI: ${next.value}` : "";
}

/** Precedes the name of a body in its contribution to the wear depth. */
const CONTRIBUTION = "contribution of the ";

function depth(stage: Stage): Said[] {
  const value = valueOf(stage, "wear depth at the end");
  if (value === undefined) return [];
  const parts = stage.facts
    .filter(({ name }) => name.startsWith(CONTRIBUTION))
    .map(({ name, value: part }) => [name.slice(CONTRIBUTION.length), part].join(" "));
  return [tile("Wear depth at the end", value, parts.join(", "))];
}

function friction(stage: Stage): Said[] {
  const steady = valueOf(stage, "b, steady state");
  const mean = valueOf(stage, "mean of μ over the run");
  if (steady !== undefined) return [tile("Steady-state μ", steady, mean && `mean over the run ${mean}`)];
  return mean === undefined ? [] : [tile("Mean μ", mean)];
}

function rates(stage: Stage): Said[] {
  return stage.facts
    .filter(({ name }) => name.startsWith("wear rate of "))
    .map(({ name, value }) => {
      const body = name.slice("wear rate of ".length);
      const volume = valueOf(stage, `wear volume of ${body}`)?.split(", from ")[0];
      return tile(`Specific wear rate of ${body}`, value, volume && `wear volume ${volume}`);
    });
}

function drift(stage: Stage): Said[] {
  const rate = valueOf(stage, "drift rate");
  if (rate === undefined) return [];
  const discrepancy = valueOf(stage, "discrepancy at the end");
  return [tile("Drift rate", rate, discrepancy && `discrepancy ${discrepancy}`)];
}
