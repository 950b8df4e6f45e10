"""Agreement of a run with a law: measured against predicted wear, along the curve too, and the end of life.

δ = measured − predicted, E_n = δ / (half width of δ's 95 % interval on the side towards zero)

which is the E_n number of ISO 13528 with the expanded uncertainty taken from draws, so that what both share (the tip
radius) cancels and skewness counts. Along the curve the largest such number is held against what 95 % of drawn curves
keep to anywhere: a simultaneous band. The law is rejected only beyond the 99 % limits, half of that allowed to the end
and half to the curve, so that a valid law is rejected in about one of a hundred runs; between the 95 % and the 99 %
limits the comparison is inconclusive, as it is where neither would reveal a k_D wrong by a factor of two.
"""

import math
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.base.errors import ContactError
from tribopipe.base.units import show, show_force, signed
from tribopipe.documents.contact_kinds import spoken
from tribopipe.documents.quantity import Quantity, between, wear_coefficient
from tribopipe.documents.recipe import LawName, Recipe
from tribopipe.documents.signals import SignalName
from tribopipe.documents.study import Study
from tribopipe.physics.laws import law_heading
from tribopipe.physics.uncertainty import TAILS
from tribopipe.results.finding import Finding
from tribopipe.results.study import BodyVerdict, EndOfLife, Role, RunVerdict, StudyCurve, Verdict, WornQuantity

DECISIVE = 0.005
"""Probability, at the end and along the curve each, of rejecting a valid law."""
_NOTABLE = 0.05
_SURE = 0.01
"""Probability under the law below which a trend or a change is worth a word."""
_SMALL = 0.1
"""Trend over u of the measured wear below which it is not: k_D is hardly changed by it."""
_NONE = 1e-9
"""Share of the wear that is no difference: limits are at least as wide."""
_LEAST_REACH = 0.5
"""Limits along a curve over those at each place are at least 1, up to the scatter of draws, unless nothing is drawn."""
_NOTICED = 2.0
"""Factor of k_D that has to be noticed for "supported" to mean anything."""
_MIDDLE = (0.158655, 0.841345)
"""Ends of the interval that holds one standard deviation on either side of a normal distribution."""
MEASURED_IN: dict[WornQuantity, str] = {"wear_volume": "m^3", "wear_depth": "m", "track_width": "m"}
"""Unit of the wear quantity on which agreement is judged, SI."""


@dataclass(frozen=True)
class Question:
    """One run as a study evaluates it."""

    study: Study
    law: LawName
    recipe: Recipe
    role: Role
    best: Column
    """k_D of each body by the study, m²/N."""
    coefficients: Column
    """Draws of them for a run of its own, (draws, bodies)."""
    bodies: Sequence[str]
    """Their bodies."""

    def of(self, body: str) -> tuple[float, Column]:
        """Return k_D of a body, m²/N, and its draws."""
        place = self.bodies.index(body)
        return float(self.best[place]), self.coefficients[:, place]


@dataclass(frozen=True)
class Judgment:
    """Agreement of one run with a law."""

    bodies: dict[str, BodyVerdict]
    curves: tuple[StudyCurve, ...]
    end_of_life: EndOfLife | None
    notes: tuple[str, ...]
    findings: tuple[Finding, ...] = ()


@dataclass(frozen=True)
class Comparison:
    """Measured and predicted wear of one run, and how both may be off, at the places of the run."""

    measured: Column
    predicted: Column
    measured_draws: Column
    predicted_draws: Column
    least: float = 0.0
    """Deviation along a curve that matters, m: limits are at least as wide."""

    @property
    def deviation(self) -> Column:
        """Measured minus predicted depth, m."""
        return self.measured - self.predicted

    @cached_property
    def errors(self) -> Column:
        """What the deviation may be off by, draws by places, m."""
        return (self.measured_draws - self.measured) - (self.predicted_draws - self.predicted)

    @cached_property
    def _ordered(self) -> Column:
        """The errors at each place in ascending order: many intervals are taken of them."""
        return np.sort(self.errors, axis=0)

    def limits(self, level: float) -> Column:
        """Return the half widths of the interval of the deviation towards zero, m, at each place."""
        low, high = _quantiles(self._ordered, (level / 2, 1 - level / 2))
        return np.asarray(np.maximum(np.where(self.deviation > 0, -low, high), self._none))

    @property
    def _none(self) -> float:
        """Difference that is none."""
        return _NONE * float(np.max(np.abs([self.measured, self.predicted])))

    def along(self, level: float) -> Column:
        """Return the deviation over its simultaneous limits at each place."""
        errors = self.errors
        low, high = _quantiles(self._ordered, TAILS)
        scaled = np.where(errors < 0, errors / np.minimum(low, -self._none), errors / np.maximum(high, self._none))
        reached = max(_LEAST_REACH, float(np.quantile(np.max(scaled, axis=1), 1 - level)))
        return self.deviation / np.maximum(self.limits(_NOTABLE) * reached, self.least)

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
    low, high = _quantiles(np.sort(draws, axis=0), TAILS)
    return low, high


def _quantiles(ordered: Column, shares: tuple[float, float]) -> Column:
    """Return quantiles of columns in ascending order, linear between their values."""
    place = np.asarray(shares) * (len(ordered) - 1)
    below = place.astype(int)
    above = np.minimum(below + 1, len(ordered) - 1)
    return np.asarray(ordered[below] + (place - below)[:, None] * (ordered[above] - ordered[below]))


def decide(comparison: Comparison, with_factor: Callable[[float], Column], decisive: float = DECISIVE) -> Verdict:
    """Report what a comparison means for the law.

    ``with_factor`` gives the law's depth at the places with k_D times a factor, ``decisive`` the probability, at the
    end and along the curve each, of rejecting a valid law.
    """
    end = comparison.deviation[-1] / comparison.limits(decisive)[-1]
    curve = comparison.along(decisive)
    worst = end if abs(end) >= 1 else float(curve[np.argmax(np.abs(curve))])
    if abs(worst) >= 1:
        return "under-predicts" if worst > 0 else "over-predicts"
    return "not decidable" if _noticed(comparison) or not _telling(comparison, with_factor) else "supported"


def _noticed(comparison: Comparison) -> bool:
    """Return whether the deviation is beyond its 95 % limits, at the end or along the curve."""
    at_the_end = abs(comparison.deviation[-1] / comparison.limits(_NOTABLE)[-1]) >= 1
    return bool(at_the_end or np.any(np.abs(comparison.along(_NOTABLE)) >= 1))


def _telling(comparison: Comparison, with_factor: Callable[[float], Column]) -> bool:
    """Return whether a k_D off by a factor of two, on one side at least, would be noticed."""
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


_DEPARTING: tuple[Verdict, ...] = ("over-predicts", "under-predicts")


class KnownCoefficient(NamedTuple):
    """k_D of one body, m²/N: by a run alone, and by the study."""

    own: float
    own_draws: Column
    best: float
    draws: Column


def body_verdict(
    comparison: Comparison, outcome: Verdict, what: WornQuantity, at: Sequence[str | Quantity], known: KnownCoefficient
) -> BodyVerdict:
    """Return the law against the wear of one body; ``at`` names the places of the comparison."""
    unit, along = MEASURED_IN[what], comparison.along(_NOTABLE)
    worst = int(np.argmax(np.abs(along)))

    def last(values: Column, draws: Column) -> Quantity:
        return Quantity(value=float(values[-1]), unit=unit, standard_uncertainty=float(np.std(draws[:, -1])))

    def ends(band: tuple[Column, Column]) -> tuple[Quantity, Quantity]:
        low, high = (float(side[-1]) for side in band)
        return Quantity(value=max(low, 0.0), unit=unit), Quantity(value=high, unit=unit)

    return BodyVerdict(
        outcome=outcome,
        what=what,
        measured=last(comparison.measured, comparison.measured_draws),
        predicted=last(comparison.predicted, comparison.predicted_draws),
        predicted_interval=ends(comparison.law_band()),
        measurement_interval=ends(comparison.measurement_band()),
        e_n=float(comparison.deviation[-1] / comparison.limits(_NOTABLE)[-1]),
        e_n_all=float(along[worst]),
        e_n_all_at=at[worst],
        wear_coefficient=wear_coefficient(known.own, float(np.nanstd(known.own_draws))),
        coefficient_ratio=ratio(*known),
    )


def worst_outcome(bodies: Collection[BodyVerdict]) -> Verdict:
    """Return the outcome of a run: that of the body that departs most."""
    departing = [body for body in bodies if body.outcome in _DEPARTING]
    if departing:
        return max(departing, key=lambda body: abs(body.e_n)).outcome
    return "not decidable" if any(body.outcome == "not decidable" for body in bodies) else "supported"


def sentence(law: LawName, verdict: RunVerdict) -> str:
    """Return the agreement of the run with the law in one sentence."""
    name, at = law_heading(law), f"at {show_force(verdict.normal_load.value)}"
    slip = verdict.slip
    each = {body: _against(found, verdict) for body, found in verdict.bodies.items()}
    off = {body: _by_how_much(found) for body, found in verdict.bodies.items()}
    if slip is None:
        named = {body: f"{spoken(body)} " if len(each) > 1 else "" for body in each}
        said = "; ".join(
            f"{named[body]}{words} at {show(verdict.end.value, None, 'm')}, {off[body]}" for body, words in each.items()
        )
    else:
        at = f"{at} and {show(slip.value, None, '1', '%')} slip"
        parts = (f"{spoken(body)} {words}, {off[body]}" for body, words in each.items())
        said = f"after {verdict.end.value:,.0f} rotations {'; '.join(parts)}"
    if verdict.outcome == "supported":
        way = "agrees with" if verdict.role == "fitted" else "predicts"
        return f"{name} {way} the wear {at}: {said}{_left_over(verdict.first)}."
    doubts = [finding.message for finding in verdict.findings if finding.severity != "note"]
    if verdict.outcome == "not decidable" and doubts:
        return f"Agreement with {name} {at} is inconclusive: {doubts[0]}; {said}{_alone(verdict)}."
    if verdict.outcome == "not decidable":
        return f"Agreement with {name} {at} is inconclusive at this uncertainty: {said}{_alone(verdict)}."
    return f"{name} {verdict.outcome} the wear {at}: {said}{_alone(verdict)}{_bend(verdict.first)}."


def _against(body: BodyVerdict, verdict: RunVerdict) -> str:
    unit = "mm^3" if body.what == "wear_volume" else "um"
    return (
        f"{body.predicted.shown(unit)} {verdict.role} (95 % CI: {between(body.predicted_interval, unit)}) against "
        f"{body.measured.shown(unit)} measured"
    )


def _by_how_much(body: BodyVerdict) -> str:
    """Return E_n at the end and, where the law departs from the wear before it, the largest one with its place."""
    end, as_at_the_end = f"E_n = {signed(body.e_n, 2)}", (body.e_n > 0) == (body.outcome == "under-predicts")
    if body.outcome not in _DEPARTING or (as_at_the_end and abs(body.e_n) >= 1):
        return end
    at = body.e_n_all_at
    place = at if isinstance(at, str) else show(float(f"{at.value:.3g}"), None, at.unit)
    return f"{end}, but {signed(body.e_n_all, 2)} at {place}"


def _alone(verdict: RunVerdict) -> str:
    """Return k_D of a run alone over the study's; nothing of the one run that the study's k_D is from."""
    ratios = [f"{body.coefficient_ratio}" for body in verdict.bodies.values()]
    return "" if {*ratios} == {"1"} else f"; fitted alone, this run gives {' and '.join(ratios)} of the study's k_D"


def _left_over(body: BodyVerdict) -> str:
    trend, spread = body.trend, body.measured.u_or_zero
    if trend is None or trend.p_value > _SURE or trend.amplitude.value < _SMALL * spread:
        return ""
    size = show(float(f"{trend.amplitude.value:.2g}"), None, "m", "um")
    return f"; the residuals have a trend of {size} that the law does not explain"


def _bend(body: BodyVerdict) -> str:
    change = body.change_point
    if change is None or change.p_value > _SURE or f"{change.rate_ratio:.2f}" == "1.00":
        return ""
    where = show(float(f"{change.sliding_distance.value:.2g}"), None, "m")
    return (
        f"; the wear rate changes at about {where}, where k_D becomes {change.rate_ratio:.2f} times its earlier value"
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
    """Report what is not known where one run alone identifies k_D."""
    if len(fit) > 1:
        return ()
    return (
        f"k_D is identified from a single run, {fit[0]}: the bands include the uncertainty of that run, but not the "
        "run-to-run scatter; replicate tests are needed to quantify the scatter",
    )


_ITERATIONS = 40


CURVE_PLACES = 30
CURVE_DRAWS = 1_000
"""Draws for a band; its ends lie on a smooth curve."""


def volume_curve(
    run_id: str, body: str, asked: Question, along: SignalName, places: Column, line: Column, band: Column
) -> StudyCurve:
    """Return the volume of a body that a law gives along a run, m³, with its 95 % band from draws, (draws, places)."""
    low, high = np.quantile(band, TAILS, axis=0)
    return StudyCurve(run_id, asked.law, asked.role, body, "wear_volume", along, places, line, low, high)


def end_of_life(depth: float, wanted: Column, effective: Callable[[Column], Column], unit: str) -> EndOfLife | None:
    """Return where a run reaches a depth, m, for draws of k_D; None if k_D is rather zero.

    ``wanted`` is the progress at which Archard's law would, not finite where it never would; ``effective`` gives the
    progress S(s) after which that law would have worn as much. S(s) = S* is solved by s ← s·S*/S(s): S(s)/s changes
    slowly.
    """
    reached = np.where(np.isfinite(wanted), wanted, np.nan)
    for _ in range(_ITERATIONS):
        reached = reached * wanted / effective(reached)
    ever = np.where(np.isfinite(reached), reached, np.inf)
    low, middle, high = np.quantile(ever, [TAILS[0], 0.5, TAILS[1]], method="inverted_cdf").tolist()
    if not np.isfinite(middle):
        return None
    return EndOfLife(
        wear_depth=Quantity(value=depth, unit="m"),
        place=Quantity(value=middle, unit=unit),
        interval=(Quantity(value=low, unit=unit), Quantity(value=high, unit=unit) if np.isfinite(high) else None),
    )
