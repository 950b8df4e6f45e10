"""One prediction of a sweep: wear and life of a run under one set of conditions, by the exact engine."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from tribopipe.base.errors import FitError
from tribopipe.base.units import show
from tribopipe.documents.contact_kinds import spoken
from tribopipe.documents.manifest import RunManifest
from tribopipe.documents.quantity import Quantity, WearCoefficient
from tribopipe.documents.recipe import LawName, Recipe
from tribopipe.documents.record import Record
from tribopipe.documents.signals import SIGNALS
from tribopipe.evaluation.friction_paths import stated_path
from tribopipe.evaluation.wear.curves import wear_scenario
from tribopipe.evaluation.wear.known import KnownWear, given_wear
from tribopipe.evaluation.wear.predict import predict_wear
from tribopipe.extras.sweep.rows import Head, Row
from tribopipe.extras.sweep.subject import Settings, Subject
from tribopipe.physics.friction_path import FrictionPath
from tribopipe.results.wear_prediction import PredictedBody, PredictedPoint

_HEADS = {
    "wear_depth": Head("wear_depth", "m", uncertain=True),
    "wear_volume": Head("wear_volume", "m^3", uncertain=True),
    "mean_pressure": Head("mean_pressure", "Pa"),
}
"""Possible values of wear at a place."""
_WORN = "worn to "
_FRICTION = "run.conditions.friction"


class Condition(Record):
    """What a run's wear is predicted under."""

    run: RunManifest
    """Its run.toml."""
    law: LawName = "archard"
    """Wear law."""
    recipe: Recipe
    """Recipe."""
    wear_coefficient: WearCoefficient | None = None
    """k_D of the pin or the crowned disc; none for what the archived fit found under the law."""
    flat_wear_coefficient: WearCoefficient | None = None
    """k_D of the cylindrical disc next to it."""


@dataclass(frozen=True)
class Wanted:
    """What is wanted of every prediction, and what is known with its documents."""

    at: tuple[float, ...]
    """Distances, m, or rotations."""
    depths: tuple[float, ...]
    """Depths, m."""
    known: Mapping[LawName, KnownWear]
    """k_D that the archived fit found under each law."""
    friction: FrictionPath | None
    """As the run has it."""

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
    friction = stated_path(stated) if stated is not None and otherwise else wanted.friction
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
        f"{condition.run.id}: found no k_D under {condition.law}; expected one to predict from; give wear_coefficient "
        "in the sweep, or fit the run first"
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
