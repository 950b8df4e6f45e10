"""The wear coefficient k_D of one run: least squares on the corrected wear curve, and a budget of its uncertainty.

The model depth is h(v) of the pin's master curve with v = k_D·F_N·S(s). k_D is the one fitted parameter; every other
number that enters (load, tip radius, moduli, end values, zero offset, end reading, friction) is an ``Input`` with a
standard uncertainty of its own. To first order a change of an input moves k_D by

    dk/dx = J·∂(y − h)/∂x / J·J,     J = ∂h/∂k

with y the corrected depth (JCGM 100:2008, 5.1.3). The problem as an object, ``WearProblem``, can be solved for any
values of its inputs, which is what a Monte Carlo needs.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from tribopipe.drift import SensorTrace, read_trace
from tribopipe.end_values import EndWear, end_wear, stated_or_default
from tribopipe.errors import FitError
from tribopipe.noise import effective_samples, inflation
from tribopipe.records.manifest import PinOnDisc
from tribopipe.records.quantity import Quantity
from tribopipe.records.recipe import FrictionSource, LawName, Recipe
from tribopipe.records.results import COVERAGE_FACTOR, Contribution, FrictionFit, WearFit
from tribopipe.run import Column, CorrectedRun
from tribopipe.wear.contact import contact_modulus
from tribopipe.wear.friction_path import ExponentialFriction, FrictionPath, run_path
from tribopipe.wear.laws import LAWS, WearLaw
from tribopipe.wear.pin_on_disc import FlatPin, PinContact, SphericalPin

_MOST_ITERATIONS = 50
_CONVERGED = 1e-12
_FEWEST_SAMPLES = 10

_MEASUREMENTS = frozenset({"pin_end_value", "disc_end_value", "zero_offset", "end_reading"})
"""Inputs of the corrected depth alone: the model does not depend on them."""

_FRICTION_INPUTS = ("friction_amplitude", "friction_steady_state", "running_in_distance")
"""A, b and c of Eq. 7, in the order of their covariance."""
_SHOWN_UNITS = {
    "normal_load": "mN",
    "pin_radius": "mm",
    "pin_modulus": "GPa",
    "disc_modulus": "GPa",
    "pin_end_value": "um",
    "disc_end_value": "nm",
    "zero_offset": "um",
    "end_reading": "um",
    "running_in_distance": "m",
    "wear_coefficient": "mm^3/(N*mm)",
}

Values = Mapping[str, float]


@dataclass(frozen=True)
class Input:
    """One number that k_D depends on."""

    quantity: Quantity
    source: Literal["manifest", "default", "fit"]

    @property
    def spread(self) -> float:
        """Standard uncertainty."""
        return self.quantity.standard_uncertainty or 0.0


def pin_contact(contact: PinOnDisc, values: Values) -> PinContact:
    """Build the pin's master curve from ``normal_load``, ``pin_radius``, ``pin_modulus`` and ``disc_modulus``."""
    if contact.pin.shape == "flat":
        return FlatPin(values["pin_radius"])
    modulus = contact_modulus(
        pin_modulus=values["pin_modulus"],
        pin_ratio=contact.pin.poisson_ratio.value,
        disc_modulus=values["disc_modulus"],
        disc_ratio=contact.disc.poisson_ratio.value,
    )
    return SphericalPin(normal_load=values["normal_load"], radius=values["pin_radius"], modulus=modulus)


def contact_inputs(contact: PinOnDisc, normal_load: Quantity, recipe: Recipe) -> dict[str, Input]:
    """Collect load, tip radius and moduli with the uncertainties stated, or else the recipe's defaults."""
    defaults = recipe.uncertainty
    stated = {
        "normal_load": (normal_load, defaults.normal_load),
        "pin_radius": (contact.pin.radius, defaults.pin_radius),
        "pin_modulus": (contact.pin.youngs_modulus, defaults.youngs_modulus),
        "disc_modulus": (contact.disc.youngs_modulus, defaults.youngs_modulus),
    }
    return {
        name: Input(*stated_or_default(quantity, relative * quantity.value))
        for name, (quantity, relative) in stated.items()
    }


@dataclass(frozen=True)
class WearProblem:
    """One run as a question: which k_D makes the model follow the corrected wear of the pin."""

    contact: PinOnDisc
    law: WearLaw
    distance: Column
    trace: SensorTrace
    end: EndWear
    friction: FrictionPath | None
    inputs: Mapping[str, Input]
    friction_covariance: tuple[tuple[float, ...], ...] | None = None
    """Of (A, b, c), where Eq. 7 is the friction."""

    @property
    def values(self) -> dict[str, float]:
        """Best estimates of the inputs."""
        return {name: given.quantity.value for name, given in self.inputs.items()}

    def pin_wear(self, values: Values) -> Column:
        """Return the corrected wear of the pin, m: the sensor's wear times the pin's share by the end values."""
        pin = self.end.pin_depth_of(values["pin_end_value"], values["pin_radius"])
        total = pin + values.get("disc_end_value", 0.0)
        wear = self.trace.wear(total, values["zero_offset"], values["end_reading"])
        return wear * (pin / total) if total else wear

    def effective_distance(self, values: Values) -> Column:
        """Return the law's S(s), m."""
        friction = self.friction
        if "friction_steady_state" in values:
            friction = ExponentialFriction(
                values.get("friction_amplitude", 0.0),
                values["friction_steady_state"],
                values.get("running_in_distance", 1.0),
            )
        return self.law.effective_distance(self.distance, friction)

    def depth(self, coefficient: float, values: Values) -> Column:
        """Return the model's wear depth, m, for a k_D in m²/N."""
        return pin_contact(self.contact, values).worn(self._volume(coefficient, values)).depth

    def _volume(self, coefficient: float, values: Values) -> Column:
        return coefficient * values["normal_load"] * self.effective_distance(values)

    def solve(self, values: Values) -> float:
        """Return the least-squares k_D, m²/N, by Gauss–Newton on ln k_D.

        Starts at the k_D that meets the last depth exactly. Raises ``FitError`` where the pin shows no wear.
        """
        wear, pin = self.pin_wear(values), pin_contact(self.contact, values)
        unit_volume = self._volume(1.0, values)
        end = self.end.pin_depth_of(values["pin_end_value"], values["pin_radius"])
        if not end > 0:
            raise FitError(
                "wear fit: found an end value without wear of the pin; expected wear to fit; a longer or "
                "heavier test may show some"
            )
        log_k = math.log(float(pin.volume(end)) / float(unit_volume[-1]))
        highest = math.log(float(pin.most_volume) / float(unit_volume[-1]))
        for _ in range(_MOST_ITERATIONS):
            volume = math.exp(log_k) * unit_volume
            state = pin.worn(volume)
            slope = volume / (np.pi * state.radius**2)
            step = float(slope @ (wear - state.depth)) / float(slope @ slope)
            log_k = min(log_k + max(-1.0, min(1.0, step)), highest)
            if abs(step) < _CONVERGED:
                return math.exp(log_k)
        raise FitError(
            f"wear fit: found no k_D in {_MOST_ITERATIONS} iterations; expected the depth to grow with distance; "
            "look at the raw depth signal"
        )

    def slope(self, coefficient: float, values: Values) -> Column:
        """Return ∂h/∂ln k_D, m."""
        volume = self._volume(coefficient, values)
        return volume / (np.pi * pin_contact(self.contact, values).worn(volume).radius ** 2)

    def sensitivity(self, name: str, coefficient: float) -> float:
        """Return ∂ln k_D/∂x for one input, by central differences over its standard uncertainty."""
        spread = self.inputs[name].spread
        if not spread:
            return 0.0
        low, high = ({**self.values, name: self.values[name] + sign * spread} for sign in (-1, 1))
        change = self.pin_wear(high) - self.pin_wear(low)
        if name not in _MEASUREMENTS:
            change = change - (self.depth(coefficient, high) - self.depth(coefficient, low))
        slope = self.slope(coefficient, self.values)
        return float(slope @ change) / float(slope @ slope) / (2 * spread)


def wear_problem(
    corrected: CorrectedRun, law: LawName, friction: FrictionFit | None, recipe: Recipe
) -> WearProblem | tuple[str, ...]:
    """Pose the fit of k_D to a corrected run, or say what the run lacks for it."""
    run = corrected.raw
    end = end_wear(run.manifest, recipe.uncertainty)
    if corrected.wear_depth is None or end is None:
        return corrected.correction.lacks
    path: FrictionPath | None = None
    covariance = None
    inputs = contact_inputs(run.manifest.contact, run.manifest.conditions.normal_load, recipe)
    if LAWS[law].needs_friction:
        path = run_path(run, friction, recipe.wear.friction)
        if path is None:
            return ("a friction signal",)
        if isinstance(path, ExponentialFriction) and friction is not None:
            inputs |= _friction_inputs(friction)
            covariance = friction.covariance
    trace = _seen(read_trace(run, recipe), seen := np.isfinite(corrected.wear_depth))
    inputs |= _trace_inputs(trace, end)
    return WearProblem(
        run.manifest.contact, LAWS[law], run.sliding_distance[seen], trace, end, path, inputs, covariance
    )


def _seen(trace: SensorTrace, seen: Column) -> SensorTrace:
    return SensorTrace(trace.reading[seen], trace.ramp[seen], trace.duration, trace.zero_offset, trace.end_reading)


def _friction_inputs(friction: FrictionFit) -> dict[str, Input]:
    fitted = (friction.amplitude, friction.steady_state, friction.running_in_distance)
    return {
        name: Input(quantity, "fit")
        for name, quantity in zip(_FRICTION_INPUTS, fitted, strict=True)
        if quantity is not None
    }


def _trace_inputs(trace: SensorTrace, end: EndWear) -> dict[str, Input]:
    inputs = {
        "pin_end_value": Input(end.pin.quantity, end.pin.source),
        "zero_offset": Input(trace.zero_offset, "fit"),
        "end_reading": Input(trace.end_reading, "fit"),
    }
    if end.disc is not None:
        inputs["disc_end_value"] = Input(end.disc.quantity, end.disc.source)
    return inputs


def fit_wear(
    corrected: CorrectedRun,
    model: LawName = "archard",
    friction: FrictionFit | None = None,
    recipe: Recipe | None = None,
) -> WearFit:
    """Identify k_D, m²/N, of one run under a wear law.

    Sarkar's law takes μ from ``friction`` (Eq. 7), or from the measured curve where the recipe says so. A run that
    lacks depth, end value or friction passes through, and the result says what it lacks.

    Raises ``FitError`` where the depth shows no wear to fit.
    """
    recipe = recipe or Recipe()
    problem = wear_problem(corrected, model, friction, recipe)
    if not isinstance(problem, WearProblem):
        return WearFit(model=model, outcome="not fitted", lacks=problem)
    if len(problem.distance) < _FEWEST_SAMPLES:
        raise FitError(
            f"{corrected.id}: found {len(problem.distance)} samples of depth; expected at least "
            f"{_FEWEST_SAMPLES}; record at a higher rate"
        )
    coefficient = problem.solve(problem.values)
    source: FrictionSource | None = None
    if LAWS[model].needs_friction:
        source = "fitted" if isinstance(problem.friction, ExponentialFriction) else "measured"
    notes = friction.notes if friction and source == "measured" and recipe.wear.friction == "fitted" else ()
    return _assess(problem, coefficient, model).model_copy(
        update={"friction": source, "notes": (*_doubts(corrected), *default_notes(problem.inputs), *notes)}
    )


def _doubts(corrected: CorrectedRun) -> tuple[str, ...]:
    """Say where the depth signal itself is in doubt."""
    correction = corrected.correction
    if correction.within_sensor_resolution is not False or correction.discrepancy is None:
        return ()
    return (
        f"sensor and end value differ by {correction.discrepancy.shown('um')}, more than the sensor's resolution: the "
        "shape of the wear curve is in doubt",
    )


def _assess(problem: WearProblem, coefficient: float, model: LawName) -> WearFit:
    values = problem.values
    residuals = problem.pin_wear(values) - problem.depth(coefficient, values)
    slope = problem.slope(coefficient, values)
    random = math.sqrt(inflation(residuals, 1) / float(slope @ slope))
    budget = _budget(problem, coefficient, random)
    relative = math.hypot(*(line.relative for line in budget))
    factor = math.exp(COVERAGE_FACTOR * relative)
    fitted = problem.depth(coefficient, values)[-1]
    return WearFit(
        model=model,
        outcome="fitted",
        wear_coefficient=Quantity(value=coefficient, unit="m^2/N", standard_uncertainty=coefficient * relative),
        interval=(_coefficient(coefficient / factor), _coefficient(coefficient * factor)),
        random_uncertainty=_coefficient(coefficient * random),
        budget=budget,
        measured_end_depth=problem.end.pin_depth,
        fitted_end_depth=Quantity(value=float(fitted), unit="m", standard_uncertainty=float(slope[-1]) * relative),
        residual_deviation=Quantity(value=float(np.std(residuals)), unit="m"),
        effective_samples=effective_samples(residuals),
    )


def _coefficient(value: float) -> Quantity:
    return Quantity(value=value, unit="m^2/N")


def _budget(problem: WearProblem, coefficient: float, random: float) -> tuple[Contribution, ...]:
    lines = [Contribution(name="residuals of the fit", source="fit", relative=random)]
    lines += _friction_line(problem, coefficient)
    lines += [
        Contribution(
            name=name.replace("_", " "),
            value=given.quantity,
            shown_in=_SHOWN_UNITS.get(name),
            source=given.source,
            relative=problem.sensitivity(name, coefficient) * given.spread,
        )
        for name, given in problem.inputs.items()
        if name not in _FRICTION_INPUTS
    ]
    return tuple(sorted(lines, key=lambda line: -abs(line.relative)))


def _friction_line(problem: WearProblem, coefficient: float) -> list[Contribution]:
    """Combine A, b and c by their covariance: they are far from independent (JCGM 100:2008, 5.2.2)."""
    if problem.friction_covariance is None:
        return []
    slopes = np.array([problem.sensitivity(name, coefficient) for name in _FRICTION_INPUTS])
    variance = float(slopes @ np.array(problem.friction_covariance) @ slopes)
    return [Contribution(name="friction fit", source="fit", relative=math.sqrt(max(0.0, variance)))]


def default_notes(inputs: Mapping[str, Input]) -> tuple[str, ...]:
    """Name the inputs whose uncertainty is a default, in one sentence; nothing where all were stated."""
    named = [
        f"{name.replace('_', ' ')} {given.quantity.shown(_SHOWN_UNITS.get(name))}"
        for name, given in inputs.items()
        if given.source == "default"
    ]
    return (f"default uncertainty used for {', '.join(named)}",) if named else ()
