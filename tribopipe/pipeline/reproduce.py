"""An archived run or study computed again from what it was made from, and compared number by number.

``reproduce(archive, run_id)`` reads a run again from its archived source files and takes each of its steps again, with
the options archived with it, from what the archive holds; ``reproduce_study(archive, study_id)`` evaluates a study
again. Both return a ``Reproduction``: a ``Redone`` for "raw" and each step in order, or for "study". Nothing is
written into the archive. Both raise ``ArchiveError`` where the run or study is not there or cannot be read; what goes
wrong with one step is given in its ``Redone``.
"""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict
from functools import partial
from io import BytesIO
from pathlib import Path
from shutil import rmtree
from tempfile import TemporaryDirectory
from typing import Any

import h5py

from tribopipe.archive.step_names import LOCAL_WEAR, PREDICTIONS, WEAR_FITS, Step, inputs_digest, step_in_words
from tribopipe.archive.store import Archive
from tribopipe.archive.studyfile import StoredStudy, read_study, write_study
from tribopipe.base.arrays import Column
from tribopipe.base.errors import ArchiveError, TribopipeError
from tribopipe.base.files import leads_out
from tribopipe.base.process_lifecycle import undone_by
from tribopipe.documents.recipe import LawName
from tribopipe.evaluation.wear.scenario import KnownWear, known_wear
from tribopipe.pipeline.archived_results import archived_fit
from tribopipe.pipeline.recomputed_values import Redone, Reproduction, redo
from tribopipe.pipeline.step_definitions import PlannedStep, local_wear_as_told, planned, prediction, recipe_of
from tribopipe.pipeline.studies import PlannedStudy, known_by, planned_study, study_reference
from tribopipe.readers.harmonize import read_run
from tribopipe.results.run import RawRun, SourceFile


def read_again(run: RawRun) -> RawRun:
    """Read a run from the bytes of its source files. Raises ``TribopipeError`` where that cannot be done."""
    written = TemporaryDirectory(prefix="tribopipe-")
    with written as name, undone_by(partial(rmtree, name, ignore_errors=True)):
        for source in run.sources:
            _write(source, Path(name), run.id)
        try:
            return read_run(Path(name) / run.sources[0].name)
        except TribopipeError as error:
            raise type(error)(str(error).replace(name, run.id)) from None


def _write(source: SourceFile, folder: Path, run_id: str) -> None:
    path = folder / source.name
    if leads_out(path, folder):
        raise ArchiveError(
            f"{run_id}: found a source file called {source.name!r}; expected a file inside the run folder; restore the "
            "run from a backup"
        )
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("wb") as file:
        file.writelines(source.pieces())


def planned_again(archive: Archive, run_id: str, step: Step) -> PlannedStep:
    """Plan an archived step again, by its own options.

    Raises ``TribopipeError`` where what it was made from is gone, or is not the same any more.
    """
    others: list[PlannedStep] = []
    try:
        for planned in _plans(archive, run_id, step):
            inputs = inputs_digest(step.program_version, step.name, step.options, planned.stands_on)
            if inputs == step.inputs_sha256:
                return planned
            others.append(planned)
    except (KeyError, TypeError, ValueError):
        raise ArchiveError(
            f"{run_id}: found options of {step.name} that tribopipe cannot read; expected options written by "
            "tribopipe; run the step again"
        ) from None
    raise ArchiveError(
        f"{run_id}: found {step_in_words(step.name)} computed from {_another(step, others)}; run "
        f"`tribopipe process {run_id}`"
    )


def _another(step: Step, others: Sequence[PlannedStep]) -> str:
    """Report what a step was made from that the archive does not hold any more."""
    if not others:
        return f"a wear coefficient of {step.options.get('reference')}; expected this coefficient in the archive"
    changed = [name for name, sha256 in step.stands_on.items() if others[0].stands_on.get(name) != sha256]
    another = " and ".join(map(step_in_words, changed)) if changed else "inputs"
    return f"{another} that the archive no longer contains; expected them in the archive"


def _plans(archive: Archive, run_id: str, step: Step) -> Iterator[PlannedStep]:
    """Yield what the step may have been: one plan, or one for each k_D that it may have been predicted from."""
    recipe = recipe_of(step.options)
    if (law := LOCAL_WEAR.law_of(step.name)) is not None:
        yield local_wear_as_told(archive, run_id, law, step.options)
    elif (law := PREDICTIONS.law_of(step.name)) is not None:
        reference = str(step.options["reference"])
        for known in _known_under(archive, reference, law):
            yield prediction(archive, run_id, recipe, law, reference, known)
    else:
        yield planned(archive, run_id, step.name, recipe)


def _known_under(archive: Archive, reference: str, law: LawName) -> Iterator[KnownWear]:
    """Yield k_D under a law from the run of that name, and from each study that a prediction refers to by it."""
    if reference in archive.ids() and WEAR_FITS[law] in archive.step_names(reference):
        known = known_wear(archived_fit(archive, reference, law))
        if known is not None:
            yield known
    for study_id in archive.study_ids():
        with suppress(ArchiveError):  # of a study that cannot be read, which may be another one
            stored = archive.study_outline(study_id)
            if study_reference(stored.study) == reference:
                yield from (known_by(found) for found in stored.result.laws if found.model == law)


def reproduce(archive: Archive, run_id: str) -> Reproduction:
    """Read a run again and take its steps again; each stands on what the archive holds of those before it.

    Raises ``ArchiveError`` where there is no such run, or its file cannot be read.
    """
    steps = archive.steps(run_id).values()
    return Reproduction(run_id, "run", (_raw(archive, run_id), *(_step(archive, run_id, step) for step in steps)))


def _raw(archive: Archive, run_id: str) -> Redone:
    run = archive.raw(run_id)
    return redo("raw", _run_content(run), lambda: _run_content(read_again(run)), archive.environment(run_id))


def _run_content(run: RawRun) -> Mapping[str, Any]:
    return {
        "manifest": run.manifest,
        "columns": run.columns,
        "origins": run.origins,
        "extra_columns": {name: vars(extra) for name, extra in run.extras.items()},
        "headers": run.headers,
        "profiles": {name: vars(profile) for name, profile in run.profiles.items()},
    }


def _step(archive: Archive, run_id: str, step: Step) -> Redone:
    def compute() -> Mapping[str, Any]:
        return _step_content(planned_again(archive, run_id, step).take())

    return redo(step.name, _step_content(step), compute, step.environment or {"tribopipe": step.program_version})


def _step_content(step: Step) -> Mapping[str, Any]:
    return {
        "result": step.result,
        "curves": _with_units(step.curves),
        "tables": {name: _with_units({**table.axes, **table.arrays}) for name, table in step.tables.items()},
    }


def _with_units(arrays: Mapping[str, tuple[Column, str]]) -> Mapping[str, Any]:
    return {name: {"values": values, "unit": unit} for name, (values, unit) in arrays.items()}


def reproduce_study(archive: Archive, study_id: str) -> Reproduction:
    """Evaluate a study again, by its own options, on the runs as they were ingested.

    Raises ``ArchiveError`` where there is no such study, or its file cannot be read.
    """
    stored = archive.study(study_id)

    def compute() -> Mapping[str, Any]:
        return _study_content(_as_archived(_planned_again(archive, stored).take()))

    versions = stored.environment or {"tribopipe": stored.program_version}
    return Reproduction(study_id, "study", (redo("study", _study_content(stored), compute, versions),))


def _planned_again(archive: Archive, stored: StoredStudy) -> PlannedStudy:
    """Plan a study again. Raises ``TribopipeError`` where its runs are gone, or are not the same any more."""
    planned = planned_study(archive, stored.study, recipe_of(stored.options))
    if tuple(planned.left_out) != stored.result.left_out:
        raise ArchiveError(
            f"study {stored.study.id}: found that the runs marked bad have changed since its evaluation; expected "
            "the same runs; run the study again"
        )
    changed = [run_id for run_id, sha256 in stored.stands_on.items() if planned.stands_on.get(run_id) != sha256]
    if changed:
        raise ArchiveError(
            f"study {stored.study.id}: found that {', '.join(changed)} changed after the study was evaluated; expected "
            "the same content; run the study again"
        )
    return planned


def _as_archived(study: StoredStudy) -> StoredStudy:
    """Return a study as it is read back: its curves are written in µm and mm³, which rounds them."""
    with h5py.File(BytesIO(), "w", track_order=True) as file:
        write_study(file, study)
        return read_study(file)


def _study_content(study: StoredStudy) -> Mapping[str, Any]:
    return {"result": study.result, "curves": [asdict(curve) for curve in study.curves]}
