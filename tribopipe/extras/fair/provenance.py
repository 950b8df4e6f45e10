"""Provenance of the data in a crate: people, institutions, license, grants, and evaluations as actions."""

from collections.abc import Iterator, Mapping, Sequence
from datetime import timedelta
from urllib.parse import quote

from tribopipe.archive.earlier_manifests import EarlierManifest
from tribopipe.archive.outline import RunOutline
from tribopipe.archive.step_names import STEPS, StepName, StepOutline, step_in_words
from tribopipe.documents.dataset import Dataset, Funding, Organisation, Person, Publication
from tribopipe.extras.fair.files import Part, earlier_path
from tribopipe.extras.fair.graph import Graph, Ref, local
from tribopipe.extras.fair.vocabulary import term

_NOT_SAID = "No license is specified: ask the creators before you use the data."


def person(graph: Graph, one: Person) -> Ref:
    """Describe a creator; an ORCID is their identifier."""
    identifier = f"https://orcid.org/{one.orcid}" if one.orcid else local("person", one.name)
    affiliation = organisation(graph, one.affiliation) if one.affiliation else None
    return graph.thing(
        identifier,
        "Person",
        name=one.name,
        givenName=one.given_name,
        familyName=one.family_name,
        affiliation=affiliation,
        identifier=identifier if one.orcid else None,
    )


def author(graph: Graph, dataset: Dataset) -> Ref | None:
    """Describe the first creator, for what takes one author alone."""
    return person(graph, dataset.creators[0]) if dataset.creators else None


def operator(graph: Graph, dataset: Dataset, name: str | None) -> Ref | None:
    """Describe who ran a test: a creator, or else somebody of whom run.toml states the name alone."""
    if not name:
        return None
    known = dataset.operated_by(name)
    return person(graph, known) if known else graph.thing(local("person", name), "Person", name=name)


def organisation(graph: Graph, one: Organisation) -> Ref:
    """Describe an institution; a ROR is its identifier."""
    return graph.thing(one.ror or local("organisation", one.name), "Organization", name=one.name, url=one.ror)


def licence(graph: Graph, dataset: Dataset) -> Ref:
    """Describe the license, or report that there is none."""
    if dataset.licence is None:
        return graph.thing("#no-licence", "CreativeWork", name="No license specified", description=_NOT_SAID)
    iri = f"https://spdx.org/licenses/{dataset.licence}"
    description = f"SPDX license {dataset.licence}."
    return graph.thing(
        iri, "CreativeWork", name=dataset.licence, description=description, identifier=dataset.licence, url=iri
    )


def grant(graph: Graph, one: Funding) -> Ref:
    """Describe a grant."""
    funder = organisation(graph, one.funder)
    name = one.title or one.award or f"Grant of {one.funder.name}"
    return graph.thing(local("grant", one.funder.name, name), "Grant", name=name, identifier=one.award, funder=funder)


def publication(graph: Graph, one: Publication) -> Ref:
    """Describe a paper that the data belong to."""
    iri = f"https://doi.org/{quote(one.doi, safe='/;()')}"
    return graph.thing(iri, "ScholarlyArticle", name=one.citation or one.doi, identifier=iri, url=iri)


PROFILE = "https://w3id.org/ro/wfrun/process/0.5"
"""Process Run Crate, whose rules the actions follow."""
Placed = Mapping[str, tuple[Part, Ref]]
"""Files of a run by their path in its folder."""


def software(graph: Graph, version: str) -> Ref:
    """Describe the program that computed something."""
    return graph.thing(
        local("software", "tribopipe", version),
        "SoftwareApplication",
        name="tribopipe",
        softwareVersion=version,
        description="Archiving and evaluation of tribometer tests, from run folders to wear laws.",
    )


def test_action(
    graph: Graph, run: RunOutline, who: Ref | None, instrument: Ref, bodies: Sequence[Ref], made: Placed
) -> Ref:
    """Describe the test: who ran it, when, on what, and the files that the instrument wrote."""
    manifest = run.manifest
    start, lasted = manifest.started, run.ends.get("time")
    end = None if start is None or lasted is None else start + timedelta(seconds=lasted)
    written = [ref for path, (_, ref) in made.items() if path.startswith("source/") and path != "source/run.toml"]
    return graph.thing(
        local(manifest.id, "test"),
        "Action",
        name=f"Test {manifest.id}",
        description=manifest.title or "A test on a tribometer.",
        additionalType=term("test"),
        agent=who,
        instrument=instrument,
        object=list(bodies),
        result=written,
        startTime=None if start is None else start.isoformat(),
        endTime=None if end is None else end.isoformat(),
    )


def archive_action(graph: Graph, run: RunOutline, archived: Ref, made: Placed) -> Ref:
    """Describe how the run was archived: from its folder to the HDF5 file and the signals in SI."""
    return graph.thing(
        local(run.manifest.id, "ingest"),
        "CreateAction",
        name=f"Archive {run.manifest.id}",
        description="Read, check and archive a run folder; signals in SI units.",
        additionalType=term("evaluation"),
        instrument=software(graph, run.environment.get("tribopipe", "unknown")),
        object=[ref for path, (_, ref) in made.items() if path.startswith("source/")],
        result=[archived, *(made[path][1] for path in ("run.json", "tables/raw.csv") if path in made)],
    )


def amendments(graph: Graph, run_id: str, earlier: Sequence[EarlierManifest], made: Placed) -> Iterator[Ref]:
    """Describe each time that another run.toml took the place of one: what it changed, and when."""
    after = [*(earlier_path(one) for one in earlier[1:]), "source/run.toml"]
    for number, (one, next_path) in enumerate(zip(earlier, after, strict=False), start=1):
        yield graph.thing(
            local(run_id, "amend", str(number)),
            "Action",
            name=f"Amend {run_id}",
            description=one.changes,
            object=made[earlier_path(one)][1],
            result=made[next_path][1],
            endTime=one.date,
        )


def step_action(graph: Graph, run: RunOutline, name: StepName, step: StepOutline, made: Placed) -> Ref:
    """Describe a step: what it stood on, what it found, when, and by which version."""
    before = [f"results/{base}.json" for base in STEPS[name].stands_on]
    return graph.thing(
        local(run.manifest.id, name),
        "CreateAction",
        name=f"{step_in_words(name).capitalize()} of {run.manifest.id}",
        description=f"tribopipe {step.program_version}; options and libraries are in history.json.",
        additionalType=term("evaluation"),
        instrument=software(graph, step.program_version),
        object=[made[path][1] for path in ("tables/raw.csv", *before) if path in made],
        result=[ref for part, ref in made.values() if part.made_by == name],
        endTime=step.date,
    )


def study_action(
    graph: Graph, study_id: str, version: str, date: str, runs: Sequence[Ref], result: Sequence[Ref]
) -> Ref:
    """Describe the evaluation of a study from its runs."""
    return graph.thing(
        local("study", study_id),
        "CreateAction",
        name=f"Study {study_id}",
        description=f"tribopipe {version}; options and libraries are in history.json.",
        additionalType=term("evaluation"),
        instrument=software(graph, version),
        object=list(runs),
        result=list(result),
        endTime=date,
    )
