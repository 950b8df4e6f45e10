"""Estimates of k_D, drift and future wear from the samples so far, as distributions for any number of samples.

While little wear has been seen, k_D is far from normal, and Gauss–Newton from far away need not arrive. So the wear by
now, h, is taken step by step over all that it can be; zero offset, drift and the disc's wear are fitted for each h.
All h above zero are as likely beforehand, since h enters the reading as it stands, unless k_D is known. The
probability density of h is Student's t of χ², as the noise is found from few independent samples itself (JCGM
101:2008, 6.4.9). What is systematic is added by first-order propagation, and draws of k_D and of depths belong
together.

Where drift is more than a sensor has, the counterbody may be what wears. Nobody knows which of both it is before the
counterbody is measured, so that half of the draws are of k_D with wear of both bodies.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tribopipe.base.arrays import Column, Numbers, Values
from tribopipe.base.errors import FitError
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import LawName, MonteCarloRecipe
from tribopipe.documents.record import Record
from tribopipe.evaluation.depth_reading import MOST_DEVIATION
from tribopipe.extras.live.both_worn import BothWorn, both_worn
from tribopipe.extras.live.problem import LiveProblem
from tribopipe.physics.uncertainty import Distribution

_PLACES = 160
"""At which χ² is computed at a time."""
_NO_MORE = 1e-7
"""Share of the highest probability density below which nothing counts."""
_FEWEST_FREE = 4.0
"""Independent samples from which on the noise is known well enough for a result (JCGM 101:2008, 6.4.9.4)."""
_FILLED = 0.4
"""Share of the places that must count for the rest to be fine enough."""
_MOST_ROUNDS = 30
_MOST_WEAR = 20.0
"""Wear over the range of the reading, at most: more would have to be hidden by as much drift."""
_DRAWS = 4000
_IMPLAUSIBLE = 3.0
"""Standard uncertainties from which on a drift is not that of a sensor."""
_LEAST_DEPTH = 1e-9
"""Wear depth, m, below which a fit shows no wear of a body."""
_ALMOST = 1 - 1e-9
"""Share of a pin's volume at which its depth can still be computed."""


@dataclass(frozen=True)
class Posterior:
    """k_D as the samples so far have it."""

    problem: LiveProblem
    log_coefficient: Column
    """ln k_D at places of equal width in the depth worn by now."""
    weights: Column
    """Probability of each place."""
    best: float
    """ln k_D of the least squares; −∞ where no wear fits best."""
    seed: int

    @cached_property
    def excess_drift(self) -> float:
        """Drift by now beyond that of a sensor, m: zero where it is within three standard uncertainties of that."""
        (drift, spread), (expected, plausible) = self.drift(), self.problem.plausible_drift
        excess = drift - expected
        return excess if abs(excess) > _IMPLAUSIBLE * math.hypot(spread, plausible) else 0.0

    @cached_property
    def both_worn(self) -> BothWorn | None:
        """The wear of both bodies, if that of the counterbody is unknown and the drift is more than a sensor has.

        A counterbody that wears makes the reading deeper.
        """
        problem = self.problem
        if problem.disc_known or problem.contact.sliding_tip.constant_area or self.excess_drift <= 0:
            return None
        found = both_worn(problem)
        return found if min(found.depths(problem.trace.slid)) > _LEAST_DEPTH else None

    @cached_property
    def _errors(self) -> dict[str, Column]:
        """Draws of each systematic input, in its standard uncertainties; what was measured on the pin is in the fit."""
        rng = np.random.default_rng(self.seed)
        anchors = {anchor.name for anchor in self.problem.anchors}
        names = [name for name, given in self.problem.inputs.items() if given.spread and name not in anchors]
        return {name: rng.standard_normal(_DRAWS) for name in names}

    @cached_property
    def _moved(self) -> dict[str, float]:
        """Change of ln k_D for one standard uncertainty of each input."""
        at = math.exp(self.centre)
        return {name: self.problem.sensitivity(name, at) * self.problem.inputs[name].spread for name in self._errors}

    @property
    def shows_wear(self) -> bool:
        """Whether the least squares are at some wear."""
        return math.isfinite(self.best)

    @property
    def centre(self) -> float:
        """Return ln k_D of the least squares, or its mean where no wear fits best."""
        return self.best if self.shows_wear else float(self.weights @ self.log_coefficient)

    @cached_property
    def _random(self) -> Column:
        """Draws of ln k_D by noise and by what was known beforehand, in a random order."""
        share = np.cumsum(self.weights) - self.weights / 2
        drawn = np.interp((np.arange(_DRAWS) + 0.5) / _DRAWS, share, self.log_coefficient)
        return np.random.default_rng(self.seed + 1).permutation(drawn)

    @cached_property
    def _of_both(self) -> Column:
        """Draws of ln k_D with wear of both bodies, NaN in the half of the draws that are of a pin alone.

        A pin alone has lost the most.
        """
        found, rng = self.both_worn, np.random.default_rng(self.seed + 2)
        if found is None:
            return np.full(_DRAWS, np.nan)
        drawn = found.log_coefficient + found.spread * rng.standard_normal(_DRAWS)
        return np.where(rng.permutation(_DRAWS) % 2, np.minimum(drawn, self._random.max()), np.nan)

    @cached_property
    def coefficient(self) -> Column:
        """Draws of k_D, m²/N."""
        random = np.where(np.isnan(self._of_both), self._random, self._of_both)
        return np.exp(random + self._systematic(self._moved))

    def _systematic(self, moved: dict[str, float]) -> Column:
        return np.asarray(sum((self._errors[name] * by for name, by in moved.items()), np.zeros(_DRAWS)))

    def depth(self, distance: float) -> Column:
        """Return draws of the pin's wear depth, m, at a sliding distance, m: what the sensor has seen or will see."""
        moved = {name: self._depth_moved(name, distance) for name in self._errors}
        drawn = self._depth_at(distance, self._random, self.problem.values)
        systematic = self._systematic(moved)
        if self.both_worn is not None:
            beside, by_both = self._depth_of_both(distance, self.both_worn), ~np.isnan(self._of_both)
            systematic = np.where(by_both, systematic * beside / drawn, systematic)
            drawn = np.where(by_both, beside, drawn)
        return np.asarray(np.maximum(drawn + systematic, 0.0))

    def _depth_of_both(self, distance: float, found: BothWorn) -> Column:
        """Return draws of the pin's depth, m, next to a wearing counterbody, by first-order propagation."""
        power = self.problem.contact.sliding_tip.depth_exponent
        return np.asarray(found.depths(distance)[0] * np.exp(power * (self._of_both - found.log_coefficient)))

    def _depth_moved(self, name: str, distance: float) -> float:
        """Return by how much a standard uncertainty of an input moves the depth, m, k_D being fitted again."""
        values, spread, by = self.problem.values, self.problem.inputs[name].spread, self._moved[name]
        low, high = (
            self._depth_at(distance, self.centre + sign * by, {**values, name: values[name] + sign * spread})[0]
            for sign in (-1, 1)
        )
        return float(high - low) / 2

    def _depth_at(self, distance: float, log_coefficient: Numbers, values: Values) -> Column:
        """Return the law's depth, m, at most that of a pin worn away."""
        pin = self.problem.pin(values)
        volume = np.exp(log_coefficient) * self.problem.unit_volume(values, np.asarray([distance]))
        return np.asarray(pin.worn(np.minimum(volume, pin.most_volume * _ALMOST)).depth)

    def worn(self, distance: Column, reading: Column) -> Column:
        """Return readings, m, at sliding distances, m, without zero offset, drift and disc wear: the pin's wear."""
        problem, count = self.problem, len(self.problem.distance)
        fitted = problem.offsets_and_drift(np.asarray(math.exp(self.centre)), problem.values)
        beside = (problem.linear[:count] @ fitted) / problem.root_weights[:count]
        along = np.sqrt(np.maximum(distance, 0.0))
        return np.asarray(problem.values["depth_scale"] * reading - np.interp(along, np.sqrt(problem.distance), beside))

    def drift(self) -> tuple[float, float]:
        """Return what drift has added by now and its standard uncertainty, m."""
        problem, column = self.problem, self.problem.drift_column
        found = np.asarray([problem.offsets_and_drift(np.exp(k), problem.values)[column] for k in self._some])
        given_k = float(np.sum(np.linalg.pinv(problem.linear)[column] ** 2))
        best = problem.offsets_and_drift(np.asarray(math.exp(self.centre)), problem.values)[column]
        return float(best), math.sqrt(given_k + float(np.var(found)))

    @property
    def _some(self) -> Column:
        return np.quantile(self._random, np.linspace(0.02, 0.98, 25))


def posterior(problem: LiveProblem, how: MonteCarloRecipe) -> Posterior:
    """Find k_D by the samples so far. Raises ``FitError`` where wear and drift cannot be separated."""
    if not problem.tells_drift:
        raise FitError(
            "found a flat pin, whose wear depth increases linearly with time, as does drift; expected a known drift, "
            'to separate the two; state the drift, for example --drift "0 +- 5 nm/min"'
        )
    if problem.freedom < _FEWEST_FREE:
        raise FitError("found too few independent samples; expected more; wait for further samples")
    _refuse_a_fall(problem)
    depth, log_k, squares = _searched(problem)
    density = _density(squares, problem.freedom)
    if any(belief.name == "ln k_D" for belief in problem.beliefs):
        density *= np.gradient(log_k, depth)
    return Posterior(problem, log_k, density / density.sum(), _lowest(log_k, squares), how.seed)


def _refuse_a_fall(problem: LiveProblem) -> None:
    """Raise ``FitError`` where a reading from which alone k_D follows clearly decreases in the course of wear."""
    if problem.anchors:
        return
    pin, count, read = problem.pin(problem.values), len(problem.distance), min(_read(problem), _most_depth(problem))
    unit = problem.unit_volume(problem.values)[count - 1]
    expected = problem.model(np.log(pin.volume(np.asarray(read)) / unit), problem.values)[0]
    of_k = [False] * count + [belief.name == "ln k_D" for belief in problem.beliefs]
    weights = np.where(of_k, 0.0, problem.root_weights)
    course, reading = (problem.without_free(rows * weights) for rows in (expected, problem.rows(problem.values)))
    if course @ reading < -MOST_DEVIATION * math.sqrt(float(course @ course)):
        change = problem.trace.end_reading.value - problem.trace.zero_offset.value
        shown = Quantity(value=problem.values["depth_scale"] * change, unit="m").shown("um")
        raise FitError(
            f"depth: found a change of {shown} in the depth signal, which does not agree with wear; expected a depth "
            'that increases with wear; if the signal decreases with wear, add the step "invert" with signals = '
            '["depth"] to a recipe and specify it with --recipe; otherwise, check for thermal drift'
        )


def _density(squares: Column, freedom: float) -> Column:
    return np.asarray((1 + (squares - squares.min()) / freedom) ** (-(freedom + 1) / 2))


def _searched(problem: LiveProblem) -> tuple[Column, Column, Column]:
    """Return depths by now that may be, evenly spaced, with ln k_D and χ² at each."""
    squares_at = _squares(problem)
    pin, unit = problem.pin(problem.values), problem.unit_volume(problem.values)[len(problem.distance) - 1]
    low, high = 0.0, _most_depth(problem)
    for _ in range(_MOST_ROUNDS):
        depth = low + (high - low) * (np.arange(_PLACES) + 0.5) / _PLACES
        log_k = np.log(pin.volume(depth) / unit)
        squares = squares_at(log_k)
        (kept,) = np.nonzero(_density(squares, problem.freedom) > _NO_MORE)
        if len(kept) >= _FILLED * _PLACES:
            break
        step = (high - low) / _PLACES
        low, high = max(low, low + (kept[0] - 1) * step), min(high, low + (kept[-1] + 2) * step)
    return depth, log_k, squares


def _squares(problem: LiveProblem) -> Callable[[Column], Column]:
    """Return χ² against ln k_D, with all that is fitted linearly with it."""
    rows, root, free = problem.rows(problem.values), problem.root_weights, problem.free

    def squares(log_coefficient: Column) -> Column:
        residual = (rows - problem.model(log_coefficient, problem.values)[0]) * root
        residual = residual - (residual @ free) @ free.T
        return np.asarray(np.vecdot(residual, residual))

    return squares


def _most_depth(problem: LiveProblem) -> float:
    """Return the most wear, m, that is looked at."""
    pin = problem.pin(problem.values)
    seen = [anchor.wear.pin_depth.value for anchor in problem.anchors]
    wear = _MOST_WEAR * max([_read(problem), *seen])
    most = float(pin.most_volume)
    return min(wear, float(pin.worn(most * _ALMOST).depth)) if math.isfinite(most) else wear


def _read(problem: LiveProblem) -> float:
    """Return the range of the reading, m."""
    return max(float(np.ptp(problem.rows(problem.values)[: len(problem.distance)])), _LEAST_DEPTH)


def _lowest(log_k: Column, squares: Column) -> float:
    """Return where χ² is least, by a parabola through three places; −∞ where that is at no wear."""
    place = int(np.argmin(squares))
    if place == 0:
        return -math.inf
    around = slice(max(place - 2, 0), place + 3)
    centre = log_k[place]
    curve = np.polynomial.Polynomial.fit(log_k[around] - centre, squares[around], 2).convert().coef
    return float(centre - curve[1] / (2 * curve[2]))


Interval = tuple[Quantity, Quantity]


class Estimate(Record):
    """The samples so far, judged by a wear law; intervals are of 95 %."""

    law: LawName
    """Wear law."""
    sliding_distance: Quantity
    """Sliding distance so far."""
    wear_coefficient: Quantity
    """k_D by least squares; 0 where no wear fits best."""
    interval: Interval
    """95 % interval of k_D; from 0 where no wear fits best."""
    wear_depth: Quantity
    """Wear of the pin by now."""
    wear_depth_interval: Interval
    """95 % interval of the current wear depth."""
    planned_distance: Quantity | None = None
    """Planned sliding distance; None if it is not stated."""
    predicted_depth: Quantity | None = None
    """Wear of the pin at the planned end."""
    predicted_interval: Interval | None = None
    """95 % interval of the wear depth at the planned end."""
    drift_rate: Quantity
    """Drift rate of the sensor: slope of the linear drift against time."""
    finished: bool
    """True if the wear at the end was measured, so that this is the joint fit of the complete run."""


def estimated(found: Posterior, law: LawName, planned: float | None) -> Estimate:
    """Report what the samples so far show."""
    problem = found.problem
    slid, duration = problem.trace.slid, problem.trace.duration
    best = math.exp(found.best)
    k, now = Distribution(found.coefficient), Distribution(found.depth(slid))
    ahead = None if planned is None else Distribution(found.depth(planned))
    drift, spread = found.drift()
    return Estimate(
        law=law,
        sliding_distance=_metres(slid),
        wear_coefficient=Quantity(value=best, unit="m^2/N", standard_uncertainty=k.standard_uncertainty),
        interval=_interval(k, "m^2/N", found),
        wear_depth=_of(now),
        wear_depth_interval=_interval(now, "m", found),
        planned_distance=None if planned is None else _metres(planned),
        predicted_depth=None if ahead is None else _of(ahead),
        predicted_interval=None if ahead is None else _interval(ahead, "m", found),
        drift_rate=Quantity(value=drift / duration, unit="m/s", standard_uncertainty=spread / duration),
        finished=problem.finished,
    )


def _metres(value: float) -> Quantity:
    return Quantity(value=value, unit="m")


def _of(drawn: Distribution) -> Quantity:
    return Quantity(value=drawn.mean, unit="m", standard_uncertainty=drawn.standard_uncertainty)


def _interval(drawn: Distribution, unit: str, found: Posterior) -> Interval:
    """Return the 95 % interval: with equal tails, or from zero where no wear fits best."""
    low, high = drawn.interval if found.shows_wear else (0.0, float(np.quantile(drawn.draws, 0.95)))
    return Quantity(value=low, unit=unit), Quantity(value=high, unit=unit)
