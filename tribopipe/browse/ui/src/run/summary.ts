import type { Run } from "../api";

/** What was tested, in the few words that tell a run from others: tribometer, bodies, load, medium. */
export function summary(run: Run): string[] {
  const conditions = run.facts.find(({ title }) => title === "Conditions")?.facts ?? [];
  const said = (name: string) => conditions.find((fact) => fact.name === name)?.value;
  const parts = [run.tribometer, bodies(run), said("normal load"), said("medium")];
  return parts.filter((part): part is string => Boolean(part));
}

/** "Si3N4 pin on steel disc". */
function bodies(run: Run): string {
  const named = run.facts.flatMap(({ title, facts }) =>
    facts.filter(({ name }) => name === "material").map(({ value }) => `${value} ${title.toLowerCase()}`),
  );
  return named.join(" on ");
}
