"""Two discs as a prediction sees them: their wear by rotations of the curved one, from known k₁ and k₂."""

import math
from collections.abc import Collection, Iterator
from dataclasses import dataclass, field, fields
from functools import cached_property

import numpy as np

from tribopipe.base.arrays import Column, Values
from tribopipe.base.errors import FitError
from tribopipe.contacts.twin_disc import disc_pair
from tribopipe.documents.contact import DISCS, TwinDisc
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import LawName, Recipe
from tribopipe.evaluation.wear.given_parameters import law_as_given
from tribopipe.evaluation.wear.inputs import Input, best_values, law_inputs
from tribopipe.evaluation.wear.known import KnownWear
from tribopipe.evaluation.wear.scenario import beyond
from tribopipe.evaluation.wear.twin_disc.inputs import disc_inputs, effective_rotations
from tribopipe.evaluation.wear.twin_disc.validity import hertz_start, validity_notes
from tribopipe.physics.friction_path import FrictionPath
from tribopipe.physics.laws import WearLaw
from tribopipe.physics.twin_disc import DiscWear
from tribopipe.physics.twin_disc_steps import published_wear
from tribopipe.results.evaluation import COVERAGE_FACTOR
from tribopipe.results.run import RawRun
from tribopipe.results.wear_curves import Band
from tribopipe.results.wear_fit import HertzStart, WearFit
from tribopipe.results.wear_prediction import OUTCOMES, PredictedBody, PredictedPoint

MOST_STEPS = 5_000_000
"""A rotation at a time takes about a second for every million of them."""
COEFFICIENTS = ("curved_coefficient", "flat_coefficient")
"""Names of k₁ and k₂ among the inputs of a scenario."""
_MOST_PLACES = 600
"""At so many places the law is evaluated along a run; samples between lie on straight lines."""


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
    def speed(self) -> Quantity | None:
        """Speed of the curved disc, m/s."""
        return self.curved_disc_speed

    @property
    def conditions(self) -> dict[str, Quantity]:
        """The slip."""
        return {"slip": self.slip}

    @property
    def start(self) -> HertzStart:
        """Contact of the unworn discs by Hertz, where the published scheme starts."""
        return hertz_start(self.contact, self.values)

    @property
    def rolling(self) -> bool:
        """Discs roll, and their k_D depends on what counts as slid in a rotation."""
        return True

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

    def state(self, places: Column) -> DiscWear:
        """Return the discs after rotations."""
        return self.worn(places)

    def usual_steps(self, end: float) -> int:
        """Return one step a rotation, as the paper takes."""
        return max(1, math.ceil(end))

    def published(self, places: Column, steps: int) -> DiscWear:
        """Return the discs after rotations by the published scheme."""
        grid, curve = published_discs(self, float(places.max()), steps)
        return DiscWear(*(np.interp(places, grid, getattr(curve, one.name)) for one in fields(DiscWear)))

    def first_depth(self, state: DiscWear) -> Column:
        """Return the wear depth of the curved disc, m."""
        return np.asarray(state.curved_depth)

    def points(self, places: Column, state: DiscWear) -> Iterator[PredictedPoint]:
        """Yield both discs after each number of rotations."""
        spreads, slid = self.uncertainties(places), self.effective_rotations(places)
        # The model counts effective rotations; what is slid in them is slid in the true ones.
        truly = np.divide(places, slid, out=np.ones_like(places), where=slid > 0)
        for place, turns in enumerate(places.tolist()):

            def told(name: str, unit: str, at: int = place) -> Quantity:
                value, spread = float(getattr(state, name)[at]), float(spreads[name][at])
                return Quantity(value=value, unit=unit, standard_uncertainty=spread)

            curved, flat = told("curved_depth", "m"), told("flat_depth", "m")
            yield PredictedPoint(
                rotations=Quantity(value=turns, unit="1"),
                sliding_distance=Quantity(value=float(state.sliding_distance[place] * truly[place]), unit="m"),
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

    def rate(self, places: Column) -> Column:
        """Return dh₁/dN."""
        factor = self.law.rate_factor(places * self.slip_per_rotation, self.friction)
        return np.asarray(self.worn(places).curved_rate * factor)

    def validity_notes(self, places: Column) -> tuple[str, ...]:
        """Say where the discs leave what the model describes."""
        if not places.size:
            return ()
        last = self.worn(np.asarray([places.max()]))
        half_width, slip = float(last.half_width[0]), float(last.slip[0])
        return tuple(validity_notes(self.contact, self.start, self.slip.value, half_width, slip))

    def bands(self, run: RawRun) -> dict[str, Band]:
        """Return both discs and their contact along a run; the bands are those of all inputs."""
        return self._bands(run, None)

    def fitted_bands(self, run: RawRun, _: WearFit, /) -> dict[str, Band]:
        """Return the fitted discs along their run; the bands are those of k₁ and k₂."""
        return self._bands(run, COEFFICIENTS)

    def _bands(self, run: RawRun, of: tuple[str, ...] | None) -> dict[str, Band]:
        rotations = np.maximum(run.columns["rotations"], 0.0)
        last = float(np.nanmax(rotations))
        shares = np.unique(np.concatenate([np.linspace(0.0, 1.0, _MOST_PLACES // 2) ** power for power in (1, 3)]))
        places = shares * last
        worn, spreads = self.worn(places), self.uncertainties(places, of)
        found: dict[str, Band] = {}
        for name, unit in OUTCOMES.items():
            best = worn.curved_depth + worn.flat_depth if name == "depth" else getattr(worn, name)
            half = COVERAGE_FACTOR * spreads[name]
            lines = (best, np.maximum(best - half, 0.0), best + half)
            found[name] = Band(*(np.interp(rotations, places, line) for line in lines), unit=unit)
        return found

    def place_at(self, depth: float) -> float:
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
