"""The whole line as plain calls: each step reads what it stands on from the archive and appends its result.

A step is skipped where its version, its options and all that it stands on are unchanged; ``force`` redoes it.
"""

from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Literal

from tribopipe.archive.results import archived_fit
from tribopipe.archive.steps import WEAR_FITS
from tribopipe.archive.store import Archive
from tribopipe.archived_steps import (
    PlannedStep,
    clean_up,
    drift_correction,
    friction_fit,
    known_coefficient,
    local_wear,
    prediction,
    specific_wear_rates,
    wear_fit,
)
from tribopipe.checks.registry import check_run, refuse_errors
from tribopipe.errors import ManifestError, TribopipeError
from tribopipe.faults import in_a_sentence
from tribopipe.files import found_below, natural_order
from tribopipe.ingest.harmonise import read_run
from tribopipe.records.base import Record
from tribopipe.records.disc_results import TwinDiscFit
from tribopipe.records.finding import Finding
from tribopipe.records.manifest import MANIFEST_NAME, manifest_path
from tribopipe.records.quantity import Quantity
from tribopipe.records.recipe import LawName, Recipe
from tribopipe.records.results import WearFit
from tribopipe.study.bodies import bodies, severity
from tribopipe.wear.local import LocalOptions
from tribopipe.wear.predict import KnownPin
from tribopipe.wear.twin_disc.predict import KnownDiscs

Stage = Literal[
    "ingest",
    "clean_up",
    "drift_correction",
    "friction_fit",
    "specific_wear",
    "wear_fit",
    "prediction",
    "local_wear",
    "study",
    "figures",
]
Status = Literal["done", "unchanged", "failed"]


@dataclass(frozen=True)
class Outcome:
    """What became of one step of one run."""

    run_id: str
    """Id of the run, or of the study; its path where it could not be read."""
    stage: Stage
    status: Status
    result: Record | None = None
    findings: tuple[Finding, ...] = ()
    error: TribopipeError | None = None

    @classmethod
    def failed(cls, run_id: str, stage: Stage, error: Exception) -> "Outcome":
        """Return the outcome of a step that failed, for whatever reason."""
        return cls(run_id, stage, "failed", error=in_a_sentence(error, run_id))

    def as_json(self) -> dict[str, Any]:
        """Return the outcome as JSON types, without its result."""
        return {
            "id": self.run_id,
            "stage": self.stage,
            "status": self.status,
            "findings": [finding.model_dump(mode="json") for finding in self.findings],
            "error": None if self.error is None else str(self.error),
        }


def attempted(run_id: str, stage: Stage, step: Callable[[], Outcome]) -> Outcome:
    """Take a step of a batch; where it fails, for whatever reason, that is its outcome, and the batch can go on."""
    try:
        return step()
    except Exception as error:  # noqa: BLE001 - a fault in one run is no reason to leave the others
        return Outcome.failed(run_id, stage, error)


def find_runs(path: Path) -> list[Path]:
    """Return the run folders at or below a path. Raises ``ManifestError`` where there is none."""
    if manifest_path(path).is_file() or not path.is_dir():
        return [path]
    manifests = found_below(path, MANIFEST_NAME)
    found = sorted((manifest.parent for manifest in manifests), key=lambda run: natural_order(str(run)))
    if not found:
        raise ManifestError(
            f"{path}: found no {MANIFEST_NAME} in it or below; expected a run folder; write one beside the "
            "instrument's files"
        )
    return found


def ingest(path: Path, archive: Archive, *, force: bool = False) -> Outcome:
    """Read, check and archive one run folder.

    Raises ``TribopipeError`` where the run cannot be read, has errors, or its id is taken by other content.
    """
    run = read_run(path)
    findings = check_run(run)
    refuse_errors(run, findings)
    status = archive.add(run, findings, force=force)
    return Outcome(run.id, "ingest", "unchanged" if status == "unchanged" else "done", findings=tuple(findings))


def clean_archived(archive: Archive, run_id: str, recipe: Recipe, *, force: bool = False) -> Outcome:
    """Clean up the signals of an archived run, and archive those that came out changed; the raw ones stay."""
    return _advance(archive, clean_up(archive, run_id, recipe), "clean_up", force=force)


def correct_archived_drift(archive: Archive, run_id: str, recipe: Recipe, *, force: bool = False) -> Outcome:
    """Correct the drift of an archived run, cleaned up first where it is not, and archive the corrected curve."""
    clean_archived(archive, run_id, recipe)
    return _advance(archive, drift_correction(archive, run_id, recipe), "drift_correction", force=force)


def fit_archived_friction(archive: Archive, run_id: str, recipe: Recipe, *, force: bool = False) -> Outcome:
    """Fit the friction of an archived run, cleaned up first where it is not, and archive the fitted curve."""
    clean_archived(archive, run_id, recipe)
    return _advance(archive, friction_fit(archive, run_id, recipe), "friction_fit", force=force)


def evaluate_archived_wear(archive: Archive, run_id: str, recipe: Recipe, *, force: bool = False) -> Outcome:
    """Evaluate the specific wear rate of each body of an archived run by its end values, and archive it."""
    clean_archived(archive, run_id, recipe)
    return _advance(archive, specific_wear_rates(archive, run_id, recipe), "specific_wear", force=force)


def fit_archived_wear(archive: Archive, run_id: str, law: LawName, recipe: Recipe, *, force: bool = False) -> Outcome:
    """Identify k_D of an archived run under a wear law; steps it stands on are done first where they are not."""
    correct_archived_drift(archive, run_id, recipe)
    fit_archived_friction(archive, run_id, recipe)
    return _advance(archive, wear_fit(archive, run_id, recipe, law), "wear_fit", force=force)


def predict_archived(
    archive: Archive, run_id: str, reference: str, law: LawName, recipe: Recipe, *, force: bool = False
) -> Outcome:
    """Predict a run's wear from the k_D of another run, over the run's own distance, and archive the prediction."""
    fit = archived_fit(archive, reference, law)
    known = known_coefficient(fit)
    if known is None:
        raise TribopipeError(
            f"{reference}: found no wear coefficient to predict from; it lacks {' and '.join(fit.lacks)}"
        )
    return predict_with(archive, run_id, reference, law, known, recipe, force=force)


def predict_with(
    archive: Archive,
    run_id: str,
    reference: str,
    law: LawName,
    known: KnownPin | KnownDiscs,
    recipe: Recipe,
    *,
    force: bool = False,
) -> Outcome:
    """Predict a run's wear from the k_D that ``reference`` found, over the run's own distance, and archive it."""
    _clean_first(archive, run_id, recipe)
    return _advance(archive, prediction(archive, run_id, recipe, law, reference, known), "prediction", force=force)


def wear_archived_locally(
    archive: Archive,
    run_id: str,
    law: LawName,
    recipe: Recipe,
    how: LocalOptions,
    *,
    coefficients: Sequence[Quantity] = (),
    at: Sequence[float] = (),
    force: bool = False,
) -> Outcome:
    """Wear a run locally to places ``at``, m or rotations, or over its own course, and archive it with its fields.

    k_D is the one its fit under the law found, unless ``coefficients`` are given: of the pin, or of the curved and the
    flat disc as Archard's law has them. Raises ``FitError`` where neither is there.
    """
    _clean_first(archive, run_id, recipe)
    step = local_wear(archive, run_id, recipe, law, how, coefficients=coefficients, at=at)
    return _advance(archive, step, "local_wear", force=force)


def _clean_first(archive: Archive, run_id: str, recipe: Recipe) -> None:
    """Clean up a run that was not; one that was stays as it is."""
    if "clean_up" not in archive.step_names(run_id):
        clean_archived(archive, run_id, recipe)


def _advance(archive: Archive, step: PlannedStep, stage: Stage, *, force: bool) -> Outcome:
    """Take a step and archive it, unless it is there already, made from the same."""
    there = archive.fingerprints(step.run_id, step.name)
    if there is not None and there.inputs == step.inputs_sha256 and not force:
        return Outcome(step.run_id, stage, "unchanged", archive.result(step.run_id, step.name, Record))
    taken = step.take()
    archive.put_step(step.run_id, taken)
    return Outcome(step.run_id, stage, "done", taken.result)


def process(
    paths: Sequence[Path],
    archive: Archive,
    recipe: Recipe | None = None,
    *,
    force: bool = False,
    studied: Collection[str] = (),
) -> Iterator[Outcome]:
    """Take run folders through the whole line; yield what became of each step as it is done.

    Runs of the same bodies in the same medium are predicted from the one under the lightest load, as the paper does,
    but for those that are ``studied``: a study says from which runs they are predicted. A run that fails does not stop
    the others.
    """
    recipe = recipe or Recipe()
    done: list[str] = []
    for path in paths:
        outcomes = []
        for outcome in _process_one(path, archive, recipe, force=force):
            outcomes.append(outcome)
            yield outcome
        if all(outcome.status != "failed" for outcome in outcomes):
            done.append(outcomes[0].run_id)
    for law in recipe.wear.models:
        yield from predict_from_lightest(archive, [i for i in done if i not in studied], law, recipe, force=force)


def _process_one(path: Path, archive: Archive, recipe: Recipe, *, force: bool) -> Iterator[Outcome]:
    ingested = attempted(str(path), "ingest", partial(ingest, path, archive, force=force))
    yield ingested
    if ingested.error is not None:
        return
    run_id = ingested.run_id
    stages: list[tuple[Stage, Callable[[], Outcome]]] = [
        ("clean_up", lambda: clean_archived(archive, run_id, recipe, force=force)),
        ("drift_correction", lambda: correct_archived_drift(archive, run_id, recipe, force=force)),
        ("friction_fit", lambda: fit_archived_friction(archive, run_id, recipe, force=force)),
        ("specific_wear", lambda: evaluate_archived_wear(archive, run_id, recipe, force=force)),
    ]
    stages += [
        ("wear_fit", partial(fit_archived_wear, archive, run_id, law, recipe, force=force))
        for law in recipe.wear.models
    ]
    for stage, advance in stages:
        yield attempted(run_id, stage, advance)


def predict_from_lightest(
    archive: Archive, run_ids: Sequence[str], law: LawName, recipe: Recipe, *, force: bool = False
) -> Iterator[Outcome]:
    """Predict each run from the comparable run under the lightest load; nothing for a run that is itself that one.

    Of twin-disc runs under the same load it is one with the least slip.

    A run marked bad is never the one predicted from.
    """
    references: dict[tuple[object, ...], tuple[tuple[float, float], str]] = {}
    for other in archive.ids():
        try:
            fit = archive.result(other, WEAR_FITS[law], Record)
            fitted = isinstance(fit, WearFit | TwinDiscFit) and fit.outcome == "fitted"
            if fitted and archive.bad(other) is None:
                manifest = archive.manifest(other)
                candidate = (severity(manifest), other)
                best = references.get(bodies(manifest), candidate)
                references[bodies(manifest)] = candidate if candidate[0] < best[0] else best
        except TribopipeError as error:
            yield Outcome(other, "prediction", "failed", error=error)
    for run_id in run_ids:
        try:
            _, reference = references.get(bodies(archive.manifest(run_id)), (None, run_id))
            if reference != run_id:
                yield predict_archived(archive, run_id, reference, law, recipe, force=force)
        except Exception as error:  # noqa: BLE001 - as in ``attempted``
            yield Outcome.failed(run_id, "prediction", error)
