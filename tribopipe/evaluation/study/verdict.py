"""What a run says of a law: measured against predicted wear with both uncertainties, at the end and along the curve.

    δ = measured − predicted,     E_n = δ / (half width of δ's 95 % interval on the side towards zero)

which is the E_n number of ISO 13528 with the expanded uncertainty taken from draws, so that what both share (the
tip radius) cancels and skewness counts. Along the curve the largest such number is held against what 95 % of drawn
curves keep to anywhere: a simultaneous band. The law is called off only beyond the 99 % limits, half of that allowed to
the end and half to the curve, so that a sound law is called off in about one of a hundred runs; between the 95 %
and the 99 % limits nothing is decided, nor where a k_D off by a factor of two would go unnoticed at both.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.base.errors import ContactError
from tribopipe.base.units import show, show_force, signed
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import LawName
from tribopipe.evaluation.study.member import RunDraws
from tribopipe.physics.laws import law_heading
from tribopipe.physics.uncertainty import TAILS
from tribopipe.results.agreement import BodyVerdict, Exponent, RunVerdict, Verdict

DECISIVE = 0.005
"""Probability, at the end and along the curve each, of calling off a law that holds."""
_NOTABLE = 0.05
_SURE = 0.01
"""Probability under the law below which a trend or a change is worth a word."""
_NONE = 1e-15
"""Depth, m, that is none: limits are at least as wide."""
_NOTICED = 2.0
"""Factor of k_D that has to be noticed for "supported" to mean anything."""
_MIDDLE = (0.158655, 0.841345)
"""Ends of the interval that holds one standard deviation on either side of a normal distribution."""
_LATER_PART = 0.25
"""Share of the distance after which the local exponent is taken."""


@dataclass(frozen=True)
class Comparison:
    """Measured and predicted wear of one run, and how both may be off, at the places of the run."""

    measured: Column
    predicted: Column
    measured_draws: Column
    predicted_draws: Column

    @property
    def deviation(self) -> Column:
        """Measured minus predicted depth, m."""
        return self.measured - self.predicted

    @cached_property
    def errors(self) -> Column:
        """What the deviation may be off by, draws by places, m."""
        return (self.measured_draws - self.measured) - (self.predicted_draws - self.predicted)

    def limits(self, level: float) -> Column:
        """Return the half widths of the interval of the deviation towards zero, m, at each place."""
        low, high = np.quantile(self.errors, [level / 2, 1 - level / 2], axis=0)
        return np.asarray(np.maximum(np.where(self.deviation > 0, -low, high), _NONE))

    def along(self, level: float) -> Column:
        """Return the deviation over its simultaneous limits at each place."""
        errors = self.errors
        low, high = np.quantile(errors, TAILS, axis=0)
        scaled = np.where(errors < 0, errors / np.minimum(low, -_NONE), errors / np.maximum(high, _NONE))
        reached = float(np.quantile(np.max(scaled, axis=1), 1 - level))
        return self.deviation / (self.limits(_NOTABLE) * reached)

    def law_band(self) -> tuple[Column, Column]:
        """Return the 95 % interval of the law's depth, m, at each place."""
        return _interval(self.predicted_draws)

    def measurement_band(self) -> tuple[Column, Column]:
        """Return where 95 % of measurements would lie, were the law true, m, at each place.

        A drawn measured depth less the best is what the truth may be off by; the reading is off the other way. So what
        both share, such as the tip radius, counts with its sign.
        """
        return _interval(self.predicted_draws - (self.measured_draws - self.measured))


def _interval(draws: Column) -> tuple[Column, Column]:
    low, high = np.quantile(draws, TAILS, axis=0)
    return low, high


def compare(draws: RunDraws, coefficient: float, coefficients: Column) -> Comparison:
    """Compare a run with a law whose k_D is known with draws."""
    return Comparison(
        draws.run.measured(), draws.run.predicted(coefficient), draws.measured(), draws.predicted(coefficients)
    )


def decide(comparison: Comparison, with_factor: Callable[[float], Column], decisive: float = DECISIVE) -> Verdict:
    """Say what a comparison means for the law.

    ``with_factor`` gives the law's depth at the places with k_D times a factor, ``decisive`` the probability, at the
    end and along the curve each, of calling off a law that holds.
    """
    end = comparison.deviation[-1] / comparison.limits(decisive)[-1]
    curve = comparison.along(decisive)
    worst = end if abs(end) >= 1 else float(curve[np.argmax(np.abs(curve))])
    if abs(worst) >= 1:
        return "under-predicts" if worst > 0 else "over-predicts"
    return "not decidable" if _noticed(comparison) or not _telling(comparison, with_factor) else "supported"


def _noticed(comparison: Comparison) -> bool:
    """Say whether the deviation is beyond its 95 % limits, at the end or along the curve."""
    at_the_end = abs(comparison.deviation[-1] / comparison.limits(_NOTABLE)[-1]) >= 1
    return bool(at_the_end or np.any(np.abs(comparison.along(_NOTABLE)) >= 1))


def _telling(comparison: Comparison, with_factor: Callable[[float], Column]) -> bool:
    """Say whether a k_D off by a factor of two, on one side at least, would be noticed."""
    as_it_is = with_factor(1.0)
    for factor in (1 / _NOTICED, _NOTICED):
        try:
            off = with_factor(factor)
        except ContactError:  # the tip would be worn away, which nobody overlooks
            return True
        draws = comparison.measured_draws + (off - comparison.measured)
        expected = comparison.predicted_draws + (as_it_is - comparison.predicted)
        if _noticed(Comparison(off, as_it_is, draws, expected)):
            return True
    return False


def exponent(draws: RunDraws, comparison: Comparison, own: Column) -> Exponent | None:
    """Return the local exponent of h(s) late in the run; none where the curve does not rise above zero there."""
    places = draws.run.places[:-1]
    late = places > _LATER_PART * places[-1]
    measured, drawn = comparison.measured[:-1][late], comparison.measured_draws[:, :-1][:, late]
    risen = np.all(drawn > 0, axis=1)
    if np.any(measured <= 0) or np.count_nonzero(risen) < len(risen) / 2:
        return None
    x = np.log(places[late])
    x = x - np.mean(x)
    pull = x / (x @ x)
    spread = float(np.std(np.log(drawn[risen]) @ pull))
    return Exponent(
        measured=Quantity(value=float(np.log(measured) @ pull), unit="1", standard_uncertainty=spread),
        by_law=float(np.log(own[:-1][late]) @ pull),
    )


def sentence(law: LawName, verdict: RunVerdict) -> str:
    """Say the outcome as a tribologist would."""
    name, load = law_heading(law), show_force(verdict.normal_load.value)
    where, (body,) = f"{verdict.end.value:.4g} m", verdict.bodies.values()
    low, high = (end.shown("um") for end in body.predicted_interval)
    said = (
        f"{body.predicted.shown('um')} {verdict.role} (95 % interval {low} to {high}) against "
        f"{body.measured.shown('um')} measured at {where}, E_n = {signed(body.e_n, 2)}"
    )
    ratio = f"by itself this run has {body.coefficient_ratio} times that k_D"
    if verdict.outcome == "supported":
        way = "follows" if verdict.role == "fitted" else "predicts"
        return f"{name} {way} the wear at {load}: {said}{_left_over(body)}."
    doubts = [finding.message for finding in verdict.findings if finding.severity != "note"]
    if verdict.outcome == "not decidable" and doubts:
        return f"Whether {name} holds at {load} cannot be decided: {doubts[0]}; {said}; {ratio}."
    if verdict.outcome == "not decidable":
        return f"Whether {name} holds at {load} cannot be decided with this uncertainty: {said}; {ratio}."
    return f"{name} {verdict.outcome} the wear at {load}: {said}; {ratio}{_bend(body)}."


def _left_over(body: BodyVerdict) -> str:
    trend = body.trend
    if trend is None or trend.p_value > _SURE:
        return ""
    return f"; its residuals keep a trend of {trend.amplitude.shown('um')} that the law does not explain"


def _bend(body: BodyVerdict) -> str:
    change = body.change_point
    if change is None or change.p_value > _SURE:
        return ""
    where = show(float(f"{change.sliding_distance.value:.2g}"), None, "m")
    return (
        f", and its wear rate leaves the law at about {where}, after which k_D is "
        f"{change.rate_ratio:.2f} times that before"
    )


def ratio(own: float, draws: Column, of: float, of_draws: Column) -> Quantity:
    """Return k_D of a run over that of the study.

    Its standard uncertainty is half of the middle 68 % of the draws: where the study's k_D may be next to nothing, a
    few quotients are huge.
    """
    drawn = draws / np.where(of_draws > 0, of_draws, math.nan)
    spread = float(np.nanquantile(drawn, _MIDDLE) @ (-0.5, 0.5)) if np.any(np.isfinite(drawn)) else None
    return Quantity(value=own / of, unit="1", standard_uncertainty=spread)


def single_run_note(fit: Sequence[str]) -> tuple[str, ...]:
    """Say what is not known where one run alone identifies k_D."""
    if len(fit) > 1:
        return ()
    return (
        f"one run, {fit[0]}, identifies k_D: the bands hold what is uncertain within it, not the scatter from run to "
        "run; replicates would tell",
    )
