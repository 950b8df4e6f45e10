import { runHref, studyHref } from "../shell/router";

/** The page that a file of the archive belongs to. */
export interface Owner {
  href: string;
  label: string;
}

/** Whose file it is: "ID.h5" is a run's, "studies/ID.h5" a study's. */
export function ownerOf(file: string): Owner {
  const name = file.replace(/\.h5$/, "");
  if (!name.startsWith("studies/")) return { href: runHref(name), label: `Run ${name}` };
  const id = name.slice("studies/".length);
  return { href: studyHref(id), label: `Study ${id}` };
}
