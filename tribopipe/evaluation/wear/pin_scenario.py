"""A pin on a disc as a prediction sees it: its wear depth by sliding distance from a known k_D."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from tribopipe.base.arrays import Column, Values
from tribopipe.base.errors import FitError
from tribopipe.contacts.pin_on_disc import pin_curve
from tribopipe.documents.contact import SlidingPin
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import LawName, Recipe
from tribopipe.evaluation.wear.given_parameters import require_all
from tribopipe.evaluation.wear.inputs import Input, best_values, contact_inputs, law_inputs
from tribopipe.evaluation.wear.known import KnownWear
from tribopipe.evaluation.wear.scenario import beyond
from tribopipe.physics.conventions import WearEngine
from tribopipe.physics.friction_path import FrictionPath
from tribopipe.physics.laws import WearLaw, law_named
from tribopipe.physics.pin_on_disc import PinContact, WornState
from tribopipe.results.evaluation import COVERAGE_FACTOR
from tribopipe.results.run import RawRun
from tribopipe.results.wear_curves import Band
from tribopipe.results.wear_fit import LawValue, WearFit
from tribopipe.results.wear_prediction import PredictedBody, PredictedPoint

DEFAULT_STEPS = 50_000


@dataclass(frozen=True)
class PinScenario:
    """What wear is predicted for: contact, load, law and k_D (m²/N).

    The uncertainties of k_D, load, tip radius and moduli are taken as independent of each other.
    """

    contact: SlidingPin
    normal_load: Quantity
    wear_coefficient: Quantity
    model: LawName = "archard"
    friction: FrictionPath | None = None
    recipe: Recipe = field(default_factory=Recipe)
    sliding_speed: Quantity | None = None
    engine: WearEngine = "giwm"
    """That k_D was found by."""
    parameters: tuple[LawValue, ...] = ()
    """Of the law beside k_D, as its fit has them; those left out are in the recipe."""
    covariance: tuple[tuple[float, ...], ...] | None = None
    """Of ln k_D and those parameters that were fitted."""

    @property
    def known(self) -> KnownWear:
        """k_D of the pin."""
        bodies = {self.contact.fitted_bodies[0]: self.wear_coefficient}
        return KnownWear(bodies, self.engine, parameters=self.parameters, covariance=self.covariance)

    @property
    def speed(self) -> Quantity | None:
        """Sliding speed, m/s."""
        return self.sliding_speed

    @property
    def conditions(self) -> dict[str, Quantity]:
        """The radius of the tip."""
        return {"pin_radius": self.contact.equivalent_pin.radius}

    @property
    def start(self) -> None:
        """The published scheme starts without wear."""

    @property
    def rolling(self) -> bool:
        """A pin slides all the way."""
        return False

    @cached_property
    def law(self) -> WearLaw:
        """The law. Raises ``FitError`` where it is not installed here, or where nobody gave a parameter of it."""
        law = law_named(self.model)
        values = {name: given.quantity.value for name, given in self._law_inputs(law).items()}
        require_all(law, values)
        return law.at(values)

    def _law_inputs(self, law: WearLaw) -> dict[str, Input]:
        found = {law.input_of(one.name): Input(one.value, one.source) for one in self.parameters}
        return law_inputs(law, self.recipe) | found

    @property
    def inputs(self) -> dict[str, Input]:
        """Everything uncertain that the depth depends on, k_D among it."""
        given = contact_inputs(self.contact, self.normal_load, self.recipe)
        return given | {"wear_coefficient": Input(self.wear_coefficient, "fit")} | self._law_inputs(self.law)

    @property
    def values(self) -> dict[str, float]:
        """Best estimates of the inputs."""
        return best_values(self.inputs)

    def volume(self, distance: Column, values: Values) -> Column:
        """Return the worn volume v = k_D·F_N·S(s), m³."""
        effective = self.law.at(values).effective_distance(distance, self.friction)
        return values["wear_coefficient"] * values["normal_load"] * effective

    def pin(self, values: Values) -> PinContact:
        """Return the pin's depth against worn volume."""
        return pin_curve(self.contact, values, self.engine)

    def worn(self, distance: Column, values: Values | None = None) -> WornState:
        """Return depth and contact radius at sliding distances in m. Raises ``ContactError`` past the tip."""
        values = values or self.values
        return self.pin(values).worn(self.volume(distance, values))

    def worn_to(self, depth: Column) -> WornState:
        """Return the pin at wear depths in m: the geometry is the same for both schemes (Fig. 2b)."""
        pin = self.pin(self.values)
        return pin.worn(pin.volume(depth))

    def depth_uncertainty(self, distance: Column) -> Column:
        """Return the standard uncertainty of the depth, m, to first order (JCGM 100:2008, 5.1.2)."""
        variance = np.square(self.fitted_uncertainty(distance))
        for name, given in self.inputs.items():
            if given.spread and name not in self._fitted_together:
                variance += (self._slope(distance, name) * given.spread) ** 2
        return np.asarray(np.sqrt(variance))

    def fitted_uncertainty(self, distance: Column) -> Column:
        """Return what of it comes from k_D and the parameters that were fitted with it; none where there are none."""
        slopes = [self._slope(distance, name) for name in self._fitted_together]
        if not slopes:
            return np.zeros_like(distance)
        moved = np.stack([slopes[0] * self.wear_coefficient.value, *slopes[1:]])
        variance = np.einsum("in,ij,jn->n", moved, np.asarray(self.covariance), moved)
        return np.asarray(np.sqrt(np.maximum(variance, 0.0)))

    @property
    def _fitted_together(self) -> list[str]:
        """Return k_D and the parameters that were fitted with it; nothing where there are none."""
        fitted = [
            self.law.input_of(one.name)
            for one in self.parameters
            if one.source == "fit" and one.value.standard_uncertainty is not None
        ]
        return ["wear_coefficient", *fitted] if self.covariance is not None else []

    def _slope(self, distance: Column, name: str) -> Column:
        """Return how the depth moves with an input, m over its unit."""
        best, value = self.values, self.values[name]
        # A relative step small enough to stay linear however wide the uncertainty is.
        step = 1e-4 * (abs(value) or self.inputs[name].spread)
        high, low = (self.worn(distance, {**best, name: value + sign * step}).depth for sign in (1, -1))
        return np.asarray((high - low) / (2 * step))

    def state(self, places: Column) -> Column:
        """Return the wear depth at sliding distances, m."""
        return self.worn(places).depth

    def usual_steps(self, _: float, /) -> int:
        """Return the number of steps of the published scheme."""
        return DEFAULT_STEPS

    def published(self, places: Column, steps: int) -> Column:
        """Return the wear depth at sliding distances, m, by the published scheme."""
        grid, curve = published_curve(self, float(places.max()), steps)
        return np.asarray(np.interp(places, grid, curve))

    def first_depth(self, state: Column) -> Column:
        """Return the wear depth, m."""
        return state

    def points(self, places: Column, state: Column) -> Iterator[PredictedPoint]:
        """Yield the pin at each sliding distance."""
        spread, radius = self.depth_uncertainty(places), self.worn_to(state).radius
        name = self.contact.fitted_bodies[0]
        for s, h, u, a in zip(places.tolist(), state.tolist(), spread.tolist(), radius.tolist(), strict=True):
            worn = Quantity(value=h, unit="m", standard_uncertainty=u)
            yield PredictedPoint(
                sliding_distance=Quantity(value=s, unit="m"),
                wear_depth=worn,
                bodies={name: PredictedBody(wear_depth=worn)},
                half_width=Quantity(value=a, unit="m"),
                half_length=Quantity(value=a, unit="m"),
                pressure=Quantity(value=self.normal_load.value / (math.pi * a**2), unit="Pa"),
            )

    def rate(self, places: Column) -> Column:
        """Return dh/ds = k_D·p·f."""
        pressure = self.normal_load.value / self.worn(places).area
        return np.asarray(self.wear_coefficient.value * pressure * self.law.rate_factor(places, self.friction))

    def validity_notes(self, _: Column, /) -> tuple[str, ...]:
        """Return what the contact assumes; a tip that is worn away is refused."""
        return self.contact.limits

    def bands(self, run: RawRun) -> dict[str, Band]:
        """Return the wear depth along a run; the band is that of k_D, load, tip radius and moduli."""
        distance = run.sliding_distance
        return {"wear_depth": _band(self.worn(distance).depth, self.depth_uncertainty(distance))}

    def fitted_bands(self, run: RawRun, fit: WearFit) -> dict[str, Band]:
        """Return the fitted wear depth along its run, with the band of what was fitted."""
        distance, pin = run.sliding_distance, fit.bodies[self.contact.fitted_bodies[0]]
        if self.covariance is not None or pin.fitted_end_depth is None:
            return {"wear_depth": _band(self.worn(distance).depth, self.fitted_uncertainty(distance))}
        # On a disc that wears, a pin loses more volume at the same depth: the curve ends on the fitted one.
        share = self._volume_share(distance, pin.fitted_end_depth.value)
        lines = (
            replace(self, wear_coefficient=k.model_copy(update={"value": share * k.value})).worn(distance).depth
            for k in (self.wear_coefficient, *pin.interval)
        )
        return {"wear_depth": Band(*lines, unit="m")}

    def _volume_share(self, distance: Column, depth: float) -> float:
        """Return the volume of the pin at its depth at the end over that worn, k_D·F_N·S."""
        pin = self.pin(self.values)
        end = np.asarray([np.nanmax(distance)])
        worn = float(np.asarray(pin.volume(self.worn(end).depth))[0])
        return float(np.asarray(pin.volume(depth))) / worn if worn > 0 else 1.0

    def place_at(self, depth: float) -> float:
        """Return the sliding distance, m, at which the pin has worn to a depth, m; infinite where it does not wear.

        S(s) is inverted by bracketing: s lies between S/f_max and S/f_min. Raises ``ContactError`` past the tip.
        """
        from scipy.optimize import brentq

        values = self.values
        if not values["wear_coefficient"] > 0:
            return math.inf
        volume = float(self.pin(values).volume(depth))
        wanted = volume / (values["wear_coefficient"] * values["normal_load"])
        if wanted == 0:
            return wanted

        def excess(distance: float) -> float:
            return float(self.law.effective_distance(np.asarray(distance), self.friction)) - wanted

        return float(brentq(excess, 0.0, beyond(excess, wanted), xtol=1e-12 * wanted, rtol=1e-13))


def published_curve(scenario: PinScenario, distance: float, steps: int) -> tuple[Column, Column]:
    """Return sliding distances and depths, m, by the paper's explicit Euler scheme in equal steps (Fig. 2)."""
    if steps < 1:
        raise FitError(f"published scheme: found {steps} steps; expected at least 1; give --steps a positive number")
    values = scenario.values
    grid = np.linspace(0.0, distance, steps + 1)
    factor = scenario.law.rate_factor(grid[:-1], scenario.friction)
    volumes = values["wear_coefficient"] * values["normal_load"] * factor * np.diff(grid)
    return grid, scenario.pin(values).published_depth(volumes)


def _band(depth: Column, uncertainty: Column) -> Band:
    half = COVERAGE_FACTOR * uncertainty
    return Band(depth, np.maximum(depth - half, 0.0), depth + half, unit="m")
