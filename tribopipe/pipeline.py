"""The whole line as plain calls: each step reads what it stands on from the archive and appends its result.

A step is skipped where its version, its options and all that it stands on are unchanged; ``force`` redoes it.
"""

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np

from tribopipe.archive.digest import digest
from tribopipe.archive.local_wear import local_wear_tables
from tribopipe.archive.steps import LOCAL_WEAR, PREDICTIONS, STEPS, WEAR_FITS, Step, StepName, Table
from tribopipe.archive.store import Archive
from tribopipe.checks.registry import check_run, refuse_errors
from tribopipe.clean_up.cleaning import clean_run
from tribopipe.drift import correct_drift
from tribopipe.end_values.specific_wear import specific_wear
from tribopipe.errors import FitError, ManifestError, TribopipeError
from tribopipe.files import natural_order
from tribopipe.friction import fit_friction
from tribopipe.ingest.harmonise import read_run
from tribopipe.records.base import Record
from tribopipe.records.disc_results import TwinDiscFit
from tribopipe.records.finding import Finding
from tribopipe.records.local_wear import LocalWearResult
from tribopipe.records.manifest import MANIFEST_NAME, TwinDisc, manifest_path
from tribopipe.records.quantity import Quantity
from tribopipe.records.recipe import LawName, Recipe
from tribopipe.records.results import DriftCorrection, FrictionFit, WearFit
from tribopipe.records.signals import SIGNALS
from tribopipe.run import Column, CorrectedRun
from tribopipe.study.bodies import bodies, severity
from tribopipe.version import VERSION
from tribopipe.wear.curves import LawCurve, fitted_curve, predicted_curve, run_scenario
from tribopipe.wear.friction_path import fitted_path, run_path
from tribopipe.wear.identify import fit_wear
from tribopipe.wear.local import LocalOptions, archards_discs, default_places, local_scenario, wear_locally
from tribopipe.wear.predict import KnownPin, known_pin, predict_wear
from tribopipe.wear.twin_disc.curves import OUTCOMES, DiscCurves, disc_scenario, fitted_discs, predicted_discs
from tribopipe.wear.twin_disc.identify import fit_discs
from tribopipe.wear.twin_disc.predict import KnownDiscs, known_discs, predict_discs

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
]
Status = Literal["done", "unchanged", "failed"]
Curves = Mapping[str, tuple[Column, str]]
Found = tuple[Record, Curves] | tuple[Record, Curves, Mapping[str, Table]]
"""Result of a step, its curves over the samples of the run, and its tables over other axes where it has some."""
_APART = 0.01
"""How far off the GIWM may be before its k_D is called another than that of local wear."""


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

    def as_json(self) -> dict[str, Any]:
        """Return the outcome as JSON types, without its result."""
        return {
            "id": self.run_id,
            "stage": self.stage,
            "status": self.status,
            "findings": [_told(finding) for finding in self.findings],
            "error": None if self.error is None else str(self.error),
        }


class _Advance(NamedTuple):
    """A step to be taken: what it is told, how it is done, and what it stands on beside the steps before it."""

    name: StepName
    options: Mapping[str, Any]
    compute: Callable[[], Found]
    inputs: Sequence[str] = ()


def find_runs(path: Path) -> list[Path]:
    """Return the run folders at or below a path. Raises ``ManifestError`` where there is none."""
    if manifest_path(path).is_file() or not path.is_dir():
        return [path]
    found = sorted((manifest.parent for manifest in path.rglob(MANIFEST_NAME)), key=lambda run: natural_order(str(run)))
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

    def compute() -> tuple[Record, Curves]:
        found = clean_run(archive.raw(run_id), recipe)
        return found.record, {name: (values, SIGNALS[name].unit) for name, values in found.columns.items()}

    options = {"clean_up": [_told(step) for step in recipe.clean_up]}
    return _advance(archive, run_id, _Advance("clean_up", options, compute), "clean_up", force=force)


def correct_archived_drift(archive: Archive, run_id: str, recipe: Recipe, *, force: bool = False) -> Outcome:
    """Correct the drift of an archived run, cleaned up first where it is not, and archive the corrected curve."""
    clean_archived(archive, run_id, recipe)

    def compute() -> tuple[Record, Curves]:
        corrected = correct_drift(archive.cleaned(run_id), recipe)
        found = {"wear_depth": corrected.wear_depth, "pin_wear_depth": corrected.pin_wear_depth}
        return corrected.correction, {name: (curve, "m") for name, curve in found.items() if curve is not None}

    options = {"drift": _told(recipe.drift), "uncertainty": _told(recipe.uncertainty)}
    options |= _convention(archive, run_id, recipe)
    return _advance(archive, run_id, _Advance("drift_correction", options, compute), "drift_correction", force=force)


def fit_archived_friction(archive: Archive, run_id: str, recipe: Recipe, *, force: bool = False) -> Outcome:
    """Fit the friction of an archived run, cleaned up first where it is not, and archive the fitted curve."""
    clean_archived(archive, run_id, recipe)

    def compute() -> tuple[Record, Curves]:
        run = archive.cleaned(run_id)
        fit = fit_friction(run, recipe.friction)
        path = fitted_path(fit)
        return fit, {} if path is None else {"friction_coefficient": (path.coefficient(run.sliding_distance), "1")}

    step = _Advance("friction_fit", {"friction": _told(recipe.friction)}, compute)
    return _advance(archive, run_id, step, "friction_fit", force=force)


def evaluate_archived_wear(archive: Archive, run_id: str, recipe: Recipe, *, force: bool = False) -> Outcome:
    """Evaluate the specific wear rate of each body of an archived run by its end values, and archive it."""
    clean_archived(archive, run_id, recipe)

    def compute() -> tuple[Record, Curves]:
        return specific_wear(archive.cleaned(run_id), recipe), {}

    step = _Advance("specific_wear", {"uncertainty": _told(recipe.uncertainty)}, compute)
    return _advance(archive, run_id, step, "specific_wear", force=force)


def fit_archived_wear(archive: Archive, run_id: str, law: LawName, recipe: Recipe, *, force: bool = False) -> Outcome:
    """Identify k_D of an archived run under a wear law; steps it stands on are done first where they are not."""
    correct_archived_drift(archive, run_id, recipe)
    fit_archived_friction(archive, run_id, recipe)

    def compute() -> tuple[Record, Curves]:
        corrected, friction = archived_correction(archive, run_id), archived_friction(archive, run_id)
        if isinstance(corrected.run.manifest.contact, TwinDisc):
            pair = fit_discs(corrected.run, law, friction, recipe)
            return pair, _disc_curves(fitted_discs(corrected.run, pair, friction, recipe))
        fit = fit_wear(corrected, law, friction, recipe)
        return fit, _law_curves(fitted_curve(corrected.run, fit, friction, recipe))

    options = {
        "wear": {
            "engine": recipe.wear.engine,
            "friction": recipe.wear.friction,
            "correction": recipe.wear.correction,
        },
        "drift": _told(recipe.drift),
        "uncertainty": _told(recipe.uncertainty),
        "monte_carlo": _told(recipe.monte_carlo),
    }
    options |= _convention(archive, run_id, recipe)
    return _advance(archive, run_id, _Advance(WEAR_FITS[law], options, compute), "wear_fit", force=force)


def _law_curves(curve: LawCurve | None) -> Curves:
    if curve is None:
        return {}
    return {
        "wear_depth": (curve.wear_depth, "m"),
        "wear_depth_lower": (curve.lower, "m"),
        "wear_depth_upper": (curve.upper, "m"),
    }


def _disc_curves(curves: DiscCurves | None) -> Curves:
    found: dict[str, tuple[Column, str]] = {}
    for name, band in curves.bands.items() if curves is not None else ():
        lines = {name: band.best, f"{name}_lower": band.lower, f"{name}_upper": band.upper}
        found |= {line: (values, OUTCOMES[name]) for line, values in lines.items()}
    return found


def _convention(archive: Archive, run_id: str, recipe: Recipe) -> dict[str, Any]:
    """Return what steps of a twin-disc run are told besides: what counts as slid in a rotation."""
    discs = archive.manifest(run_id).rolls
    return {"distance_per_rotation": recipe.wear.distance_per_rotation} if discs else {}


def predict_archived(
    archive: Archive, run_id: str, reference: str, law: LawName, recipe: Recipe, *, force: bool = False
) -> Outcome:
    """Predict a run's wear from the k_D of another run, over the run's own distance, and archive the prediction."""
    fit = archived_fit(archive, reference, law)
    known = known_discs(fit) if isinstance(fit, TwinDiscFit) else known_pin(fit)
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
    if "clean_up" not in archive.step_names(run_id):
        clean_archived(archive, run_id, recipe)

    def compute() -> tuple[Record, Curves]:
        run, friction = archive.cleaned(run_id), archived_friction(archive, run_id)
        if isinstance(known, KnownDiscs):
            discs = disc_scenario(run, law, known, friction, recipe)
            pair = predict_discs(discs, [float(np.nanmax(run.columns["rotations"]))], reference=reference)
            return pair, _disc_curves(predicted_discs(run, discs, pair))
        scenario = run_scenario(run, law, known, friction, recipe)
        result = predict_wear(scenario, [float(np.nanmax(run.sliding_distance))], reference=reference)
        return result, _law_curves(predicted_curve(run, scenario, result))

    options = {
        "reference": reference,
        "wear": {"friction": recipe.wear.friction},
        "uncertainty": _told(recipe.uncertainty),
    }
    step = _Advance(PREDICTIONS[law], options, compute, [digest(*known.parts)])
    return _advance(archive, run_id, step, "prediction", force=force)


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
    if "clean_up" not in archive.step_names(run_id):
        clean_archived(archive, run_id, recipe)
    known = coefficients or archived_coefficients(archive, run_id, law)

    def compute() -> Found:
        run = archive.cleaned(run_id)
        path = run_path(run, archived_friction(archive, run_id), recipe.wear.friction)
        end = float(np.nanmax(run.columns["rotations"] if run.manifest.rolls else run.sliding_distance))
        scenario = local_scenario(run.manifest, known, law, path, recipe)
        reference = None if coefficients else run_id
        curves = wear_locally(scenario, at or default_places(end), how, reference=reference)
        fit = None if coefficients else archive.result(run_id, WEAR_FITS[law], Record)
        return curves.result.told(_engine_notes(fit, curves.result)), {}, local_wear_tables(curves)

    options = {"local_wear": asdict(how), "at": list(at), "wear": {"friction": recipe.wear.friction}}
    step = _Advance(LOCAL_WEAR[law], options, compute, [digest(*known)])
    return _advance(archive, run_id, step, "local_wear", force=force)


def archived_coefficients(archive: Archive, run_id: str, law: LawName) -> list[Quantity]:
    """Return k_D of a run as its fit found it, of discs both as Archard's law has them.

    Raises ``FitError`` where nothing was fitted.
    """
    fit = archive.result(run_id, WEAR_FITS[law], Record)
    if isinstance(fit, TwinDiscFit) and (discs := archards_discs(fit)) is not None:
        return [discs.curved, discs.flat]
    if isinstance(fit, WearFit) and fit.wear_coefficient is not None:
        return [fit.wear_coefficient]
    raise FitError(
        f"{run_id}: found no k_D under {law} in the archive; expected one to wear the run by; run `tribopipe fit "
        f'--law {law} {run_id}`, or give one, --wear-coefficient "13.5e-9 mm^3/(N*mm)"'
    )


def _engine_notes(fit: Record | None, worn: LocalWearResult) -> Iterator[str]:
    """Say of a k_D by the GIWM that local wear has another, where the two depths differ."""
    apart = worn.points[-1].difference
    if isinstance(fit, WearFit) and fit.engine == "giwm" and apart is not None and abs(apart) > _APART:
        yield (
            f"k_D was identified by the GIWM, whose depth is {abs(apart):.1%} off here; "
            "`tribopipe fit --engine local` finds that of local wear"
        )


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
    try:
        ingested = ingest(path, archive, force=force)
    except TribopipeError as error:
        yield Outcome(str(path), "ingest", "failed", error=error)
        return
    yield ingested
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
        try:
            yield advance()
        except TribopipeError as error:
            yield Outcome(run_id, stage, "failed", error=error)


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
        except TribopipeError as error:
            yield Outcome(run_id, "prediction", "failed", error=error)


def archived_correction(archive: Archive, run_id: str) -> CorrectedRun:
    """Return the corrected run as the archive holds it. Raises ``ArchiveError`` where it was not corrected."""
    correction = archive.needed_result(run_id, "drift_correction", DriftCorrection)
    step = archive.step(run_id, "drift_correction")
    wear = step.curves["wear_depth"][0] if step is not None and step.curves else None
    return CorrectedRun(archive.cleaned(run_id), correction, wear)


def archived_friction(archive: Archive, run_id: str) -> FrictionFit | None:
    """Return the friction fit as the archive holds it; none where it was not done."""
    return archive.result(run_id, "friction_fit", FrictionFit)


def archived_fit(archive: Archive, run_id: str, law: LawName) -> WearFit | TwinDiscFit:
    """Return the wear fit as the archive holds it. Raises ``ArchiveError`` where it was not done."""
    fit = archive.needed_result(run_id, WEAR_FITS[law], Record)
    return fit if isinstance(fit, TwinDiscFit) else archive.needed_result(run_id, WEAR_FITS[law], WearFit)


def _told(record: Record) -> dict[str, Any]:
    return record.model_dump(mode="json")


def _result_sha256(archive: Archive, run_id: str, name: StepName) -> str:
    there = archive.fingerprints(run_id, name)
    return "" if there is None else there.result


def _advance(
    archive: Archive,
    run_id: str,
    step: _Advance,
    stage: Stage,
    *,
    force: bool,
) -> Outcome:
    before = [_result_sha256(archive, run_id, base) for base in STEPS[step.name].stands_on]
    inputs = digest(VERSION, step.name, step.options, archive.raw_sha256(run_id), *before, *step.inputs)
    there = archive.fingerprints(run_id, step.name)
    if there is not None and there.inputs == inputs and not force:
        return Outcome(run_id, stage, "unchanged", archive.result(run_id, step.name, Record))
    try:
        result, *arrays = step.compute()
    except TribopipeError as error:
        raise error if run_id in str(error) else type(error)(f"{run_id}: {error}") from None
    date = datetime.now(UTC).isoformat(timespec="seconds")
    archive.put_step(run_id, Step(step.name, result, inputs, step.options, VERSION, date, *arrays))
    return Outcome(run_id, stage, "done", result)
