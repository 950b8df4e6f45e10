"""One run of the archive: what was ingested, the steps it has been through, and what these stand on."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

import h5py

from tribopipe.archive import nexus
from tribopipe.archive.digest import digest, raw_digest
from tribopipe.archive.earlier_manifests import read_earlier
from tribopipe.archive.runfile import (
    EARLIER,
    read_annotations,
    read_environment,
    read_findings,
    read_marks,
    read_raw,
    read_step,
    source_sha256,
)
from tribopipe.archive.steps import PREDICTIONS, STEPS, WEAR_FITS, Step, StepName, inputs_digest, steps_among
from tribopipe.documents.recipe import LawName
from tribopipe.evaluation.wear.known import known_wear
from tribopipe.pipeline.verify.look import Look
from tribopipe.pipeline.verify.shown import check_shown
from tribopipe.results.wear_fit import WearFit

_AGAIN = "process the run again"


class Borrowed(NamedTuple):
    """The k_D that a prediction was made with: from where, and which, as its SHA-256."""

    step: StepName
    law: LawName
    reference: str
    sha256: str


@dataclass
class SeenRun:
    """What other files of the archive have to agree with."""

    raw_sha256: str = ""
    earlier: tuple[str, ...] = ()
    """Of what was ingested with each run.toml that was amended since."""
    found: dict[LawName, str] = field(default_factory=dict)
    """SHA-256 of the k_D that its fit under each law found."""
    borrowed: list[Borrowed] = field(default_factory=list)


def look_into_run(file: h5py.File, look: Look, run_id: str) -> SeenRun:
    """Hold all that a run's file states about each other."""
    entry, seen, steps = file["entry"], SeenRun(), dict(_read_steps(file["entry"], look))
    with look.reading("/entry/raw"):
        seen.raw_sha256 = nexus.text(entry, "archived/raw_sha256")
        run = read_raw(file)
        look.named(run_id, nexus.text(entry, "identifier_run"), run.id)
        if raw_digest(run) != seen.raw_sha256:
            look.error(
                "raw",
                "found content that differs from what was ingested; expected that of its SHA-256",
                part="/entry/raw",
            )
        check_shown(entry, look, run.manifest, steps)
    with look.reading("/entry/source_files"):
        _check_sources(entry["source_files"], look)
    with look.reading(f"/entry/{EARLIER}"):
        seen.earlier = tuple(_checked_earlier(entry, look))
    for read in (read_marks, read_annotations, read_findings, read_environment):
        with look.reading("/entry"):
            read(entry)
    there = {"raw": seen.raw_sha256} | {name: "" for name in STEPS if name not in entry}
    there |= {name: step.result_sha256 for name, step in steps.items()}
    for step in steps.values():
        _check_step(entry, look, step, there)
    _put_aside(steps, seen)
    return seen


def _check_sources(sources: h5py.Group, look: Look) -> None:
    for note in sources.values():
        if source_sha256(note["data"]) != nexus.text(note, "checksum"):
            came = nexus.text(note, "file_name")
            look.error(
                "source", f"found bytes that differ from those of {came}; expected those of its SHA-256", part=note.name
            )


def _checked_earlier(entry: h5py.Group, look: Look) -> Iterator[str]:
    """Yield the fingerprint of the ingested run with each earlier run.toml."""
    for one in read_earlier(entry):
        if one.source.sha256 != one.checksum:
            message = f"found bytes that differ from those of {one.source.name}; expected those of its SHA-256"
            look.error("source", message, part=f"/entry/{EARLIER}")
        yield one.raw_sha256


def _read_steps(entry: h5py.Group, look: Look) -> Iterator[tuple[StepName, Step]]:
    for name in steps_among(entry):
        with look.reading(f"/entry/{name}"):
            step = read_step(entry, name)
            if step is not None:
                yield name, step


def _check_step(entry: h5py.Group, look: Look, step: Step, there: Mapping[str, str]) -> None:
    """Hold a step against the results ``there`` are: empty of steps that were not done, none of unreadable ones."""
    part = f"/entry/{step.name}"
    with look.reading(part):
        if nexus.text(entry[step.name], "fingerprints/result_sha256") != there[step.name]:
            look.error(
                "result",
                "found a result that differs from that of the step; expected the one of its SHA-256",
                part=part,
            )
    if not step.stands_on:
        return
    if inputs_digest(step.program_version, step.name, step.options, step.stands_on) != step.inputs_sha256:
        message = "found inputs that differ from those of the step; expected those of its SHA-256"
        look.error("inputs", message, part=part)
    for base, made_from in step.stands_on.items():
        if base in there and made_from != there[base]:
            message = f"found that it is based on a different {base} from the one in the file; expected the same one"
            look.warning("inputs", message, _AGAIN, part)


def _put_aside(steps: Mapping[StepName, Step], seen: SeenRun) -> None:
    for name, step in steps.items():
        fit = step.result
        known = known_wear(fit) if isinstance(fit, WearFit) else None
        if (law := WEAR_FITS.law_of(name)) is not None and known is not None:
            seen.found[law] = digest(*known.parts)
        told = step.stands_on.get("wear_coefficient")
        if (law := PREDICTIONS.law_of(name)) is not None and told is not None:
            seen.borrowed.append(Borrowed(name, law, str(step.options.get("reference")), told))
