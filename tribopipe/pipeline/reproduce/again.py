"""What was done with a run, planned again as the archive gives it."""

from collections.abc import Iterator, Sequence
from contextlib import suppress
from functools import partial
from pathlib import Path
from shutil import rmtree
from tempfile import TemporaryDirectory

from tribopipe.archive.steps import LOCAL_WEAR, PREDICTIONS, WEAR_FITS, Step, inputs_digest
from tribopipe.archive.store import Archive
from tribopipe.base.errors import ArchiveError, TribopipeError
from tribopipe.base.files import leads_out
from tribopipe.base.interrupts import undone_by
from tribopipe.documents.recipe import LawName
from tribopipe.evaluation.wear.known import KnownWear, known_wear
from tribopipe.pipeline.archived_results import archived_fit
from tribopipe.pipeline.step_definitions import (
    PLANS,
    PlannedStep,
    local_wear_as_told,
    prediction,
    recipe_of,
    wear_fit,
)
from tribopipe.pipeline.studies import known_by, study_reference
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
            f"{run_id}: found a source file called {source.name!r}; expected one inside the run folder; restore the "
            "run from a copy"
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
            f"{run_id}: found options of {step.name} that tribopipe cannot read; expected those it writes; run the "
            "step again"
        ) from None
    raise ArchiveError(f"{run_id}: found {step.name} made from {_another(step, others)}; run the step again")


def _another(step: Step, others: Sequence[PlannedStep]) -> str:
    """Report what a step was made from that the archive does not hold any more."""
    if not others:
        return f"a wear coefficient of {step.options.get('reference')}; expected it to be in the archive"
    changed = [name for name, sha256 in step.stands_on.items() if others[0].stands_on.get(name) != sha256]
    another = f"a different {' and '.join(changed)}" if changed else "something else"
    return f"{another} than the archive contains now; expected the same"


def _plans(archive: Archive, run_id: str, step: Step) -> Iterator[PlannedStep]:
    """Yield what the step may have been: one plan, or one for each k_D that it may have been predicted from."""
    recipe = recipe_of(step.options)
    if (law := WEAR_FITS.law_of(step.name)) is not None:
        yield wear_fit(archive, run_id, recipe, law)
    elif (law := LOCAL_WEAR.law_of(step.name)) is not None:
        yield local_wear_as_told(archive, run_id, law, step.options)
    elif (law := PREDICTIONS.law_of(step.name)) is not None:
        reference = str(step.options["reference"])
        for known in _known_under(archive, reference, law):
            yield prediction(archive, run_id, recipe, law, reference, known)
    else:
        yield PLANS[step.name](archive, run_id, recipe)


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
