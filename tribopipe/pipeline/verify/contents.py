"""Whether the contents of a run or a study agree with each other, and with the other files of the archive.

Of a run: what was ingested, the steps it has been through and what these stand on, and whether what viewers show is
what its records state. Of a study: its document, its result and curves, and the runs it stands on. Between files:
studies with their runs, predictions with the k_D they were made with.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple, TypeAlias

import h5py
import numpy as np

from tribopipe.archive import nexus
from tribopipe.archive.earlier_manifests import read_earlier
from tribopipe.archive.hdf5_compression import unpacked
from tribopipe.archive.provenance import digest, raw_digest
from tribopipe.archive.runfile import (
    EARLIER,
    read_annotations,
    read_environment,
    read_findings,
    read_marks,
    read_raw,
    read_step,
    source_sha256,
    wear_curves,
)
from tribopipe.archive.step_names import PREDICTIONS, STEPS, WEAR_FITS, Step, StepName, inputs_digest, steps_among
from tribopipe.archive.studyfile import read_study
from tribopipe.documents.manifest import RunManifest
from tribopipe.documents.recipe import LawName
from tribopipe.documents.record import Record
from tribopipe.evaluation.wear.scenario import known_wear
from tribopipe.pipeline.studies import known_by
from tribopipe.pipeline.verify.file_findings import Look
from tribopipe.results.wear_fit import WearFit

_REDO = "`tribopipe process --force` writes it again"


def check_shown(entry: h5py.Group, look: Look, manifest: RunManifest, steps: Mapping[StepName, Step]) -> None:
    """Note which fields for viewers show something else than the manifest, or the result of their step."""
    _compare(entry["conditions"], look, manifest.conditions)
    _compare(entry["end_values"], look, manifest.end_values)
    for name, body in manifest.bodies.items():
        _compare(entry[name]["properties"], look, body)
    for step in steps.values():
        _compare(entry[step.name]["parameters"], look, step.result)
    for name, values in wear_curves(steps).items():
        plotted = entry["wear"][name]
        if not np.array_equal(unpacked(plotted), values, equal_nan=True):
            look.warning(
                "shown",
                "found a curve that differs from the result of the step; expected both to be identical",
                _REDO,
                plotted.name,
            )


def _compare(group: h5py.Group, look: Look, record: Record) -> None:
    """Compare the fields that are there: other versions of tribopipe may show more of a record, or less."""
    for name, value, unit in nexus.summarised(record):
        if name not in group:
            continue
        field = group[name]
        if (_said(field), field.attrs.get("units")) != (value, unit):
            message = f"found {_said(field)!r}; expected {value!r}, as in the record"
            look.warning("shown", message, _REDO, field.name)


def _said(field: h5py.Dataset) -> float | str:
    said = field.asstr()[()] if h5py.check_string_dtype(field.dtype) else field[()]
    return said.item() if isinstance(said, np.generic) else str(said)


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
    """Fingerprints of the run as ingested with each earlier run.toml."""
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
                "found content that differs from the ingested run; expected the content with the recorded SHA-256 "
                "checksum",
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
                "source",
                f"found content that differs from {came}; expected the content with the recorded SHA-256 checksum",
                part=note.name,
            )


def _checked_earlier(entry: h5py.Group, look: Look) -> Iterator[str]:
    """Yield the fingerprint of the ingested run with each earlier run.toml."""
    for one in read_earlier(entry):
        if one.source.sha256 != one.checksum:
            name = one.source.name
            message = f"found content that differs from {name}; expected the content with the recorded SHA-256 checksum"
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
                "found a result that differs from the one that the step computed; expected the result with the "
                "recorded SHA-256 checksum",
                part=part,
            )
    if not step.stands_on:
        return
    if inputs_digest(step.program_version, step.name, step.options, step.stands_on) != step.inputs_sha256:
        message = (
            "found inputs that differ from those of the step; expected the inputs with the recorded SHA-256 checksum"
        )
        look.error("inputs", message, part=part)
    for base, made_from in step.stands_on.items():
        if base in there and made_from != there[base]:
            message = f"found a step based on a different version of '{base}'; expected the version in the file"
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


@dataclass(frozen=True)
class SeenStudy:
    """What other files of the archive have to agree with."""

    stands_on: Mapping[str, str] = field(default_factory=dict)
    """SHA-256 of what was ingested of each of its runs."""
    references: tuple[str, ...] = ()
    """What predictions call it that were made with its k_D."""
    found: Mapping[LawName, str] = field(default_factory=dict)
    """SHA-256 of the k_D that it found under each law."""


def look_into_study(file: h5py.File, look: Look, study_id: str) -> SeenStudy:
    """Hold all that a study's file states about each other."""
    stored = read_study(file)
    look.named(study_id, nexus.text(file, "entry/identifier_study"), stored.study.id)
    left_out, runs = stored.result.left_out, stored.stands_on.values()
    if runs and stored.inputs_sha256 != digest(stored.program_version, stored.study, stored.options, *left_out, *runs):
        look.error(
            "inputs",
            "found inputs that differ from those of the study; expected the inputs with the recorded SHA-256 checksum",
        )
    fit = stored.study.fit
    return SeenStudy(
        stored.stands_on,
        (f"study {study_id}", *(fit if len(fit) == 1 else ())),
        {law.model: digest(*known_by(law).parts) for law in stored.result.laws},
    )


Seen: TypeAlias = Mapping[str, SeenRun | SeenStudy]
"""Verified files by the id of the run, or by "study " and the id of the study."""


def check_agreement(look: Look, mine: SeenRun | SeenStudy, seen: Seen) -> None:
    """Note where a file stands on something else than the archive holds."""
    if isinstance(mine, SeenStudy):
        for run_id, raw_sha256 in mine.stands_on.items():
            _check_member(look, run_id, raw_sha256, seen.get(run_id))
        return
    for borrowed in mine.borrowed:
        _check_borrowed(look, borrowed, set(_known(borrowed.reference, borrowed.law, seen)))


def _check_member(look: Look, run_id: str, raw_sha256: str, run: SeenRun | SeenStudy | None) -> None:
    if not isinstance(run, SeenRun):
        message = f"found a study based on run {run_id}, which cannot be read; expected run {run_id} in the archive"
        look.note("study", message, f"restore the run with `tribopipe restore {run_id}`")
    elif raw_sha256 in run.earlier:
        message = (
            f"found a study based on an earlier version of {run_id}, whose run.toml has since been amended; expected "
            "the current version"
        )
        look.warning("study", message, "run the study again")
    elif run.raw_sha256 != raw_sha256:
        message = f"found a study based on a different version of run {run_id}; expected the version in the archive"
        look.warning("study", message, "run the study again")


def _check_borrowed(look: Look, borrowed: Borrowed, known: set[str]) -> None:
    part = f"/entry/{borrowed.step}"
    if not known:
        message = (
            f"found a prediction from {borrowed.reference}, whose k_D is missing; expected this k_D in the archive"
        )
        look.note("reference", message, f"restore or process {borrowed.reference}", part)
    elif borrowed.sha256 not in known:
        message = f"found a prediction with an earlier k_D from {borrowed.reference}; expected the current k_D"
        look.warning("reference", message, "process both runs again, or run their study again", part)


def _known(reference: str, law: LawName, seen: Seen) -> Iterator[str]:
    """Return the SHA-256 of each k_D that a prediction may have been made with."""
    for name, one in seen.items():
        called = one.references if isinstance(one, SeenStudy) else (name,)
        if reference in called and law in one.found:
            yield one.found[law]
