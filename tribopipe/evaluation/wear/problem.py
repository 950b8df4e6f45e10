"""The wear of one run as a question: which k_D makes the model follow what was measured.

The model depth is h(v) of the pin's curve, by the GIWM or by local wear, with v = k_D·F_N·S(s). k_D is found by
weighted least squares on rows of measured and modeled depth, for any values of the other inputs, or for thousands of
draws of them at once. What is fitted linearly with k_D (zero offsets and drift of a joint fit) is projected out of
all rows.
"""

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from typing import Any, Self, TypeVar

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from tribopipe.base.arrays import Column, Numbers, Values
from tribopipe.base.errors import FitError
from tribopipe.contacts.kinds import sensed_wear
from tribopipe.documents.contact import Contact
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import LawName, Recipe
from tribopipe.evaluation.depth_reading import engine_of, remountings, sensor_scale
from tribopipe.evaluation.drift import SensorTrace, read_trace
from tribopipe.evaluation.load_and_friction import load_course
from tribopipe.evaluation.measurements.end_wear import EndWear
from tribopipe.evaluation.measurements.kinds import beside_unseen_groove, end_wear, groove_alone
from tribopipe.evaluation.measurements.readings import EndValueUsed, SignalDepths
from tribopipe.evaluation.measurements.worn_tip import WornTip
from tribopipe.evaluation.unmeasured_groove import is_shown
from tribopipe.evaluation.wear.inputs import (
    FRICTION_INPUTS,
    FrictionCovariance,
    contact_inputs,
    distance_scale,
    friction_along,
    indistinct,
    instrument_inputs,
    law_friction,
    law_inputs,
    per_draw,
)
from tribopipe.physics.autocorrelation import inflation, left_of
from tribopipe.physics.calculation_methods import WearEngine
from tribopipe.physics.friction_path import FrictionPath
from tribopipe.physics.laws import WearLaw, law_named
from tribopipe.physics.load_course import LoadCourse, effective_distance
from tribopipe.physics.pin_on_disc import PinContact
from tribopipe.physics.pin_on_track import depth_growth, flat_volume_growth, volume_growth
from tribopipe.results.evaluation import FrictionFit
from tribopipe.results.input_quantities import Input, best_values
from tribopipe.results.run import CorrectedRun, RawRun
from tribopipe.results.wear_fit import NO_FRICTION

_MOST_ITERATIONS = 60
_CONVERGED = 1e-12
_LEAST_STEP = 1e-300
_LEAST_RATIO = -0.5
"""Depth of a groove over that of the pin below which a draw of it is not taken: none is so far above the disc."""
_LEAST_WEAR = 1e-12
"""Depth, m, from which the search starts at least, since no k_D belongs to none."""
_LEAST_LOG_K = 14.0
"""A k_D this many e-folds below where the search starts is no wear at all."""
_STEP = 1e-4
"""Relative step of a law parameter in a difference quotient."""
NODES = 40
_FINE_NODES = 1000
_SMOOTH_TERMS = 8
"""Powers of √s that, together with drift, take the wear out of a reading so that its noise is left."""
_LEAST_NOISE = 1e-12
"""Standard deviation, m, below which a reading counts as without noise."""
PRESSURE = "pressure_distribution"
"""Input: volume at a depth by the true contact pressure over that by the engine's."""
_TRIANGULAR = math.sqrt(6)
"""Width of a triangular distribution that is highest at one end, over its root mean square about that end."""
_NEGLIGIBLE = 1e-3
"""Relative uncertainty of k_D by the contact pressure that is left out."""
_TURNS = 4
"""Turns in which a distance and the factor of a growing groove, which changes slowly with it, are found."""


@dataclass(frozen=True)
class Tangent:
    """The parameters of a law that are free, by first-order propagation about the best estimate."""

    names: tuple[str, ...]
    coefficient: float
    """k_D there, m²/N."""


@dataclass(frozen=True)
class WearProblem:
    """One run corrected in two steps: drift first, by the post-test measurement, then k_D on the corrected pin wear."""

    contact: Contact
    law: WearLaw
    distance: Column
    trace: SensorTrace
    end: EndWear
    friction: FrictionPath | None
    inputs: Mapping[str, Input]
    engine: WearEngine = "giwm"
    friction_covariance: FrictionCovariance = None
    """Covariance of (A, b, c), if friction is from Eq. 7."""
    load: LoadCourse | None = None
    """Load along the test; None where it counts as constant."""
    weights: Column = field(default_factory=lambda: np.ones(1))
    """Number of samples behind each row of the curve."""
    noise: float = _LEAST_NOISE**2
    """Variance of the sensor's noise times its autocorrelation time, m²."""
    tangent: Tangent | None = None
    """Tangent for the law parameters that are fitted with k_D."""
    missed: float = 0.0
    """Standard deviation, m, of what the law, fitted to this run, misses of each row beyond that noise."""

    @cached_property
    def values(self) -> dict[str, float]:
        """Best estimates of the inputs."""
        return best_values(self.inputs)

    def pin(self, values: Values) -> PinContact:
        """Return the pin's depth against worn volume."""
        return sensed_wear(self.contact, self.engine).pin(values)

    def pin_wear(self, values: Values) -> Column:
        """Return the corrected wear of the pin, m: the sensor's wear times the pin's share by measurement."""
        pin = self.end_depth(values)
        total = pin + values.get("disc_end_value", 0.0)
        wear = self.trace.wear(total, values["zero_offset"], values["end_reading"], values["depth_scale"])
        return np.asarray(wear * np.divide(pin, total, out=np.ones_like(total), where=total != 0))

    def end_depth(self, values: Values) -> Column:
        """Return the pin's wear depth by its post-test measurement, m."""
        return self.end.pin_depth_of(values["pin_end_value"], values["pin_radius"])

    def effective_distance(self, values: Values, distance: Column | None = None) -> Column:
        """Return S(s) of the law, m, scaled by what the distance is derived from over its best estimate."""
        friction = friction_along(self.friction, values, self.values)
        places = self.distance if distance is None else distance
        effective = effective_distance(self.law.at(values), places, friction, self.load)
        return np.asarray(effective * distance_scale(values, self.values))

    def depth(self, coefficient: Numbers, values: Values, distance: Column | None = None) -> Column:
        """Return the model's wear depth, m, for a k_D in m²/N; at the samples by default."""
        deep = self.pin(values).worn(coefficient * self.unit_volume(values, distance)).depth
        return deep * self._grown(self.distance if distance is None else distance)

    def volume(self, depth: Column, values: Values, distance: Column) -> Column:
        """Return the volume, m³, that the pin has lost at these depths, m, after these distances, m."""
        return self.pin(values).volume(depth / self._grown(distance)) * self._on_plane(values)

    def effective_to(self, depth: float, coefficient: Column, values: Values) -> Column:
        """Return the effective distance, m, after which the pin is worn by a depth, m, for a k_D in m²/N."""
        pin, per_volume = self.pin(values), self._on_plane(values) / (coefficient * values["normal_load"])
        reached = np.asarray(pin.volume(depth) * per_volume)
        for _ in range(_TURNS):
            reached = np.asarray(pin.volume(depth / self._grown_after(reached)) * per_volume)
        return reached

    def unit_volume(self, values: Values, distance: Column | None = None) -> Column:
        """Return the volume worn at k_D = 1, F_N·S(s), as that of a pin on a disc that does not wear."""
        return values["normal_load"] * self.effective_distance(values, distance) / self._on_plane(values)

    def _on_plane(self, values: Values) -> Numbers:
        """Return the volume that the pin has lost over what it would have lost at this depth on an unworn disc.

        On a disc that wears the pin has lost more, and on one that nobody looked at it may have. By another
        distribution of the contact pressure it has lost less.
        """
        return self._groove_growth(values) * values.get("unseen_groove", 1.0) * values.get(PRESSURE, 1.0)

    def _groove_growth(self, values: Values) -> Numbers:
        ratio = self._depth_ratio(values)
        return self._growth_at(ratio) if np.any(ratio) else 1.0

    def _growth_at(self, ratio: Numbers) -> Column:
        """Return the volume that the pin has lost over that on a plane, for the depth of the groove over its own."""
        if self.contact.sliding_tip.constant_area:
            return flat_volume_growth(ratio)
        return np.asarray(volume_growth(ratio) * self._beyond_paraboloid)

    @cached_property
    def _beyond_paraboloid(self) -> float:
        """By what factor that of the tip is larger than that of a paraboloid: next to the same whatever the inputs."""
        ratio, depth = float(self._depth_ratio(self.values)), self.end.pin_depth.value
        tip = self.end.tip.on_track(self.end.tip.radius)
        if not depth * (1 + ratio) < float(tip.most):
            return 1.0
        beside, alone = (float(tip.at_depths(depth, groove).pin_volume) for groove in (ratio * depth, 0.0))
        return beside / alone / float(volume_growth(ratio))

    def _grown(self, distance: Column) -> Numbers:
        """Return by what factor the pin was deeper on its way, while the groove was shallower than at the end."""
        return self._grown_after(self.effective_distance(self.values, distance))

    def _grown_after(self, effective: Column) -> Numbers:
        ratio = float(self._depth_ratio(self.values))
        if not ratio or self.contact.sliding_tip.constant_area:
            return 1.0
        whole = self.effective_distance(self.values, np.asarray([self.trace.slid]))
        tip, depth = self.end.tip.on_track(self.end.tip.radius), self.end.pin_depth.value
        return depth_growth(tip, effective / whole, depth, ratio * depth)

    def _depth_ratio(self, values: Values) -> Numbers:
        """Return the depth of the groove over that of the pin where that shapes the pin, and 0 where it does not."""
        depth = self.end.pin_depth.value
        if "disc_end_value" not in values or self.contact.sliding_tip.line or not depth > 0:
            return 0.0
        # A draw of a disc that has hardly worn may be below zero, and counts as what it is, lest the mean be off.
        return np.maximum(values["disc_end_value"] / depth, _LEAST_RATIO)

    def rows(self, values: Values) -> Column:
        """Return what is measured, m."""
        return self.pin_wear(values)

    def measured(self, values: Values, coefficient: Column, noise: Numbers = 0.0) -> Column:  # noqa: ARG002
        """Return the pin's wear as the curve has it, m; here it does not depend on the run's k_D."""
        return self.pin_wear(values) + noise * np.sqrt(1 + self.missed**2 * self.weights / self.noise)

    def model(self, log_coefficient: Column, values: Values) -> tuple[Column, Column]:
        """Return each row as the model gives it, and its slope against ln k_D, m."""
        return self.modelled(values)(log_coefficient)

    def modelled(self, values: Values) -> Callable[[Column], tuple[Column, Column]]:
        """Return the model as a function of ln k_D, with all that does not depend on k_D computed once."""
        pin, unit, grown = self.pin(values), self.unit_volume(values), self._grown(self.distance)

        def model(log_coefficient: Column) -> tuple[Column, Column]:
            volume = np.exp(log_coefficient)[..., None] * unit
            state = pin.worn(volume)
            return state.depth * grown, volume / state.area * grown

        return model

    @property
    def measured_inputs(self) -> Collection[str]:
        """Names of inputs that what is measured depends on, but not the model."""
        return ("pin_end_value", "zero_offset", "end_reading", "depth_scale")

    @cached_property
    def root_weights(self) -> Column:
        """Weight of each row in the least-squares sum."""
        return np.asarray(np.sqrt(self.weights))

    @property
    def linear(self) -> Column:
        """Columns of what is fitted with k_D and the law, in weighted rows; none here."""
        return np.zeros((len(self.distance), 0))

    @property
    def fitted_parameters(self) -> tuple[str, ...]:
        """Parameters of the law that are fitted with k_D."""
        return self.tangent.names if self.tangent else ()

    @cached_property
    def law_columns(self) -> Column:
        """Columns of the law's parameters that are fitted with k_D, in weighted rows."""
        if self.tangent is None or not self.fitted_parameters:
            return self.linear[:, :0]
        log_k = np.asarray(np.log(self.tangent.coefficient))
        rows = self.law_slopes(lambda problem: problem.model(log_k, problem.values)[0])
        return (rows.T * self.root_weights).T

    @cached_property
    def free(self) -> Column:
        """Orthonormal basis of what is fitted with k_D, in weighted rows."""
        return np.linalg.qr(np.hstack([self.linear, self.law_columns]))[0]

    def without_free(self, rows: Column) -> Column:
        """Return weighted rows without what is fitted with k_D."""
        return _projected(rows, self.free)

    def friction_together(self) -> tuple[str, ...]:
        """Return the inputs that the friction fit found, which are uncertain together; empty if there is no fit."""
        return () if self.friction_covariance is None else FRICTION_INPUTS

    def draw_noise(self, rng: Generator, count: int) -> Column:
        """Draw the noise of each row, m, independent from row to row."""
        return rng.standard_normal((count, len(self.distance))) * np.sqrt(self.noise / self.weights)

    def draw_scores(self, rng: Generator, count: int) -> Column:
        """Draw what k_D is off by beyond the errors of the inputs: here the noise of each row, m."""
        return self.draw_noise(rng, count)

    def solve(self, values: Values, noise: Column | float = 0.0, tolerance: float = _CONVERGED) -> Column:
        """Return the least-squares k_D, m²/N, by Gauss–Newton on ln k_D; 0 where no wear fits best, else NaN.

        Values of shape (draws, 1), and ``noise`` on each row of them, give as many solutions at once. The search
        starts at the k_D that meets the post-test measurement.
        """
        root, free, model = self.root_weights, self.free, self.modelled(values)
        measured = self.rows(values) + noise
        log_k, lowest, highest = self._search_range(values)
        change = left = np.full_like(log_k, np.inf)
        for _ in range(_MOST_ITERATIONS):
            depth, slope = model(log_k)
            residual, slope = _projected((measured - depth) * root, free), _projected(slope * root, free)
            step = np.clip(np.vecdot(residual, slope) / np.vecdot(slope, slope), -1.0, 1.0)
            moved = np.clip(log_k + step, lowest, highest)
            before, change, log_k = change, np.abs(moved - log_k), moved
            # Steps shrink at least as fast from now on as they just did.
            left = change * np.where(before < np.inf, np.minimum(change / np.maximum(before, _LEAST_STEP), 1.0), 1.0)
            if np.all(left < tolerance):
                break
        found = np.where(log_k <= lowest, 0.0, np.exp(log_k))
        return np.where(left < tolerance, found, np.nan)

    def _search_range(self, values: Values) -> tuple[Column, Column, Column]:
        pin, unit = self.pin(values), self.unit_volume(values)[..., -1]
        least = max(1e-3 * abs(float(self.end_depth(self.values))), _LEAST_WEAR)
        worn = np.maximum(self.starting_depth(values), least)
        start = np.log(per_draw(pin.volume(worn)) / unit)
        return start, start - _LEAST_LOG_K, np.log(per_draw(pin.most_volume) / unit) - 1e-12

    def starting_depth(self, values: Values) -> Column:
        """Return the depth at the end from which the search for k_D starts, m: here the curve is bent to it."""
        return self.end_depth(values)

    def coefficient(self) -> float:
        """Return k_D, m²/N, at the best estimates. Raises ``FitError`` where the pin shows no wear."""
        if not float(self.end_depth(self.values)) > 0:
            raise FitError(
                "wear fit: found a post-test measurement that shows no wear of the pin; expected a positive value; "
                "run a longer test, or use a higher load"
            )
        found = float(self.solve(self.values))
        if not found > 0:
            if self.fitted_parameters:
                raise FitError(indistinct(self.law, self.fitted_parameters))
            raise FitError(
                f"wear fit: found no k_D in {_MOST_ITERATIONS} iterations; expected the depth to increase with "
                "distance; inspect the raw depth signal"
            )
        return found

    def sensitivity(self, name: str, coefficient: float) -> float:
        """Return ∂ln k_D/∂x for one input."""
        return self.sensitivities(coefficient, (name,))[name]

    def sensitivities(self, coefficient: float, names: Sequence[str]) -> dict[str, float]:
        """Return ∂ln k_D/∂x for inputs, by central differences over their standard uncertainties."""
        uncertain = [name for name in names if self.inputs[name].spread]
        slope = self.without_free(self.model(np.asarray(np.log(coefficient)), self.values)[1] * self.root_weights)
        by_spread = (self.shifts(uncertain, coefficient) * self.root_weights) @ slope / np.vecdot(slope, slope)
        found = {name: float(by) / self.inputs[name].spread for name, by in zip(uncertain, by_spread, strict=True)}
        return dict.fromkeys(names, 0.0) | found

    def shifts(self, names: Sequence[str], coefficient: float) -> Column:
        """Return how far each row is measured above the model, m, for one standard uncertainty of each input."""
        modelled = [name for name in names if name not in self.measured_inputs]
        low, high = np.split(self.rows(self.moved(names)), 2)
        change = high - low
        log_k = np.full(2 * len(modelled), np.log(coefficient))
        low, high = np.split(self.model(log_k, self.moved(modelled))[0], 2)
        change[[names.index(name) for name in modelled]] -= high - low
        return np.asarray(change / 2)

    def moved(self, names: Sequence[str]) -> dict[str, Column]:
        """Return the inputs as columns: in a row for each name it is one standard uncertainty low, and then high."""
        values = {name: np.full((2 * len(names), 1), value) for name, value in self.values.items()}
        for row, name in enumerate(names):
            values[name][[row, row + len(names)], 0] += np.array([-1.0, 1.0]) * self.inputs[name].spread
        return values

    def parameter_covariance(self, coefficient: float) -> Column | None:
        """Return the covariance of ln k_D and the law's own parameters; None if it has none that are fitted."""
        return self.condensed().law_covariance(coefficient) if self.fitted_parameters else None

    def law_slopes(self, rows_of: "Callable[[WearProblem], Column]") -> Column:
        """Return how each row of the model moves with the parameters of its law that are free: rows by parameters."""
        return np.stack([self.law_slope(name, rows_of) for name in self.fitted_parameters], axis=-1)

    def law_slope(self, name: str, rows_of: "Callable[[WearProblem], Column]") -> Column:
        """Return how each row of the model moves with one parameter of its law."""
        law, value, known = self.law, self.law.values()[name], self.law.parameters()[name]
        step = _STEP * law.scale_of(name, value)
        low, high = max(value - step, known.low), min(value + step, known.high)
        rows = [rows_of(replace(self, law=replace(law, **{name: near}), tangent=None)) for near in (low, high)]
        return np.asarray((rows[1] - rows[0]) / (high - low))

    def law_covariance(self, coefficient: float) -> Column:
        """Return the covariance of ln k_D and the free parameters, SI, by first-order propagation (JCGM 100:2008, 5.2).

        Of the noise of the reading and of every input, those of the friction fit by their own covariance.
        """
        _, slope = self.model(np.log(coefficient), self.values)
        design = np.column_stack([slope * self.root_weights, self.law_columns, self.linear])
        length = np.linalg.norm(design, axis=0)
        pull = (np.linalg.pinv(design / length) / length[:, None])[: 1 + self.law_columns.shape[1]]
        samples = len(self.distance)
        noisy = pull[:, :samples] * self.root_weights[:samples] * np.sqrt(self.noise / self.weights)
        names = [name for name in self.inputs if self.inputs[name].spread]
        moved = dict(zip(names, self.shifts(names, coefficient) * self.root_weights @ pull.T, strict=True))
        together = self.friction_together()
        alone = [shift for name, shift in moved.items() if name not in together]
        found = noisy @ noisy.T + sum((np.outer(shift, shift) for shift in alone), np.zeros((len(pull), len(pull))))
        if together:
            per_unit = np.column_stack([moved[name] / self.inputs[name].spread for name in together])
            found = found + per_unit @ np.asarray(self.friction_covariance) @ per_unit.T
        return np.asarray(found)

    @property
    def measured_end_depth(self) -> Quantity | None:
        """Pin wear depth at the end as measured, m."""
        return self.end.pin_depth

    def random_uncertainty(self, coefficient: float) -> float:
        """Return the standard uncertainty of ln k_D by the noise of the curve alone."""
        _, slope = self.model(np.log(coefficient), self.values)
        slope = _projected(slope * self.root_weights, self.free)
        weighted = (slope * self.root_weights)[: len(self.distance)] * np.sqrt(self.noise / self.weights)
        return math.sqrt(float(weighted @ weighted)) / float(slope @ slope)

    def stretches(self, nodes: int) -> NDArray[np.intp]:
        """Return the numbers of the stretches into which samples are pooled, evenly spaced in the wear to come."""
        wear = self._to_come
        return np.asarray(np.minimum((wear / wear[-1] * nodes).astype(int), nodes - 1))

    @property
    def _power(self) -> float:
        """Exponent n of depth ∝ sⁿ."""
        return self.contact.sliding_tip.depth_exponent

    @property
    def _to_come(self) -> Column:
        return np.asarray(np.maximum(self.distance, 0.0) ** self._power)

    def pooled(self) -> Self:
        """Return the same problem on pooled samples, with what the law misses of this run."""
        reduced = self.reduced()
        missed = reduced.rows(reduced.values) - reduced.depth(reduced.coefficient(), reduced.values)
        excess = np.average(missed**2 - reduced.noise / reduced.weights, weights=reduced.weights)
        return replace(reduced, missed=math.sqrt(max(0.0, float(excess))))

    def condensed(self) -> Self:
        """Return the problem for what is smooth along it: on stretches so short that it hardly changes."""
        return self.reduced(_FINE_NODES) if len(self.distance) > 2 * _FINE_NODES else self

    def reduced(self, nodes: int = NODES) -> Self:
        """Return the same problem on means over stretches of samples; each stands at the mean of √s, or of s."""
        place = self.stretches(nodes)
        counts = np.bincount(place)
        filled = counts > 0

        def mean(column: Column) -> Column:
            return np.bincount(place, column)[filled] / counts[filled]

        trace = replace(self.trace, reading=mean(self.trace.reading), ramp=mean(self.trace.ramp))
        return replace(
            self, distance=mean(self._to_come) ** (1 / self._power), trace=trace, weights=counts[filled].astype(float)
        )


P = TypeVar("P", bound=WearProblem)


def posed_as(problem: WearProblem, kind: type[P], **changes: Any) -> P:
    """Return a problem as one of another kind, with some fields changed and those that only this kind has."""
    return kind(**{one.name: getattr(problem, one.name) for one in fields(WearProblem)} | changes)


def _projected(rows: Column, free: Column) -> Column:
    """Return rows with their projection on the orthonormal columns of ``free`` subtracted."""
    return rows - (rows @ free) @ free.T if free.shape[1] else rows


def wear_problem(
    corrected: CorrectedRun, law: LawName, friction: FrictionFit | None, recipe: Recipe
) -> WearProblem | tuple[str, ...]:
    """Pose the fit of k_D to a corrected run under a law as it is to start, or report what is missing for it."""
    run, manifest = corrected.run, corrected.run.manifest
    if corrected.wear_depth is None:
        return corrected.correction.missing
    measured = end_wear(run, recipe.uncertainty, approach=corrected.correction.approach)
    end = measured or end_by_reading(corrected, recipe)
    if end is None:
        return corrected.correction.missing
    if measured is None and end.disc is not None and not is_shown(end.pin_depth, end.disc.quantity):
        return (
            "a post-test measurement of the pin, since subtracting the wear depth of the disc, "
            f"{end.disc.quantity.shown('um')}, from the depth signal leaves only {end.pin_depth.shown('um')}",
        )
    known = law_friction(run, law, friction, recipe.wear.friction)
    if known is None:
        return (NO_FRICTION,)
    inputs = contact_inputs(run, recipe)
    inputs |= instrument_inputs(run, recipe)
    inputs |= known.inputs
    trace = _seen(read_trace(run, end, recipe), seen := np.isfinite(corrected.wear_depth))
    inputs |= _trace_inputs(trace, end)
    inputs |= unseen_groove_input(run, end, recipe, by_sensor=measured is None)
    engine = engine_of(manifest.described.sliding_tip, measured, recipe)
    inputs |= _pressure_distribution(manifest.described, best_values(inputs), end, engine)
    inputs |= law_inputs(law_named(law), recipe)
    return WearProblem(
        contact=manifest.described,
        law=law_named(law),
        distance=run.sliding_distance[seen],
        trace=trace,
        end=end,
        friction=known.path,
        inputs=inputs,
        engine=engine,
        friction_covariance=known.covariance,
        load=load_course(run),
        noise=_sensor_noise(trace, run.sliding_distance[seen], remountings(manifest, run.sliding_distance[seen])),
    )


def end_by_reading(corrected: CorrectedRun, recipe: Recipe) -> EndWear | None:
    """Return the wear at the end as the depth reading itself has it, where the pin was not measured after the test."""
    model = corrected.correction.model
    if model is None:
        return None
    tip = WornTip.of(corrected.run.manifest.described.equivalent_pin)
    groove, scale = groove_alone(corrected.run, recipe.uncertainty), sensor_scale(corrected.run, recipe)
    # The groove is taken from what the sensor has read, so that an error of its scale is one of the sum.
    both = model.end_depth.value + (groove.quantity.value if groove else 0.0)
    by_scale = both * scale.u_or_zero / scale.value if groove else 0.0
    spread = math.hypot(model.end_depth.u_or_zero, by_scale)
    # What is worn is above zero; a reading that tells none still bounds it.
    read = Quantity(value=max(model.end_depth.value, spread), unit="m", standard_uncertainty=spread)
    return EndWear(EndValueUsed("pin_wear_depth", read, "manifest"), groove, tip)


def depths_by_signal(corrected: CorrectedRun, recipe: Recipe) -> SignalDepths:
    """Return which depths of pin and disc only the depth signal gives, since they were not measured after the test."""
    both = corrected.correction.approach
    if corrected.run.manifest.pin is None or end_wear(corrected.run, recipe.uncertainty) is not None:
        return SignalDepths(both=both)
    read = end_by_reading(corrected, recipe)
    if read is None:
        return SignalDepths()
    certain = read.disc is not None and is_shown(read.pin_depth, read.disc.quantity)
    return SignalDepths(read.pin_depth, pin_is_certain=certain)


def unseen_groove_input(run: RawRun, end: EndWear, recipe: Recipe, *, by_sensor: bool) -> dict[str, Input]:
    """Return by what factor the pin may have lost more than it would have on a disc without a groove."""
    beside = beside_unseen_groove(run, end, recipe.uncertainty.unseen_groove, by_sensor=by_sensor)
    factor = Quantity(value=1.0, unit="1", standard_uncertainty=abs(beside - 1))
    return {"unseen_groove": Input(factor, "default", above_zero=True)} if factor.standard_uncertainty else {}


def _pressure_distribution(contact: Contact, values: Values, end: EndWear, engine: WearEngine) -> dict[str, Input]:
    """Return by what factor the pin may have lost more at its depth than by the engine's contact pressure.

    That pressure is the most probable one, local pressure the limit: a triangular distribution. Nothing where local
    pressure changes nothing, or is not known: flat pins and truncated spheres.
    """
    depth = end.pin_depth.value
    if engine == "local" or contact.sliding_tip.shape != "spherical" or not depth > 0:
        return {}
    local, other = (sensed_wear(contact, by).pin(values).volume(depth) for by in ("local", engine))
    spread = abs(float(local / other) - 1) / _TRIANGULAR
    if spread < _NEGLIGIBLE:
        return {}
    return {PRESSURE: Input(Quantity(value=1.0, unit="1", standard_uncertainty=spread), "default", above_zero=True)}


def _sensor_noise(trace: SensorTrace, distance: Column, segments: Column) -> float:
    """Return the variance of the reading times its autocorrelation time about a smooth curve, m²."""
    return max(inflation(*about_smooth(trace, distance, segments)), _LEAST_NOISE**2)


def about_smooth(
    trace: SensorTrace, distance: Column, segments: Column, terms: int = _SMOOTH_TERMS
) -> tuple[Column, int]:
    """Return what a reading differs from a smooth curve by, m, and how many parameters the curve has.

    Not from the law: what a law or a wrong post-test measurement misses is smooth, not noise, and counted separately.
    """
    root = np.sqrt(np.maximum(distance, 0.0) / distance[-1])
    # Chebyshev's polynomials of √s rather than its powers, which are nearly alike; the first of them is an offset.
    curves = np.polynomial.chebyshev.chebvander(2 * root - 1, terms + 1).T
    curves[-1] = trace.ramp
    further = np.unique(segments)[1:]
    if len(further):
        curves = np.vstack([curves, np.equal.outer(further, segments)])
    return left_of(trace.reading, curves)


def _seen(trace: SensorTrace, seen: Column) -> SensorTrace:
    return replace(trace, reading=trace.reading[seen], ramp=trace.ramp[seen])


def _trace_inputs(trace: SensorTrace, end: EndWear) -> dict[str, Input]:
    inputs = {
        "pin_end_value": Input(end.pin.quantity, end.pin.source),
        "zero_offset": Input(trace.zero_offset, "fit"),
        "end_reading": Input(trace.end_reading, "fit"),
    }
    if end.disc is not None:
        inputs["disc_end_value"] = Input(end.disc.quantity, end.disc.source)
    return inputs
