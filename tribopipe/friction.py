"""Friction over the sliding distance: μ(s) = A·exp(−s/c) + b (paper, Eq. 7), or as much of it as the data hold.

On real data Eq. 7 degenerates where there is no exponential running-in: c runs off to millions of metres and b to −A.
So the fit is bounded, the loading ramp is left out, and the exponential is reported only where the data tell it
from a constant and from a straight line, by the Bayesian information criterion (G. Schwarz, Annals of Statistics 6
(1978) 461) with the number of independent samples in the place of the number of samples. Otherwise the steady value
alone is reported, and why.
"""

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from tribopipe.noise import effective_samples, inflation
from tribopipe.records.quantity import Quantity
from tribopipe.records.recipe import FrictionRecipe
from tribopipe.records.results import FrictionFit
from tribopipe.run import Column, RawRun

_FEWEST_SAMPLES = 20
_STARTS = 40
_LONGEST_RUNNING_IN = 10.0
"""Upper bound of c in lengths of the fitted window: beyond, the curve is a straight line."""
_SHORTEST_RUNNING_IN = 5.0
"""Lower bound of c in sample spacings: below, the decay may as well be a few odd samples."""
_DECISIVE = 6.0
"""Difference of the criterion that counts as evidence (R. E. Kass, A. E. Raftery, JASA 90 (1995) 773: 'strong')."""
_LARGEST_RELATIVE_UNCERTAINTY = 0.5
_CLEARLY = 3.0
"""Standard uncertainties by which friction must start below zero to be called negative."""
_NEARLY_SETTLED = 1e-3
"""Relative change of the parameters within which the search has found its minimum."""
_SMALL = 1e-6
"""Friction and the like below which a change counts in itself."""
_RAMP_SHARE = 0.05
"""A loading ramp takes at most this share of a run."""


@dataclass(frozen=True)
class _Exponential:
    parameters: Column
    covariance: Column
    residuals: Column

    @property
    def running_in(self) -> float:
        return float(self.parameters[2])


def fit_friction(run: RawRun, recipe: FrictionRecipe | None = None) -> FrictionFit:
    """Fit Eq. 7 to a run's friction coefficient against sliding distance.

    Amplitude A and steady state b are ratios, the running-in distance c is in m. A run without friction passes
    through, and the result says so; of one without a distance the steady value is reported.
    """
    recipe = recipe or FrictionRecipe()
    if "friction_coefficient" not in run.columns:
        return FrictionFit(outcome="none", notes=("the run lacks a friction signal",))
    distance, mu = run.sliding_distance, run.columns["friction_coefficient"]
    if run.origins["sliding_distance"] == "unknown":
        return _without_distance(run, mu[np.isfinite(mu)])
    seen = np.isfinite(mu) & np.isfinite(distance)
    first = _loading_ramp_end(run, mu) if recipe.start is None else recipe.start.value
    last = np.inf if recipe.end is None else recipe.end.value
    inside = seen & (distance >= first) & (distance <= last)
    fit = _fit_window(distance[inside], mu[inside])
    trimmed = (f"loading ramp of {first:.3g} m left out",) if recipe.start is None and first > 0 else ()
    mean, deviation = _vendor_statistics(mu[seen])
    return fit.model_copy(
        update={"notes": trimmed + fit.notes, "load": _load(run), "mean": mean, "standard_deviation": deviation}
    )


def _without_distance(run: RawRun, mu: Column) -> FrictionFit:
    """Return the steady value of a run of which nothing tells how far it slid."""
    if len(mu) < _FEWEST_SAMPLES:
        return FrictionFit(outcome="none", notes=(f"{len(mu)} samples of friction are too few to fit",))
    mean, deviation = _vendor_statistics(mu)
    unknown = "the sliding distance is not known: give conditions.sliding_speed for a running-in distance"
    steady = _steady_only(mu, (unknown,), None)
    return steady.model_copy(update={"load": _load(run), "mean": mean, "standard_deviation": deviation})


def _load(run: RawRun) -> Literal["measured", "nominal", "recorded"]:
    origin = run.origins["friction_coefficient"]
    if origin == "derived from measured load":
        return "measured"
    return "nominal" if origin == "derived from nominal load" else "recorded"


def _vendor_statistics(mu: Column) -> tuple[Quantity | None, Quantity | None]:
    """Mean and standard deviation over everything recorded, loading ramp included, as instruments print them."""
    if len(mu) < 2:
        return None, None
    deviation = float(np.std(mu, ddof=1))
    return _ratio(float(np.mean(mu)), deviation / math.sqrt(effective_samples(mu))), _ratio(deviation)


def _loading_ramp_end(run: RawRun, mu: Column) -> float:
    """Return the sliding distance, m, at which the load is on; 0 where there is no ramp.

    Where the load was measured, that is where it first reaches 95 % of its median. Otherwise friction tells: a
    ramp starts below half of the later level and crosses that within 5 % of the run; it ends at the highest friction
    within three times the distance of the crossing. A true rise of friction loses only its first metres by this, which
    an exponential does not miss.
    """
    distance = run.sliding_distance
    if run.origins.get("normal_force") == "measured":
        return _ramp_end_by_load(distance, run.columns["normal_force"])
    return _ramp_end_by_friction(distance, mu)


def _ramp_end_by_load(distance: Column, force: Column) -> float:
    loaded = np.flatnonzero(force >= 0.95 * np.nanmedian(force))
    early = len(loaded) and loaded[0] > 0 and distance[loaded[0]] <= _RAMP_SHARE * distance[-1]
    return float(distance[loaded[0]]) if early else 0.0


def _ramp_end_by_friction(distance: Column, mu: Column) -> float:
    half = 0.5 * float(np.nanmedian(mu))
    crossed = np.flatnonzero(mu >= half)
    if not len(crossed) or crossed[0] == 0 or distance[crossed[0]] > _RAMP_SHARE * distance[-1]:
        return 0.0
    first = int(crossed[0])
    until = max(first + 2, int(np.searchsorted(distance, 3 * distance[first], side="right")))
    return float(distance[first + int(np.nanargmax(mu[first:until]))])


def _fit_window(distance: Column, mu: Column) -> FrictionFit:
    if len(mu) < _FEWEST_SAMPLES:
        return FrictionFit(outcome="none", notes=(f"{len(mu)} samples of friction are too few to fit",))
    window = (_metres(float(distance[0])), _metres(float(distance[-1])))
    if np.median(mu) < 0:
        return _steady_only(mu, ("friction is negative: check the sign of the friction force",), window)
    if window[0].value == window[1].value:
        return _steady_only(mu, ("the sliding distance never grows: check speed or clock",), window)
    if np.ptp(mu) == 0:
        return _steady_only(mu, ("friction never changes: check whether the channel was on",), window)
    fit = _fit_exponential(distance, mu)
    reasons = _reasons_against(fit, distance, mu)
    if reasons:
        return _steady_only(mu, reasons, window)
    spread = np.sqrt(np.diag(fit.covariance))
    return FrictionFit(
        outcome="exponential",
        notes=_cautions(fit, distance),
        amplitude=_ratio(float(fit.parameters[0]), float(spread[0])),
        steady_state=_ratio(float(fit.parameters[1]), float(spread[1])),
        running_in_distance=_metres(fit.running_in, float(spread[2])),
        covariance=tuple(tuple(row) for row in fit.covariance.tolist()),
        window=window,
        residual_deviation=_ratio(float(np.std(fit.residuals, ddof=3))),
        effective_samples=effective_samples(fit.residuals),
    )


def _steady_only(mu: Column, reasons: tuple[str, ...], window: tuple[Quantity, Quantity] | None) -> FrictionFit:
    later = mu[len(mu) // 2 :]
    deviation = float(np.std(later, ddof=1))
    independent = effective_samples(later)
    return FrictionFit(
        outcome="steady-only",
        notes=(*reasons, "steady value is the mean of the later half"),
        steady_state=_ratio(float(np.mean(later)), deviation / math.sqrt(independent)),
        window=window,
        residual_deviation=_ratio(deviation),
        effective_samples=independent,
    )


def _fit_exponential(distance: Column, mu: Column) -> _Exponential:
    """Fit (A, b, c) by bounded least squares, started at the best of a ladder of running-in distances."""
    from scipy.optimize import least_squares

    shortest, longest = _running_in_bounds(distance)
    largest = 10 * float(np.ptp(mu)) + float(np.max(np.abs(mu)))
    start = _best_start(distance, mu, shortest, longest)
    bounds = ([-largest, 0.0, math.log(shortest)], [largest, largest, math.log(longest)])
    found = least_squares(
        lambda p: _residuals(distance, mu, p),
        np.clip(start, [-largest, 1e-12, bounds[0][2] + 1e-9], [largest, largest, bounds[1][2] - 1e-9]),
        jac=lambda p: _slopes(distance, p),
        bounds=bounds,
        x_scale=[max(abs(start[0]), 1e-6), max(abs(start[1]), 1e-6), 1.0],
        xtol=1e-12,
        ftol=1e-12,
        gtol=1e-12,
    )
    settled = _settled(distance, mu, found.x, found.active_mask == 0)
    residuals, slopes, c = _residuals(distance, mu, settled), _slopes(distance, settled), math.exp(settled[2])
    scale = np.diag([1.0, 1.0, c])
    normal = np.linalg.pinv(slopes.T @ slopes)
    covariance = scale @ normal @ scale * inflation(residuals, 3)
    return _Exponential(np.array([settled[0], settled[1], c]), covariance, residuals)


def _settled(distance: Column, mu: Column, found: Column, free: NDArray[np.bool_]) -> Column:
    """Take Gauss–Newton steps in the free parameters for as long as they get shorter.

    A search that stops where the sum of squares no longer falls knows its minimum to half of the digits only: which
    others it ends on depends on the order in which the processor adds.
    """
    p, longest = found.copy(), _NEARLY_SETTLED
    while True:
        step = np.linalg.lstsq(_slopes(distance, p)[:, free], _residuals(distance, mu, p), rcond=None)[0]
        size = float(np.linalg.norm(step / np.maximum(np.abs(p[free]), _SMALL)))
        if not size < longest:
            return p
        p[free] -= step
        longest = size


def _residuals(distance: Column, mu: Column, p: Column) -> Column:
    """Return A·exp(−s/c) + b less what was measured."""
    return np.asarray(p[0] * np.exp(-distance / math.exp(p[2])) + p[1] - mu)


def _slopes(distance: Column, p: Column) -> Column:
    """Return the derivatives of A·exp(−s/c) + b by A, b and ln c."""
    x = distance / math.exp(p[2])
    decay = np.exp(-x)
    return np.column_stack([decay, np.ones_like(decay), p[0] * x * decay])


def _running_in_bounds(distance: Column) -> tuple[float, float]:
    steps = np.diff(distance)
    spacing = float(np.median(steps[steps > 0]))
    length = float(distance[-1] - distance[0])
    return min(_SHORTEST_RUNNING_IN * spacing, length / 4), _LONGEST_RUNNING_IN * length


def _best_start(distance: Column, mu: Column, shortest: float, longest: float) -> Column:
    """Try a ladder of c; for each, A and b follow by linear least squares."""
    best, best_power = np.array([0.0, float(np.mean(mu)), math.log(longest)]), np.inf
    for c in np.geomspace(shortest, longest, _STARTS):
        design = np.column_stack([np.exp(-distance / c), np.ones_like(distance)])
        (amplitude, steady), *_ = np.linalg.lstsq(design, mu, rcond=None)
        residuals = design @ (amplitude, steady) - mu
        power = float(residuals @ residuals)
        if power < best_power and steady >= 0:
            best, best_power = np.array([amplitude, steady, math.log(c)]), power
    return best


def _reasons_against(fit: _Exponential, distance: Column, mu: Column) -> tuple[str, ...]:
    """Say why the exponential cannot be told from the data; nothing where it can."""
    independent = effective_samples(fit.residuals)
    power = float(fit.residuals @ fit.residuals)
    constant = float(np.sum((mu - np.mean(mu)) ** 2))
    line = np.polynomial.Polynomial.fit(distance, mu, 1)
    straight = float(np.sum((mu - line(distance)) ** 2))
    shortest, longest = _running_in_bounds(distance)
    c, spread = fit.running_in, math.sqrt(fit.covariance[2, 2])
    if _evidence(power, constant, independent, 2) < _DECISIVE:
        return ("no running-in to be told from a constant",)
    if _evidence(power, straight, independent, 1) < _DECISIVE or c > 0.99 * longest:
        change = line(distance[-1]) - line(distance[0])
        return (f"friction changes in a straight line, by {change:+.3f} over the fitted distance, not exponentially",)
    if fit.parameters[0] + fit.parameters[1] < -_CLEARLY * math.sqrt(fit.covariance[:2, :2].sum()):
        return ("the exponential would start at a negative friction",)
    if c < 1.01 * shortest:
        return (f"the decay is shorter than {_SHORTEST_RUNNING_IN:.0f} samples",)
    if spread > _LARGEST_RELATIVE_UNCERTAINTY * c:
        return (f"the running-in distance is undetermined ({c:.3g} ± {spread:.2g} m)",)
    return ()


def _evidence(power: float, simpler: float, independent: float, fewer: int) -> float:
    """Return how much better the exponential is than a simpler curve: the difference of the criteria."""
    if power == 0:
        return math.inf if simpler > 0 else 0.0
    return independent * math.log(simpler / power) - fewer * math.log(independent)


def _cautions(fit: _Exponential, distance: Column) -> tuple[str, ...]:
    notes = []
    length = float(distance[-1] - distance[0])
    if fit.running_in > length:
        notes.append(
            f"running-in of {fit.running_in:.4g} m is longer than the {length:.4g} m fitted: the steady state "
            "is an extrapolation"
        )
    if fit.parameters[0] < 0:
        notes.append("friction rises from its start")
    return tuple(notes)


def _ratio(value: float, spread: float | None = None) -> Quantity:
    return Quantity(value=value, unit="1", standard_uncertainty=spread)


def _metres(value: float, spread: float | None = None) -> Quantity:
    return Quantity(value=value, unit="m", standard_uncertainty=spread)
