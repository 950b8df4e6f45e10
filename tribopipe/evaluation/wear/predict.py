"""Wear depth at other loads, distances and geometries from a known k_D, and the distance to a given depth."""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal

import numpy as np

from tribopipe.base.arrays import Column, Values
from tribopipe.base.errors import FitError
from tribopipe.contacts.pin_on_disc import pin_curve
from tribopipe.documents.contact import PinOnDisc
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import LawName, Recipe
from tribopipe.evaluation.wear.given_parameters import given_parameters, require_all
from tribopipe.evaluation.wear.inputs import Input, best_values, contact_inputs, default_notes, law_inputs
from tribopipe.physics.conventions import WearEngine
from tribopipe.physics.friction_path import FrictionPath
from tribopipe.physics.laws import WearLaw, law_named
from tribopipe.physics.pin_on_disc import PinContact, WornState
from tribopipe.results.wear_fit import LawValue
from tribopipe.results.wear_prediction import PredictedBody, PredictedPoint, UsedCoefficient, WearPrediction

DEFAULT_STEPS = 50_000
_NOTABLE_STEP_ERROR = 1e-3


@dataclass(frozen=True)
class WearScenario:
    """What wear is predicted for: contact, load, law and k_D (m²/N).

    The uncertainties of k_D, load, tip radius and moduli are taken as independent of each other.
    """

    contact: PinOnDisc
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

    def distance_at(self, depth: float) -> float:
        """Return the sliding distance, m, at which the pin has worn to a depth, m.

        S(s) is inverted by bracketing: s lies between S/f_max and S/f_min. Raises ``ContactError`` past the tip.
        """
        from scipy.optimize import brentq

        values = self.values
        volume = float(self.pin(values).volume(depth))
        wanted = volume / (values["wear_coefficient"] * values["normal_load"])
        if wanted == 0:
            return wanted

        def excess(distance: float) -> float:
            return float(self.law.effective_distance(np.asarray(distance), self.friction)) - wanted

        return float(brentq(excess, 0.0, beyond(excess, wanted), xtol=1e-12 * wanted, rtol=1e-13))


def beyond(excess: Callable[[float], float], start: float) -> float:
    """Return a place at or after the start where an excess, which grows, is not below zero.

    Raises ``FitError`` where there is none within a billion times the start.
    """
    for doublings in range(30):
        if excess(place := start * 2.0**doublings) >= 0:
            return place
    raise FitError(
        "wear law: found that it wears less and less and never so deep; expected a depth that it reaches; ask for less"
    )


def published_curve(scenario: WearScenario, distance: float, steps: int) -> tuple[Column, Column]:
    """Return sliding distances and depths, m, by the paper's explicit Euler scheme in equal steps (Fig. 2)."""
    if steps < 1:
        raise FitError(f"published scheme: found {steps} steps; expected at least 1; give --steps a positive number")
    values = scenario.values
    grid = np.linspace(0.0, distance, steps + 1)
    factor = scenario.law.rate_factor(grid[:-1], scenario.friction)
    volumes = values["wear_coefficient"] * values["normal_load"] * factor * np.diff(grid)
    return grid, scenario.pin(values).published_depth(volumes)


def predict_wear(
    scenario: WearScenario,
    at: Sequence[float] = (),
    *,
    depths: Sequence[float] = (),
    scheme: Literal["exact", "published"] = "exact",
    steps: int = DEFAULT_STEPS,
    reference: str | None = None,
) -> WearPrediction:
    """Predict the pin at sliding distances ``at``, m, and the distances at which it reaches wear ``depths``, m.

    ``scheme="published"`` takes ``steps`` equal Euler steps to the largest distance, and the result says how far off
    they are; depths are always reached by the closed form. Raises ``ContactError`` where the wear would exceed the tip.
    """
    distance = np.asarray(at, dtype=float)
    if not np.all(np.isfinite(distance)) or np.any(distance < 0):
        raise FitError(f"prediction: found the distances {list(at)}; expected none below zero; check --at")
    exact = scenario.worn(distance).depth
    depth, error = exact, None
    if scheme == "published" and distance.size:
        grid, curve = published_curve(scenario, float(distance.max()), steps)
        depth = np.asarray(np.interp(distance, grid, curve))
        farthest = int(distance.argmax())
        error = float(depth[farthest] / exact[farthest] - 1) if exact[farthest] else 0.0
    return WearPrediction(
        model=scenario.model,
        engine=scenario.engine,
        scheme=scheme,
        bodies={scenario.contact.fitted_bodies[0]: UsedCoefficient(wear_coefficient=scenario.wear_coefficient)},
        reference=reference,
        normal_load=scenario.normal_load,
        conditions={"pin_radius": scenario.contact.pin.radius},
        steps=steps if scheme == "published" else None,
        step_error=error,
        notes=(*_coefficient_notes(scenario), *default_notes(scenario.inputs), *_step_notes(error, steps, distance)),
        prediction=tuple(_points(scenario, distance, depth)),
        reached=tuple(_reached(scenario, depths)),
        parameters=_law_values(scenario),
    )


def _law_values(scenario: WearScenario) -> tuple[LawValue, ...] | None:
    """Return the parameters of the law that a prediction was made with; none where it has none."""
    fitted = {one.name for one in scenario.parameters}
    given = given_parameters(scenario.law, scenario.recipe).items()
    stated = (LawValue(name=name, value=value, source="recipe") for name, value in given if name not in fitted)
    return (*scenario.parameters, *stated) or None


def _points(scenario: WearScenario, distance: Column, depth: Column) -> Iterator[PredictedPoint]:
    spread, radius = scenario.depth_uncertainty(distance), scenario.worn_to(depth).radius
    name = scenario.contact.fitted_bodies[0]
    for s, h, u, a in zip(distance.tolist(), depth.tolist(), spread.tolist(), radius.tolist(), strict=True):
        worn = Quantity(value=h, unit="m", standard_uncertainty=u)
        yield PredictedPoint(
            sliding_distance=Quantity(value=s, unit="m"),
            time=_time(scenario, s),
            wear_depth=worn,
            bodies={name: PredictedBody(wear_depth=worn)},
            half_width=Quantity(value=a, unit="m"),
            half_length=Quantity(value=a, unit="m"),
            pressure=Quantity(value=scenario.normal_load.value / (math.pi * a**2), unit="Pa"),
        )


def _reached(scenario: WearScenario, depths: Sequence[float]) -> Iterator[PredictedPoint]:
    """Say where each depth is reached; its uncertainty is that of the depth there over the slope dh/ds."""
    for depth in depths:
        distance = scenario.distance_at(depth)
        at = np.asarray([distance])
        (point,) = _points(scenario, at, np.asarray([depth]))
        pressure = scenario.normal_load.value / float(scenario.worn_to(np.asarray(depth)).area)
        rate = scenario.wear_coefficient.value * pressure
        rate *= float(scenario.law.rate_factor(at, scenario.friction)[0])
        spread = (point.wear_depth.standard_uncertainty or 0.0) / rate
        exact = Quantity(value=depth, unit="m")
        yield point.model_copy(
            update={
                "sliding_distance": Quantity(value=distance, unit="m", standard_uncertainty=spread),
                "time": _time(scenario, distance, spread),
                "wear_depth": exact,
                "bodies": {name: PredictedBody(wear_depth=exact) for name in point.bodies},
            }
        )


def _time(scenario: WearScenario, distance: float, spread: float | None = None) -> Quantity | None:
    speed = scenario.sliding_speed
    if speed is None:
        return None
    scaled = None if spread is None else spread / speed.value
    return Quantity(value=distance / speed.value, unit="s", standard_uncertainty=scaled)


def _coefficient_notes(scenario: WearScenario) -> tuple[str, ...]:
    given = scenario.wear_coefficient.standard_uncertainty is not None
    return () if given else ("k_D is taken as exact, since no standard uncertainty of it is known",)


def _step_notes(error: float | None, steps: int, distances: Column) -> tuple[str, ...]:
    if error is None or abs(error) < _NOTABLE_STEP_ERROR:
        return ()
    side, distance = "too deep" if error > 0 else "too shallow", float(distances.max())
    return (
        f"{steps} Euler steps of {distance / steps:.3g} m end {abs(error):.2%} {side}; the exact scheme has no such "
        "error",
    )
