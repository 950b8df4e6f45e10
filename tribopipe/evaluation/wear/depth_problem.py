"""k_D of one run by its whole depth reading and the post-test measurement together.

The wear depth H at the end has a posterior (tribopipe.physics.depth_model). For any values of the inputs it is one k_D,

    k_D = V(H)/(F_N·S(s_end)),

with V the pin's volume at a depth and S the law's effective distance: nothing is fitted for a draw. Where the depth
reading alone and the measurement alone differ by more than three standard uncertainties of their difference, inputs
that both share counted once, the reading is not trusted and the measurement alone gives k_D.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from statistics import NormalDist
from typing import Self

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from tribopipe.base.arrays import Column, Numbers, Values
from tribopipe.base.errors import FitError
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import Recipe
from tribopipe.evaluation.depth_reading import DECISIVE, MOST_DEVIATION, DepthRecord, depth_record, pin_reading
from tribopipe.evaluation.wear.drift_and_wear import END_ANCHOR, interruption_anchor, joint_problem
from tribopipe.evaluation.wear.inputs import draw_values
from tribopipe.evaluation.wear.problem import PRESSURE, Tangent, WearProblem, posed_as
from tribopipe.physics.depth_model.block_averages import DepthSamples
from tribopipe.physics.depth_model.posterior import DepthPosterior, DepthReading, depth_posterior
from tribopipe.physics.laws import LawParameter
from tribopipe.results.run import CorrectedRun, RawRun
from tribopipe.results.wear_fit import Basis

_COMPARED = 4_000
"""Draws by which they are compared."""
_SEED = 1
_LEAST_SHARE = 0.5
"""Wear assumed for a measurement that shows no wear, as a share of its standard uncertainty."""
_COURSE_IS_KNOWN = 0.02
"""Share of the wear depth by which the course between measurements may differ from a law that holds."""
_MOST_PASSES = 8
_NEARLY = 0.1
"""Change of a parameter of the law, in its standard uncertainty, after which it is found again."""
_MOST_OF_THE_ROOM = 0.9
_LEAST_DEPTH = 1e-12
"""m."""
_STEP = 1e-3
"""Relative step of a depth in a difference quotient."""
_QUANTILES = (np.arange(1000) + 0.5) / 1000


@dataclass(frozen=True)
class DepthProblem(WearProblem):
    """One run with wear and everything else that its depth sensor reads in one model."""

    record: DepthRecord = field(kw_only=True)
    run: RawRun = field(kw_only=True)
    recipe: Recipe = field(kw_only=True)
    measured_after: bool = True
    """Whether wear was measured after the test; otherwise ``end`` is what the reading itself gives."""
    missed: float = 1.0
    """Share of the wander that counts as noise of the curve."""
    given_basis: Basis | None = None
    """Source of k_D; None for that which deviation and interruptions suggest."""

    @property
    def samples(self) -> DepthSamples:
        """The depth reading sample by sample."""
        return self.record.samples

    @cached_property
    def reading(self) -> DepthReading:
        """Block averages of the reading, with what is known of them."""
        values, slid = self.values, np.asarray([self.trace.slid])
        whole = float(self.effective_distance(values, slid)[0])
        return pin_reading(
            self.run,
            self.samples,
            self.end if self.measured_after else None,
            self.recipe,
            pin=self.pin(values),
            share=lambda distance: self.effective_distance(values, distance) / whole,
            free=self._law_terms,
        )

    @property
    def _law_terms(self) -> Column | None:
        """How the wear at each block changes with the law's own parameters at a given depth at the end."""
        if self.tangent is None or not self.fitted_parameters:
            return None
        nodes, coefficient = self.samples.nodes, self.tangent.coefficient
        places = np.append(nodes.distance, self.trace.slid)
        columns = self.law_slopes(lambda moved: moved.depth(coefficient, moved.values, places))
        volume = coefficient * self.unit_volume(self.values, places)
        slope = volume / self.pin(self.values).worn(volume).area
        fixed = columns - np.outer(slope / slope[-1], columns[-1])
        return nodes.averaged(fixed[:-1].T).T

    @cached_property
    def posterior(self) -> DepthPosterior:
        """Posterior from the depth signal and the post-test measurement."""
        return depth_posterior(self.reading)

    def with_law_of_the_reading(self) -> Self:
        """Return the problem with the law's own parameters as the whole model has them.

        What is fitted with noise taken for white follows wander and drift, and its error is not that of the model.
        """
        problem, share, last = self, 1.0, np.zeros(len(self.fitted_parameters))
        for _ in range(_MOST_PASSES if self.fitted_parameters else 0):
            change, spread = (terms[problem._law_places] for terms in problem.posterior.terms)
            if float(np.sum(change * last / spread**2)) < 0:  # the last step went too far
                share *= 0.5
            problem, last = problem._with_law_moved(share * change), change
            if np.all(np.abs(change) < _NEARLY * spread):
                break
        return problem

    def without_excluded_pressure(self) -> Self:
        """Return the problem without doubt about the contact pressure where the reading's shape excludes the local one.

        Where the reading contradicts the measurement, its shape excludes nothing.
        """
        if PRESSURE not in self.inputs or self.basis == "measurement" or self.evidence_of_local_pressure > -DECISIVE:
            return self
        return replace(self, inputs={name: known for name, known in self.inputs.items() if name != PRESSURE})

    @cached_property
    def by_local_pressure(self) -> Self:
        """The same fit with local contact pressure."""
        return replace(self, engine="local")

    @property
    def evidence_of_local_pressure(self) -> float:
        """Evidence, as a logarithm of odds, that the reading has the shape of local contact pressure."""
        return self.by_local_pressure.posterior.log_evidence - self.posterior.log_evidence

    @property
    def _law_places(self) -> NDArray[np.intp]:
        """Terms of the depth signal that are law parameters."""
        first = self.reading.offsets.shape[1]
        return np.arange(first, first + len(self.fitted_parameters))

    def _with_law_moved(self, change: Column) -> Self:
        known, values = self.law.parameters(), self.law.values()
        moved = dict(zip(self.fitted_parameters, change.tolist(), strict=True))
        found = {name: _within(known[name], values[name], step) for name, step in moved.items()}
        problem = replace(self, law=replace(self.law, **found))
        return replace(problem, tangent=Tangent(self.fitted_parameters, problem.coefficient()))

    @cached_property
    def _together(self) -> tuple[float, float]:
        """H, m, and its standard uncertainty at the best estimates of the inputs, by what is trusted."""
        if self.basis == "measurement":
            return max(self.end.pin_depth.value, _LEAST_SHARE * self._measured_spread), self._measured_spread
        return self._moments(self.posterior)

    def _moments(self, posterior: DepthPosterior) -> tuple[float, float]:
        """Return H, m, and its standard uncertainty at the best estimates of the inputs, by a posterior."""
        drawn = posterior.end_depths(_QUANTILES, np.ones(len(_QUANTILES)), measured=self.basis != "reading")
        return float(np.mean(drawn)), float(np.std(drawn))

    @property
    def _measured_spread(self) -> float:
        return max(self.end.pin_depth.u_or_zero, 1e-15)

    @cached_property
    def basis(self) -> Basis:
        """Source of k_D."""
        if self.given_basis is not None:
            return self.given_basis
        if not self.measured_after:
            return "reading"
        trusted = abs(self.deviation) <= MOST_DEVIATION and self.contradicting_stop is None
        return "reading and measurement" if trusted else "measurement"

    @cached_property
    def contradicting_stop(self) -> tuple[float, float] | None:
        """Sliding distance, m, of the interruption whose measurement differs most from what the one at the end means.

        With the difference in standard uncertainties. None where they agree: the more interruptions, the further apart
        they may be by chance.
        """
        end, *stops = self.reading.measured or (None,)
        if end is None or not stops:
            return None
        step = np.asarray([0.0, -end.uncertainty, end.uncertainty])
        found = []
        for place, stop in zip(self._measured_stops, stops, strict=True):
            expected, low, high = stop.course(np.maximum(end.depth + step, _LEAST_SHARE * end.uncertainty))
            spread = math.hypot(stop.uncertainty, (high - low) / 2, _COURSE_IS_KNOWN * expected)
            found.append((place, float(stop.depth - expected) / spread))
        furthest = max(found, key=lambda one: abs(one[1]))
        most = NormalDist().inv_cdf(1 - NormalDist().cdf(-MOST_DEVIATION) / len(found))
        return furthest if abs(furthest[1]) > most else None

    @property
    def _measured_stops(self) -> list[float]:
        """Sliding distances of the interruptions at which the pin was measured, m."""
        stops = enumerate(self.run.manifest.interruptions, start=1)
        return [stop.place for number, stop in stops if interruption_anchor(number) in self.inputs]

    @cached_property
    def deviation(self) -> float:
        """Depth by the reading alone minus that by the measurement alone, over its standard uncertainty."""
        reading, measured = self.drawn_ways
        difference = reading - measured
        return float(np.mean(difference)) / max(float(np.std(difference)), 1e-15)

    @cached_property
    def drawn_ways(self) -> tuple[Column, Column]:
        """H by the reading alone and by the measurement alone, m, for the same draws of the inputs."""
        rng = np.random.Generator(np.random.PCG64(_SEED))
        values = draw_values(self.inputs, self.friction_covariance, rng, _COMPARED)
        return self._by_reading(values, rng.standard_normal(_COMPARED)), self._by_measurement(values)

    def coefficients_by_ways(self) -> dict[str, tuple[float, float]]:
        """Return k_D and its standard uncertainty by the reading alone and by the measurement alone, m²/N."""
        rng = np.random.Generator(np.random.PCG64(_SEED))
        values = draw_values(self.inputs, self.friction_covariance, rng, _COMPARED)
        reading, measured = self.drawn_ways
        found = {"reading": self._coefficients(reading, values)}
        if self.measured_after:
            found["measurement"] = self._coefficients(measured, values)
        return {name: (float(np.mean(drawn)), float(np.std(drawn))) for name, drawn in found.items()}

    def _by_reading(self, values: Values, scores: Column) -> Column:
        stretched = _draws(values["depth_scale"]) / self.values["depth_scale"]
        drawn = self.posterior.end_depths(_probability(scores), np.ones(len(scores)), measured=False)
        return self._stretched(drawn, stretched)

    def _stretched(self, depth: Column | float, factor: Column) -> Column:
        """Return H, m, were the scale of the sensor larger by a factor."""
        if not self._groove_alone:
            return np.asarray(factor * depth)
        return np.maximum(depth + (factor - 1) * self._per_scale, _LEAST_DEPTH)

    @cached_property
    def _per_scale(self) -> float:
        """∂H/∂ln(scale of the sensor), m, next to a groove that was measured.

        The shape of the reading shows what of a larger one is wear of the pin, and what is the groove's.
        """
        spread = (self.inputs["depth_scale"].spread or _STEP) / self.values["depth_scale"]
        scaled = (replace(self.reading, depth=(1 + by) * self.reading.depth) for by in (-spread, spread))
        low, high = (self._moments(depth_posterior(reading))[0] for reading in scaled)
        return (high - low) / (2 * spread)

    @cached_property
    def _groove_alone(self) -> float:
        """Depth of a groove that was measured where the pin was not, m."""
        return 0.0 if self.measured_after else self.values.get("disc_end_value", 0.0)

    def _by_measurement(self, values: Values) -> Column:
        """Return the depth that the measurement means, m; none below zero."""
        if not self.measured_after:
            return np.full(_COMPARED, np.nan)
        return np.maximum(_draws(self.end_depth(values)), 0.0)

    def _coefficients(self, depth: Column, values: Values) -> Column:
        """Return k_D, m²/N, for depths at the end, m, and as many values of the inputs."""
        volume = self._volume(depth[:, None], values)
        return np.asarray((volume / self.unit_volume(values, np.asarray([self.trace.slid])))[:, 0])

    def _volume(self, depth: Numbers, values: Values) -> Column:
        """Return the volume that a pin has lost at a depth, m, on a disc that does not wear, m³.

        In a groove, a pin whose depth only the sensor shows has lost the more at that depth the less deep it is.
        """
        volume = self.pin(values).volume(depth)
        if not self._groove_alone or self.contact.sliding_tip.line:
            return volume
        ratio = np.maximum(values["disc_end_value"], 0.0) / depth
        return np.asarray(volume * self._growth_at(ratio) / self._groove_growth(values))

    def coefficient(self) -> float:
        """Return k_D, m²/N, at the best estimates."""
        return float(np.exp(self._log_coefficient(self.values)))

    def coefficient_by(self, posterior: DepthPosterior) -> float:
        """Return k_D, m²/N, at the best estimates, were the posterior of the reading another one."""
        depth, _ = self._moments(posterior)
        return float(self._coefficients(np.array([depth]), self.values)[0])

    def solve(self, values: Values, noise: Column | float = 0.0, tolerance: float = 0.0) -> Column:  # noqa: ARG002
        """Return k_D, m²/N: of each draw of inputs, with its own score, the first column of ``noise``."""
        if np.ndim(noise) == 0:
            return np.asarray(np.exp(self._log_coefficient(values)))
        depth, parameters = self._drawn(values, np.asarray(noise))
        return self._coefficients(depth, {**values, **parameters})

    def _drawn(self, values: Values, noise: Column) -> tuple[Column, dict[str, Column]]:
        """Return H, m, and the law's own parameters that belong to it, for draws of the inputs and scores of each."""
        depth = self._drawn_depth(values, noise[:, 0])
        return depth, self._drawn_parameters(depth, noise) if self.fitted_parameters else {}

    def _drawn_depth(self, values: Values, scores: Column) -> Column:
        if self.basis == "measurement":
            return self._by_measurement(values)
        if self.basis == "reading":
            return self._by_reading(values, scores)
        stretched = _draws(values["depth_scale"]) / self.values["depth_scale"]
        coupled = self._coupled(values, scores)
        return np.asarray(
            stretched * self.posterior.end_depths(_probability(coupled), self._factor(values) / stretched)
        )

    def _coupled(self, values: Values, scores: Column) -> Column:
        """Return scores of H that share with the error of the measurement what H takes from it.

        By so much that measurement and H differ by as much as they do in each way, where one may follow the
        measurement and another the curve: u² = u_m² − Σ p·u_H² over all ways. That H is as uncertain as the measurement
        does not mean that both are the same.
        """
        spread = self.inputs[END_ANCHOR].spread
        if not spread:
            return scores
        deviation = self._together[1]
        share = min(1.0, (deviation**2 + self.posterior.shared_variance) / (2 * deviation * self._measured_spread))
        error = (_draws(values[END_ANCHOR]) - self.values[END_ANCHOR]) / spread
        return np.asarray(share * error + math.sqrt(1 - share**2) * scores)

    def _factor(self, values: Values) -> Column:
        """Return by what factor the measured depths are larger than with the best estimate of the pin's radius."""
        measured, best = self.end.pin.quantity.value, self.end.pin_depth.value
        if not best > 0:
            return np.ones(np.size(values["pin_radius"]))
        return np.asarray(_draws(self.end.pin_depth_of(measured, values["pin_radius"])) / best)

    def _drawn_parameters(self, depth: Column, noise: Column) -> dict[str, Column]:
        """Return draws of the law's own parameters that belong to depths at the end."""
        posterior, places = self.posterior, self._law_places
        slopes, spreads = posterior.terms_per_depth[places], posterior.terms[1][places]
        mean, deviation = posterior.together
        left = np.sqrt(np.maximum(spreads**2 - (slopes * deviation) ** 2, 0.0))
        best = self.law.values()
        return {
            self.law.input_of(name): (best[name] + slopes[place] * (depth - mean) + left[place] * noise[:, 1 + place])[
                :, None
            ]
            for place, name in enumerate(self.fitted_parameters)
        }

    @property
    def measured_end_depth(self) -> Quantity | None:
        """Pin wear depth at the end as measured, m; None if it was not."""
        return self.end.pin_depth if self.measured_after else None

    def parameter_covariance(self, coefficient: float) -> Column | None:  # noqa: ARG002
        """Return the covariance of ln k_D and the law's own parameters; None if it has none that are fitted."""
        if not self.fitted_parameters:
            return None
        rng = np.random.Generator(np.random.PCG64(_SEED))
        values = draw_values(self.inputs, self.friction_covariance, rng, _COMPARED)
        depth, drawn = self._drawn(values, self.draw_scores(rng, _COMPARED))
        coefficients = self._coefficients(depth, {**values, **drawn})
        worn = coefficients > 0
        rows = np.stack([coefficients, *(np.broadcast_to(_draws(one), worn.shape) for one in drawn.values())])[:, worn]
        return np.cov(np.vstack([np.log(rows[:1]), rows[1:]]))

    def draw_scores(self, rng: Generator, count: int) -> Column:
        """Draw what H, and the parameters of the law, are off by beyond the errors of the inputs, standard normal."""
        return rng.standard_normal((count, 1 + len(self.fitted_parameters)))

    def draw_noise(self, rng: Generator, count: int) -> Column:
        """Draw scores, and what the reading at each block is off by from noise and wander, m."""
        scores = self.draw_scores(rng, count)
        return np.hstack([scores, rng.standard_normal((count, len(self.distance))) @ self._disturbing.T])

    @cached_property
    def _disturbing(self) -> Column:
        """Root of the covariance of what the mean of the other terms leaves of noise and wander, m.

        The symmetric one: of all roots it alone is the same whatever directions are found for powers that are equal.
        """
        posterior, reading = self.posterior, self.reading
        covariance = posterior.disturbance(self.missed)
        offsets = reading.offsets.shape[1] + len(self.fitted_parameters)
        line = reading.columns[:, : offsets + 1]
        pull = np.linalg.solve(covariance, line)
        left = np.eye(len(covariance)) - line @ np.linalg.solve(line.T @ pull, pull.T)
        powers, along = np.linalg.eigh(left @ covariance @ left.T)
        return np.asarray(along * np.sqrt(np.maximum(powers, 0.0)) @ along.T)

    def measured(self, values: Values, coefficient: Column, noise: Numbers = 0.0) -> Column:
        """Return the pin's wear as the reading has it without everything else, for a k_D of the run, m."""
        reading, posterior = self.reading, self.posterior
        stretched = np.asarray(values["depth_scale"] / self.values["depth_scale"])
        end = self.depth(np.asarray(coefficient)[..., None], values, np.asarray([self.trace.slid])) / stretched
        other = reading.columns @ posterior.terms[0]
        moved = reading.columns @ posterior.terms_per_depth
        off = np.asarray(noise)[:, 1 + len(self.fitted_parameters) :] if np.ndim(noise) == 2 else 0.0
        return np.asarray(stretched * (reading.depth - other - (end - posterior.together[0]) * moved) + off)

    def pooled(self) -> Self:
        """Return the problem itself: it is posed on block averages."""
        return self

    def condensed(self) -> Self:
        """Return the problem itself: it is posed on block averages."""
        return self

    # --- to first order ---

    def _log_coefficient(self, values: Values) -> Column:
        """Return ln k_D at the depth that the inputs move H to."""
        found, deviation = self._together
        stretched = np.asarray(values["depth_scale"] / self.values["depth_scale"])
        depth = self._stretched(found, stretched)
        if self.basis == "measurement":
            depth = np.maximum(self.end_depth(values), _LEAST_SHARE * self._measured_spread)
        elif self.basis == "reading and measurement":
            measured = self.end.pin_depth_of(self.end.pin.quantity.value, values["pin_radius"])
            taken = min(1.0, (deviation / self._measured_spread) ** 2)
            depth = stretched * (found + taken * (measured / stretched - self.end.pin_depth.value))
        volume = self._volume(depth, values)
        unit = self.unit_volume(values, np.asarray([self.trace.slid]))
        return np.asarray(np.log(volume / (unit[..., 0] if np.ndim(volume) == 0 else unit)))

    @cached_property
    def _per_depth(self) -> float:
        """∂ln k_D/∂H, 1/m."""
        if not self._groove_alone:
            pin = self.pin(self.values)
            volume = float(np.asarray(pin.volume(self._together[0])))
            return float(np.asarray(pin.worn(volume).area)) / volume
        low, high = (float(np.log(self._volume(self._together[0] * by, self.values))) for by in (1 - _STEP, 1 + _STEP))
        return (high - low) / (2 * _STEP * self._together[0])

    def sensitivities(self, coefficient: float, names: Sequence[str]) -> dict[str, float]:  # noqa: ARG002
        """Return ∂ln k_D/∂x for inputs, by central differences over their standard uncertainties."""
        own = self._measured_contributions()
        plain = [name for name in names if self.inputs[name].spread and name not in own]
        low, high = np.split(self._log_coefficient(self.moved(plain)), 2) if plain else (np.empty(0), np.empty(0))
        by_spread = dict(zip(plain, np.ravel(high - low) / 2, strict=True)) | own
        found = {name: float(by) / self.inputs[name].spread for name, by in by_spread.items() if name in names}
        return dict.fromkeys(names, 0.0) | found

    def _measured_contributions(self) -> dict[str, float]:
        """Return what errors of each measurement, one standard uncertainty large, do to ln k_D."""
        if self.basis == "measurement":
            plain = {END_ANCHOR: self._measured_spread * self._per_depth}
            return plain | {name: 0.0 for name in self.inputs if name.startswith("pin_value_at")}
        variance, found = self._together[1] ** 2, {}
        names = [name for name in self.inputs if name == END_ANCHOR or name.startswith("pin_value_at")]
        for name, one in zip(names, self.reading.measured, strict=False):
            step = 1e-3 * self._together[0]
            low, high = one.course(np.asarray([self._together[0] - step, self._together[0] + step]))
            found[name] = variance * (high - low) / (2 * step) / one.uncertainty * self._per_depth
        if self.reading.known and "disc_end_value" in self.inputs and self.inputs["disc_end_value"].spread:
            low, high = np.ravel(self._log_coefficient(self.moved(["disc_end_value"])))
            by_depth = self._with_groove / self.inputs["disc_end_value"].spread * self._per_depth
            found["disc_end_value"] = by_depth + float(high - low) / 2
        return {name: by for name, by in found.items() if self.inputs[name].spread}

    @property
    def _with_groove(self) -> float:
        """Covariance of H and the groove of the reading, m²."""
        return float(self.posterior.terms_per_depth[self.posterior.first_known] * self.posterior.together[1] ** 2)

    @property
    def by_unseen_groove(self) -> float:
        """Relative standard uncertainty of k_D by a groove that nobody measured; 0 where one was, or matters not."""
        if "unseen_groove" in self.inputs:
            return self.inputs["unseen_groove"].spread
        if self.end.disc is not None or not self.reading.known or self.basis == "measurement":
            return 0.0
        spread = float(self.posterior.terms[1][self.posterior.first_known])
        return abs(self._with_groove) / spread * self._per_depth

    def random_uncertainty(self, coefficient: float) -> float:  # noqa: ARG002
        """Return the standard uncertainty of ln k_D by noise, drift and all else that the reading alone leaves open."""
        whole = self._together[1] * self._per_depth
        measured = math.hypot(*self._measured_contributions().values())
        return math.sqrt(max(0.0, whole**2 - measured**2))


def _draws(values: Numbers) -> Column:
    """Return one value per draw, (draws,), of a column of draws, (draws, 1); of a single value, one draw."""
    column = np.asarray(values, dtype=float)
    return column[:, 0] if column.ndim > 1 else np.atleast_1d(column)


def _probability(scores: Column) -> Column:
    from scipy.special import ndtr

    return np.asarray(ndtr(scores))


def depth_problem(problem: WearProblem, corrected: CorrectedRun, recipe: Recipe) -> DepthProblem:
    """Pose the fit by the whole reading of a run that a fit in two steps has been posed for.

    Raises ``FitError`` where nothing was measured after the test and the reading shows less wear than none.
    """
    run = corrected.run
    record = depth_record(run)
    samples = record.samples
    # The law's own parameters are sought with noise taken for white first: that is where the model starts from.
    joint = joint_problem(problem, corrected, recipe)
    mean = samples.blocks.mean
    measured_after = corrected.correction.anchor is not None
    # Where nothing was measured, what the reading itself says stands for the end; it is no input.
    inputs = {name: known for name, known in joint.inputs.items() if measured_after or name != END_ANCHOR}
    posed = posed_as(
        problem,
        DepthProblem,
        law=joint.law,
        distance=mean(np.sqrt(samples.progress)) ** 2,
        inputs=inputs,
        weights=samples.blocks.counts,
        tangent=joint.tangent,
        missed=DepthProblem.missed,  # in a fit in two steps, this is a length
        record=record,
        run=run,
        recipe=recipe,
        measured_after=measured_after,
    )
    if not measured_after:
        _refuse_a_fall(posed)
    return posed.with_law_of_the_reading().without_excluded_pressure()


def _within(known: LawParameter, value: float, step: float) -> float:
    """Return a value after a step, which goes at most most of the way to a limit, where a law may lose its shape."""
    room = (known.low if step < 0 else known.high) - value
    return value + (_MOST_OF_THE_ROOM * room if abs(step) > _MOST_OF_THE_ROOM * abs(room) else step)


def _refuse_a_fall(problem: DepthProblem) -> None:
    """Refuse a reading that alone gives k_D, and shows less wear than none."""
    wear, spread = problem.posterior.alone
    if wear < -MOST_DEVIATION * spread:
        shown = Quantity(value=wear, unit="m", standard_uncertainty=spread).shown("um")
        raise FitError(
            f"{problem.run.id}: depth: found a depth signal that, fitted alone, gives a wear depth of {shown}; "
            'expected zero or more; if the signal decreases with wear, add the step "invert" with signals = '
            f'["depth"] after the default steps, or {problem.contact.sliding_tip.how_to_measure}'
        )
