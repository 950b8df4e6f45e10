"""Wear of two discs at other loads, slips and numbers of rotations, from known k₁ and k₂."""

import math
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, field, fields
from functools import cached_property
from typing import Literal

import numpy as np

from tribopipe.base.arrays import Column, Values
from tribopipe.base.errors import FitError
from tribopipe.contacts.twin_disc import disc_pair
from tribopipe.documents.contact import DISCS, TwinDisc
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import LawName, Recipe
from tribopipe.evaluation.wear.given_parameters import law_as_given
from tribopipe.evaluation.wear.inputs import Input, best_values, default_notes, law_inputs
from tribopipe.evaluation.wear.known import KnownWear
from tribopipe.evaluation.wear.predict import beyond
from tribopipe.evaluation.wear.twin_disc.inputs import disc_inputs, effective_rotations
from tribopipe.evaluation.wear.twin_disc.validity import hertz_start, validity_notes
from tribopipe.physics.friction_path import FrictionPath
from tribopipe.physics.laws import WearLaw
from tribopipe.physics.twin_disc import DiscWear
from tribopipe.physics.twin_disc_steps import published_wear
from tribopipe.results.wear_fit import HertzStart
from tribopipe.results.wear_prediction import PredictedBody, PredictedPoint, UsedCoefficient, WearPrediction

MOST_STEPS = 5_000_000
"""A rotation at a time takes about a second for every million of them."""
COEFFICIENTS = ("curved_coefficient", "flat_coefficient")
"""Names of k₁ and k₂ among the inputs of a scenario."""
_NOTABLE_STEP_ERROR = 1e-3


@dataclass(frozen=True)
class DiscScenario:
    """What wear of two discs is predicted for: contact, load, slip, law, k₁ and k₂.

    Uncertainties of the inputs are taken as independent of each other, but for k₁ and k₂.
    """

    contact: TwinDisc
    normal_load: Quantity
    slip: Quantity
    known: KnownWear
    model: LawName = "archard"
    friction: FrictionPath | None = None
    recipe: Recipe = field(default_factory=Recipe)
    curved_disc_speed: Quantity | None = None

    @property
    def inputs(self) -> dict[str, Input]:
        """Everything uncertain that wear depends on, k₁ and k₂ among it."""
        given = disc_inputs(self.contact, self.normal_load, self.slip, self.recipe)
        given |= law_inputs(self.law, self.recipe)
        return given | {
            name: Input(quantity, "fit") for name, quantity in zip(COEFFICIENTS, map(self.known.of, DISCS), strict=True)
        }

    @property
    def values(self) -> dict[str, float]:
        """Best estimates of the inputs."""
        return best_values(self.inputs)

    @property
    def slip_per_rotation(self) -> float:
        """Slip distance in one rotation of the unworn curved disc, m."""
        return 2 * math.pi * self.contact.curved_disc.rolling_radius.value * abs(self.slip.value)

    @cached_property
    def law(self) -> WearLaw:
        """The law. Raises ``FitError`` where it is not installed here, or the recipe lacks a parameter of it."""
        return law_as_given(self.model, self.recipe)

    def effective_rotations(self, rotations: Column, values: Values | None = None) -> Column:
        """Return the rotations in which Archard's law would wear as much."""
        return effective_rotations(self.law.at(values or {}), rotations, self.slip_per_rotation, self.friction)

    def worn(self, rotations: Column, values: Values | None = None) -> DiscWear:
        """Return the discs after rotations. Raises ``ContactError`` past the crown."""
        values = values or self.values
        discs = disc_pair(self.contact, values, self.known.distance)
        effective = self.effective_rotations(rotations, values)
        return discs.worn(effective, values["curved_coefficient"], values["flat_coefficient"])

    def uncertainties(self, rotations: Column, of: Collection[str] | None = None) -> dict[str, Column]:
        """Return the standard uncertainty of each field of the wear, and of the summed ``depth``.

        To first order (JCGM 100:2008, 5.2.2), from all inputs or only those named.
        """
        best = self.values
        names = [name for name, given in self.inputs.items() if given.spread > 0 and (of is None or name in of)]
        moved = {name: self._moved(rotations, name, best) for name in names}
        spreads = {}
        for outcome in _outcomes(self.worn(rotations)):
            variance = sum((change[outcome] ** 2 for change in moved.values()), np.zeros(np.shape(rotations)))
            if set(COEFFICIENTS) <= set(moved):
                curved, flat = (moved[name][outcome] for name in COEFFICIENTS)
                variance = variance + 2 * self.known.correlation * curved * flat
            spreads[outcome] = np.sqrt(np.maximum(variance, 0.0))
        return spreads

    def _moved(self, rotations: Column, name: str, best: dict[str, float]) -> dict[str, Column]:
        """Return how each outcome moves with one standard uncertainty of an input."""
        # A relative step small enough to stay linear however wide the uncertainty is.
        spread, middle = self.inputs[name].spread, best[name]
        step = 1e-4 * (abs(middle) or spread)
        # A coefficient of 0 has nothing below it.
        below = middle - step if middle else 0.0
        high, low = (_outcomes(self.worn(rotations, {**best, name: value})) for value in (middle + step, below))
        return {outcome: (high[outcome] - low[outcome]) * spread / (middle + step - below) for outcome in high}

    def rotations_at(self, depth: float) -> float:
        """Return the rotations after which the curved disc has worn by a depth, m; infinite where it never has.

        Raises ``ContactError`` past the crown.
        """
        from scipy.optimize import brentq

        discs = disc_pair(self.contact, self.values, self.known.distance)
        wanted = float(discs.rotations(depth, *(self.known.of(disc).value for disc in DISCS)))
        if not 0 < wanted < math.inf:
            return wanted

        def excess(rotations: float) -> float:
            return float(self.effective_rotations(np.asarray(rotations))) - wanted

        return float(brentq(excess, 0.0, beyond(excess, wanted), xtol=1e-12 * wanted, rtol=1e-13))


def _outcomes(worn: DiscWear) -> dict[str, Column]:
    found = {one.name: np.asarray(getattr(worn, one.name)) for one in fields(DiscWear)}
    return found | {"depth": worn.curved_depth + worn.flat_depth}


def published_discs(scenario: DiscScenario, rotations: float, steps: int) -> tuple[Column, DiscWear]:
    """Return rotations and wear by the paper's explicit steps, equal ones up to some rotations (Fig. 8 and A).

    Raises ``FitError`` for more steps than can be waited for.
    """
    if not 1 <= steps <= MOST_STEPS:
        raise FitError(
            f"published scheme: found {steps:,} steps; expected 1 to {MOST_STEPS:,}; say how many with --steps, or use "
            "the exact scheme, which costs nothing"
        )
    discs = disc_pair(scenario.contact, scenario.values, scenario.known.distance)
    grid = np.linspace(0.0, rotations, steps + 1)
    effective = np.diff(scenario.effective_rotations(grid))
    values = scenario.values
    return grid, published_wear(discs, effective, values["curved_coefficient"], values["flat_coefficient"])


def predict_discs(
    scenario: DiscScenario,
    at: Sequence[float] = (),
    *,
    depths: Sequence[float] = (),
    scheme: Literal["exact", "published"] = "exact",
    steps: int | None = None,
    reference: str | None = None,
) -> WearPrediction:
    """Predict both discs after rotations ``at``, and the rotations at which the curved one reaches ``depths``, m.

    ``scheme="published"`` takes the paper's explicit steps, one a rotation unless ``steps`` says how many up to the
    largest number of rotations, and the result says how far off they are; depths are always reached by the exact
    scheme. Raises ``ContactError`` where the wear would exceed the crown.
    """
    rotations = np.asarray(at, dtype=float)
    if not np.all(np.isfinite(rotations)) or np.any(rotations < 0):
        raise FitError(f"prediction: found the rotations {list(at)}; expected none below zero; check --at")
    if any(not depth >= 0 for depth in depths):
        raise FitError(f"prediction: found the depths {list(depths)} m; expected none below zero; check --depth")
    reached = np.asarray([scenario.rotations_at(depth) for depth in depths])
    if np.any(np.isinf(reached)):
        raise FitError(
            "prediction: found a curved disc that does not wear; expected a wear coefficient above zero, or no --depth"
        )
    worn, error, taken = scenario.worn(rotations), None, None
    start = hertz_start(scenario.contact, scenario.values)
    if scheme == "published" and rotations.size:
        taken = steps or max(1, math.ceil(float(rotations.max())))
        grid, curve = published_discs(scenario, float(rotations.max()), taken)
        last = int(rotations.argmax())
        exact = float(worn.curved_depth[last])
        worn = DiscWear(*(np.interp(rotations, grid, getattr(curve, one.name)) for one in fields(DiscWear)))
        error = float(worn.curved_depth[last]) / exact - 1 if exact else 0.0
    return WearPrediction(
        model=scenario.model,
        scheme=scheme,
        distance_per_rotation=scenario.known.distance,
        bodies={name: UsedCoefficient(wear_coefficient=found) for name, found in scenario.known.bodies.items()},
        reference=reference,
        normal_load=scenario.normal_load,
        conditions={"slip": scenario.slip},
        steps=taken,
        step_error=error,
        start=start,
        notes=_notes(scenario, start, rotations, error, taken),
        prediction=tuple(_points(scenario, rotations, worn)),
        reached=tuple(_reached(scenario, reached)),
    )


def _points(scenario: DiscScenario, rotations: Column, worn: DiscWear) -> Iterator[PredictedPoint]:
    spreads, slid = scenario.uncertainties(rotations), scenario.effective_rotations(rotations)
    # The model counts effective rotations; what is slid in them is slid in the true ones.
    truly = np.divide(rotations, slid, out=np.ones_like(rotations), where=slid > 0)
    for place, turns in enumerate(rotations.tolist()):

        def told(name: str, unit: str, at: int = place) -> Quantity:
            value, spread = float(getattr(worn, name)[at]), float(spreads[name][at])
            return Quantity(value=value, unit=unit, standard_uncertainty=spread)

        curved, flat = told("curved_depth", "m"), told("flat_depth", "m")
        yield PredictedPoint(
            rotations=Quantity(value=turns, unit="1"),
            sliding_distance=Quantity(value=float(worn.sliding_distance[place] * truly[place]), unit="m"),
            time=_time(scenario, turns),
            wear_depth=Quantity(
                value=curved.value + flat.value, unit="m", standard_uncertainty=float(spreads["depth"][place])
            ),
            bodies={
                "curved_disc": PredictedBody(wear_depth=curved, wear_volume=told("curved_volume", "m^3")),
                "flat_disc": PredictedBody(wear_depth=flat, wear_volume=told("flat_volume", "m^3")),
            },
            half_width=told("half_width", "m"),
            half_length=told("half_length", "m"),
            pressure=told("pressure", "Pa"),
            slip=told("slip", "1"),
        )


def _reached(scenario: DiscScenario, rotations: Column) -> Iterator[PredictedPoint]:
    """Say where each depth is reached; its uncertainty is that of the depth there over the slope dh/dN."""
    worn, law = scenario.worn(rotations), scenario.law
    rates = worn.curved_rate * law.rate_factor(rotations * scenario.slip_per_rotation, scenario.friction)
    for point, reached, rate in zip(
        _points(scenario, rotations, worn), rotations.tolist(), rates.tolist(), strict=True
    ):
        curved = point.bodies[DISCS[0]]
        spread = (curved.wear_depth.standard_uncertainty or 0.0) / rate
        exact = curved.wear_depth.model_copy(update={"standard_uncertainty": None})
        turns = Quantity(value=float(reached), unit="1", standard_uncertainty=spread)
        bodies = point.bodies | {DISCS[0]: curved.model_copy(update={"wear_depth": exact})}
        time = _time(scenario, turns.value, spread)
        yield point.model_copy(update={"rotations": turns, "time": time, "bodies": bodies})


def _time(scenario: DiscScenario, rotations: float, spread: float | None = None) -> Quantity | None:
    if scenario.curved_disc_speed is None:
        return None
    turn = 2 * math.pi * scenario.contact.curved_disc.rolling_radius.value / scenario.curved_disc_speed.value
    return Quantity(value=rotations * turn, unit="s", standard_uncertainty=None if spread is None else spread * turn)


def _notes(
    scenario: DiscScenario, start: HertzStart, rotations: Column, error: float | None, steps: int | None
) -> tuple[str, ...]:
    notes = []
    if scenario.known.first.standard_uncertainty is None:
        notes.append("k_D is taken as exact, since no standard uncertainty of it is known")
    if rotations.size:
        last = scenario.worn(np.asarray([rotations.max()]))
        half_width, slip = float(last.half_width[0]), float(last.slip[0])
        notes += validity_notes(scenario.contact, start, scenario.slip.value, half_width, slip)
    notes += default_notes(scenario.inputs)
    if error is not None and steps is not None and abs(error) >= _NOTABLE_STEP_ERROR:
        side = "too deep" if error > 0 else "too shallow"
        notes.append(
            f"{steps:,} Euler steps of {float(rotations.max()) / steps:.3g} rotations end {abs(error):.2%} {side}; the "
            "exact scheme has no such error"
        )
    return tuple(notes)
