"""Wear and life of one run under many conditions: the cases of such a sweep, each by the exact engine."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from tribopipe.archive.provenance import digest
from tribopipe.archive.step_names import WEAR_FITS
from tribopipe.archive.store import Archive
from tribopipe.base.errors import FitError, ManifestError, UnitError
from tribopipe.base.units import parse, show
from tribopipe.documents.contact_kinds import spoken
from tribopipe.documents.manifest import RunManifest, StatedFriction, manifest_path, read_manifest
from tribopipe.documents.quantity import Quantity, WearCoefficient
from tribopipe.documents.recipe import LawName, Recipe
from tribopipe.documents.record import Record
from tribopipe.documents.signals import SIGNALS
from tribopipe.documents.sweep import Predictions, Sweep
from tribopipe.documents.toml import parse_toml
from tribopipe.evaluation.friction import fit_friction
from tribopipe.evaluation.load_and_friction import run_path
from tribopipe.evaluation.preprocessing.cleaning import clean_run
from tribopipe.evaluation.wear.prediction import predict_wear, wear_scenario
from tribopipe.evaluation.wear.scenario import KnownWear, given_wear, known_wear
from tribopipe.extras.sweep.cases import Case, Ensemble, Head, Row, combinations, label_heads, refuse_endless
from tribopipe.extras.sweep.subject import Settings, Subject, parameters
from tribopipe.physics.friction_path import FrictionPath
from tribopipe.physics.laws import law_named
from tribopipe.pipeline.archived_results import archived_fit, archived_friction
from tribopipe.readers.harmonize import read_run
from tribopipe.results.evaluation import FrictionFit
from tribopipe.results.run import RawRun
from tribopipe.results.wear_prediction import PredictedBody, PredictedPoint
from tribopipe.version import VERSION

_HEADS = {
    "wear_depth": Head("wear_depth", "m", uncertain=True),
    "wear_volume": Head("wear_volume", "m^3", uncertain=True),
    "mean_pressure": Head("mean_pressure", "Pa"),
}
"""Possible values of wear at a place."""
_WORN = "worn to "
_FRICTION = "run.conditions.friction"


class Condition(Record):
    """Conditions of a prediction."""

    run: RunManifest
    """Its run.toml."""
    law: LawName = "archard"
    """Wear law."""
    recipe: Recipe
    """Recipe."""
    wear_coefficient: WearCoefficient | None = None
    """k_D of the pin or the crowned disc; None for what the archived fit found under the law."""
    flat_wear_coefficient: WearCoefficient | None = None
    """k_D of the cylindrical disc next to it."""


@dataclass(frozen=True)
class Wanted:
    """Options of every prediction, and its documents."""

    at: tuple[float, ...]
    """Distances, m, or rotations."""
    depths: tuple[float, ...]
    """Depths, m."""
    known: Mapping[LawName, KnownWear]
    """k_D that the archived fit found under each law."""
    friction: FrictionPath | StatedFriction | None
    """Friction of the run."""

    def outcomes(self, unit: str) -> list[str]:
        """Return the label of each row: a place, or a depth to reach."""
        return [
            *(f"at {place:g} {unit}" for place in self.at),
            *(f"{_WORN}{show(h, None, 'm', 'um')}" for h in self.depths),
        ]

    @property
    def parts(self) -> list[Any]:
        """What distinguishes it from another for a fingerprint, but for the friction."""
        known = [part for law in sorted(self.known) for part in self.known[law].parts]
        return [str((self.at, self.depths)), *known]


def predicted(subject: Subject[Condition], settings: Settings, wanted: Wanted) -> list[Row]:
    """Predict a run under one set of conditions. Raises ``TribopipeError`` where there can be no such run."""
    condition = subject.changed(settings)
    stated = condition.run.conditions.friction
    otherwise = stated is not None and any(path.startswith(_FRICTION) for path in settings)
    friction = stated if stated is not None and otherwise else wanted.friction
    known = _known(condition, wanted)
    scenario = wear_scenario(condition.run, known, condition.law, friction, condition.recipe)
    result = predict_wear(scenario, wanted.at, depths=wanted.depths)
    progress = condition.run.progress
    return [
        Row(spoken(name), outcome, _told(point, body, numbers_of(condition.run)))
        for outcome, point in zip(wanted.outcomes(progress.unit), (*result.prediction, *result.reached), strict=True)
        for name, body in point.bodies.items()
    ]


def numbers_of(run: RunManifest) -> tuple[Head, ...]:
    """Return the values of a prediction: its place along the progress, time, and what the contact is shown by."""
    place = run.progress.signal
    return (
        Head(place, SIGNALS[place].unit, uncertain=True),
        Head("time", "s", uncertain=True),
        *(_HEADS[name] for name in run.described.shown),
    )


def _known(condition: Condition, wanted: Wanted) -> KnownWear:
    """Return the k_D given, or that of the archived fit. Raises ``FitError`` where there is neither."""
    stated = [one for one in (condition.wear_coefficient, condition.flat_wear_coefficient) if one is not None]
    if condition.wear_coefficient is not None:
        contact = condition.run.described
        return given_wear(contact, dict(zip(contact.fitted_bodies, stated, strict=False)), condition.recipe)
    if condition.law in wanted.known:
        return wanted.known[condition.law]
    raise FitError(
        f"{condition.run.id}: found no k_D under {condition.law}; expected one for the prediction; add "
        "wear_coefficient to the sweep, or fit the run first"
    )


def asked_for(row: Row) -> str:
    """Name what a row was made for: the depth at a place, or the place where a depth is worn to."""
    axis = "rotations" if "rotations" in row.found else "sliding_distance"
    return axis if row.outcome.startswith(_WORN) else "wear_depth"


def _told(point: PredictedPoint, body: PredictedBody, heads: tuple[Head, ...]) -> dict[str, Quantity]:
    """Return the numbers of a row: those of a body, or else of the contact, or of the place."""
    found = {}
    for head in heads:
        named = (getattr(part, head.name, None) for part in (body, point.contact, point))
        if (quantity := next(filter(None, named), None)) is not None:
            found[head.name] = quantity
    return found


@dataclass(frozen=True)
class _Source:
    """The run that is predicted, and as much of its signals as that takes."""

    manifest: RunManifest
    sha256: str
    """SHA-256 of the source; empty for a folder with only a manifest."""
    end: float | None
    """Its own end, m or rotations."""
    stated: Mapping[str, Any]
    """Content of its run.toml."""
    friction: FrictionPath | StatedFriction | None = None
    fit: FrictionFit | None = None


def predictions(
    sweep: Sweep, asked: Predictions, beside: Path, archive: Archive, recipe: Recipe, where: str
) -> Ensemble:
    """Return a case for each combination.

    Raises ``TribopipeError`` where a key or value is wrong, or the run, its fit or its friction is not there.
    """
    varied_laws = sweep.vary.get("law", ("archard",))
    laws = list(dict.fromkeys(varied_laws))
    frictional = any(law_named(law).needs_friction for law in laws)
    if asked.run is not None:
        source = _archived(archive, asked.run, recipe, frictional=frictional)
    else:
        source = _in_folder(beside / str(asked.folder), recipe, frictional=frictional)
    subject = Subject(Condition, _documents(source, asked, recipe), where)
    varied, repeats = parameters(sweep.vary, subject), sweep.repeats or 1
    refuse_endless(varied, repeats, where)
    given = asked.wear_coefficient is not None or "wear_coefficient" in sweep.vary
    known = {} if asked.run is None or given else _fitted(archive, asked.run, laws)
    wanted = Wanted(_places(asked, source, where), tuple(depth.value for depth in asked.depth), known, source.friction)
    made_from = digest(VERSION, subject.base, source.sha256, *wanted.parts)
    cases = [
        Case(
            one.labels(source.manifest.id),
            digest(made_from, one.settings)[:16],
            partial(predicted, subject, one.settings, wanted),
        )
        for one in combinations(varied, repeats, sweep.seed)
    ]
    return Ensemble(label_heads(varied, sweep.repeats), numbers_of(source.manifest), cases)


def _archived(archive: Archive, run_id: str, recipe: Recipe, *, frictional: bool) -> _Source:
    run, sha256 = archive.cleaned(run_id), digest(archive.stands_on(run_id, WEAR_FITS["sarkar"]))
    end, stated = run.end, parse_toml(Path(run.sources[0].name), run.sources[0].content)
    if not frictional:
        return _Source(run.manifest, sha256, end, stated)
    fit = archived_friction(archive, run_id)
    return _Source(run.manifest, sha256, end, stated, run_path(run, fit, recipe.wear.friction), fit)


def _in_folder(folder: Path, recipe: Recipe, *, frictional: bool) -> _Source:
    """Return the subject for a run folder; signals are read only if friction must be fitted."""
    path = manifest_path(folder)
    manifest, content = read_manifest(path)
    conditions, end, stated = manifest.conditions, manifest.planned, parse_toml(path, content)
    if not frictional:
        return _Source(manifest, "", end, stated)
    if conditions.friction is not None:
        return _Source(manifest, "", end, stated, conditions.friction)
    read = read_run(folder)
    run = clean_run(read, recipe).run
    fit = fit_friction(run, recipe.friction, recipe.uncertainty)
    return _Source(manifest, _sources(read), end, stated, run_path(run, fit, recipe.wear.friction), fit)


def _sources(run: RawRun) -> str:
    return digest(*(source.sha256 for source in run.sources))


def _documents(source: _Source, asked: Predictions, recipe: Recipe) -> dict[str, Any]:
    """Return what is varied: run.toml with its friction as it was fitted, without what was measured after the test."""
    condition = Condition(
        run=source.manifest,
        recipe=recipe,
        wear_coefficient=asked.wear_coefficient,
        flat_wear_coefficient=asked.flat_wear_coefficient,
    )
    documents = condition.model_dump(mode="json", by_alias=True, exclude_none=True)
    run, fit = documents["run"], source.fit
    for measured in ("end_values", "interruptions"):
        run.pop(measured, None)
    documents["run"] = run = _without_derived(run, source.stated)
    if fit is not None and fit.outcome == "exponential" and "friction" not in run["conditions"]:
        parts = ("amplitude", "steady_state", "running_in_distance")
        run["conditions"]["friction"] = fit.model_dump(mode="json", include=set(parts), exclude_none=True)
    return documents


def _without_derived(run: dict[str, Any], stated: Mapping[str, Any]) -> dict[str, Any]:
    """Leave out what follows from other keys, such as the radius of a ring from its diameter, to derive it again."""
    whole = RunManifest.model_validate(run)
    for path in _not_stated({name: run[name] for name in ("contact", "conditions") if name in run}, stated):
        less = _without(run, path)
        try:
            run = less if RunManifest.model_validate(less) == whole else run
        except ValidationError:
            continue
    return run


def _not_stated(document: Mapping[str, Any], stated: Mapping[str, Any]) -> Iterator[tuple[str, ...]]:
    """Give the paths of tables and values that are not stated."""
    for key, value in document.items():
        if key not in stated:
            yield (key,)
        elif isinstance(value, Mapping) and isinstance(stated[key], Mapping) and "unit" not in value:
            yield from ((key, *path) for path in _not_stated(value, stated[key]))


def _without(document: Mapping[str, Any], path: tuple[str, ...]) -> dict[str, Any]:
    key, *rest = path
    kept = {name: value for name, value in document.items() if name != key}
    return {**document, key: _without(document[key], tuple(rest))} if rest else kept


def _fitted(archive: Archive, run_id: str, laws: Sequence[LawName]) -> dict[LawName, KnownWear]:
    """Return k_D that the archived fits found, where they did."""
    found = {law: known_wear(archived_fit(archive, run_id, law)) for law in laws}
    return {law: known for law, known in found.items() if known is not None}


def _places(asked: Predictions, source: _Source, where: str) -> tuple[float, ...]:
    """Return where to predict, m or rotations: the run's own end where nothing is stated."""
    if not asked.at and not asked.depth:
        if source.end is None:
            raise ManifestError(
                f'{where}: predictions.at: missing; expected the points at which to predict wear; add at = ["500 m"]'
            )
        return (source.end,)
    try:
        return tuple(parse(text, source.manifest.progress.kind) for text in asked.at)
    except UnitError as error:
        raise ManifestError(f"{where}: predictions.at: {error}") from None
