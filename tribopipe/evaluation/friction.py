"""Friction over the sliding distance: μ(s) = A·exp(−s/c) + b (paper, Eq. 7), or as much of it as the data hold.

On real data Eq. 7 degenerates where there is no exponential running-in: c runs off to millions of metres and b to −A.
So the fit is bounded, the loading ramp and stops are left out, and the exponential is reported only where the data
show it from a constant and from a straight line, by the Bayesian information criterion (G. Schwarz, Annals of
Statistics 6 (1978) 461) with the number of independent samples in the place of the number of samples. Otherwise the
steady value alone is reported, and why.
"""

import math
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tribopipe.base.arrays import Column
from tribopipe.base.units import show
from tribopipe.documents.quantity import Quantity, meters
from tribopipe.documents.recipe import DefaultUncertainty, FrictionRecipe
from tribopipe.evaluation.load_and_friction import load_share
from tribopipe.evaluation.measurements.sliding_distance import distance_share
from tribopipe.evaluation.preprocessing.idle import ramp_end_by_friction, ramp_end_by_load
from tribopipe.evaluation.stroke_friction import stroke_friction
from tribopipe.physics.autocorrelation import effective_samples, parameter_covariance
from tribopipe.results.evaluation import FrictionFit
from tribopipe.results.run import RawRun

_FEWEST_SAMPLES = 20
_STRETCHES = 240
_STARTS = 40
_LADDERS = 3
_LONGEST_RUNNING_IN = 10.0
"""Upper bound of c in lengths of the fitted window: beyond, the curve is a straight line."""
_SHORTEST_RUNNING_IN = 5.0
"""Lower bound of c in sample spacings: below, the decay may as well be a few odd samples."""
_DECISIVE = 6.0
"""Difference of the criterion that counts as evidence (R. E. Kass, A. E. Raftery, JASA 90 (1995) 773: 'strong')."""
_LARGEST_RELATIVE_UNCERTAINTY = 0.5
_SURELY = 2.0
"""Standard uncertainties by which c must be longer than its lower bound: one that just happens to be is too long."""
_CLEARLY = 3.0
"""Standard uncertainties by which friction must start below zero to be called negative."""
_NEARLY_SETTLED = 1e-2
"""Change of ln c, and of A and b relative to the larger one, within which the search is close to its minimum."""
_SETTLED = 1e-9
"""Such a change with which it has found it."""
_SMALL = 1e-6
"""Friction and the like below which a change counts in itself."""
_LOADED = 0.95
"""Share of the usual load from which on friction counts."""
_PART_LOADED = 0.5
"""Share of the usual load below which μ is not fitted where the load rises more slowly: noise and zero of both forces
count the more, the smaller the load is that they are divided by."""
_EXTRAPOLATED = 0.1
"""Running-in distances by which the fitted window begins late enough for A to be called an extrapolation."""
_AT_REST = 1e-2
"""Share of the mean speed of a run, below which the bodies are at rest."""
_SHORTEST_REST = 10
"""Samples of the shortest rest."""
_MOST_STOPS = 5
"""A distance that stays the same more often than this is recorded in coarse steps."""


@dataclass(frozen=True)
class _Exponential:
    parameters: Column
    covariance: Column
    residuals: Column
    independent: float
    """Number of independent residuals."""
    shortest: float
    """Bounds of the running-in distance, m."""
    longest: float

    @property
    def running_in(self) -> float:
        return float(self.parameters[2])


def fit_friction(
    run: RawRun, recipe: FrictionRecipe | None = None, defaults: DefaultUncertainty | None = None
) -> FrictionFit:
    """Fit Eq. 7 to a run's friction coefficient against sliding distance.

    Amplitude A and steady state b are ratios, the running-in distance c is in m. A run without friction passes
    through, and the result states it; of one without a distance the steady value is reported.

    Where μ was derived from the friction force, A and b are uncertain by the load as well: were the load higher, both
    would be lower by the same share. Its uncertainty is what run.toml states, else ``defaults``. A μ that the
    instrument recorded was divided by a load that run.toml does not state: there A and b are uncertain by noise
    alone. Where the distance was derived from a speed, a radius, a stroke or a slip, c is as uncertain as these.
    """
    fit = _fitted(run, recipe or FrictionRecipe(), defaults or DefaultUncertainty())
    return fit.model_copy(update={"strokes": stroke_friction(run)}).fitted_to(run)


def _fitted(run: RawRun, recipe: FrictionRecipe, defaults: DefaultUncertainty) -> FrictionFit:
    shares = _load_share(run, defaults), distance_share(run, defaults) or 0.0
    if "friction_coefficient" not in run.columns:
        return FrictionFit(outcome="none", notes=("the run has no friction signal",))
    distance, mu = run.sliding_distance, run.columns["friction_coefficient"]
    if run.origins["sliding_distance"] == "unknown":
        return _with_inputs(_without_distance(run, mu[np.isfinite(mu)]), *shares)
    seen = np.isfinite(mu) & np.isfinite(distance)
    first = _loading_ramp_end(run, mu) if recipe.start is None else recipe.start.value
    last = np.inf if recipe.end is None else recipe.end.value
    inside = seen & (distance >= first) & (distance <= last)
    moving = inside & ~_at_rest(distance)
    fit = _fit_window(distance[moving], mu[moving])
    trimmed = [f"loading ramp of {first:.3g} m excluded"] if recipe.start is None and first > 0 else []
    if stopped := int(np.sum(inside & ~moving)):
        trimmed.append(f"{stopped} samples excluded, during which the sliding distance does not increase")
    mean, deviation = _vendor_statistics(mu[seen])
    found = {"notes": (*trimmed, *fit.notes), "load": _load(run), "mean": mean, "standard_deviation": deviation}
    return _with_inputs(fit.model_copy(update=found), *shares)


def _without_distance(run: RawRun, mu: Column) -> FrictionFit:
    """Return the steady value of a run whose sliding distance is unknown."""
    if len(mu) < _FEWEST_SAMPLES:
        return FrictionFit(outcome="none", notes=(f"{len(mu)} friction samples are too few to fit",))
    mean, deviation = _vendor_statistics(mu)
    unknown = "the sliding distance is unknown: state conditions.sliding_speed to obtain a running-in distance"
    steady = _steady_only(mu, (unknown,), None)
    return steady.model_copy(update={"load": _load(run), "mean": mean, "standard_deviation": deviation})


def _load(run: RawRun) -> Literal["measured", "nominal", "recorded"]:
    origin = run.origins["friction_coefficient"]
    if origin == "derived from measured load":
        return "measured"
    return "nominal" if origin == "derived from nominal load" else "recorded"


def _load_share(run: RawRun, defaults: DefaultUncertainty) -> float:
    """Return the relative standard uncertainty of the load that friction was divided by; 0 of a recorded μ."""
    derived = run.origins.get("friction_coefficient", "measured") != "measured"
    return load_share(run, defaults) if derived else 0.0


def _with_inputs(fit: FrictionFit, load: float, distance: float) -> FrictionFit:
    """Add the uncertainty of the load, which A and b share, and of the distance, which c has."""
    names = ("amplitude", "steady_state", "running_in_distance")
    levels = [getattr(fit, name) for name in names]
    by = np.array([0.0 if level is None else level.value for level in levels]) * (load, load, distance)
    changed: dict[str, object] = {
        name: level.model_copy(update={"standard_uncertainty": math.hypot(level.u_or_zero, spread)})
        for name, level, spread in zip(names, levels, by.tolist(), strict=True)
        if level is not None and spread
    }
    if load and fit.mean is not None:
        spread = math.hypot(fit.mean.u_or_zero, load * fit.mean.value)
        changed["mean"] = fit.mean.model_copy(update={"standard_uncertainty": spread})
    if load and fit.steady_state is not None:
        changed["load_uncertainty"] = _ratio(load)
    if distance and fit.running_in_distance is not None:
        changed["distance_uncertainty"] = _ratio(distance)
    if fit.covariance is not None:
        load_part, distance_part = by * (1, 1, 0), by * (0, 0, 1)
        together = fit.covariance + np.outer(load_part, load_part) + np.outer(distance_part, distance_part)
        changed["covariance"] = tuple(tuple(row) for row in together.tolist())
    return fit.model_copy(update=changed)


def _vendor_statistics(mu: Column) -> tuple[Quantity | None, Quantity | None]:
    """Mean and standard deviation over everything recorded, loading ramp included, as instruments print them."""
    if len(mu) < 2:
        return None, None
    deviation = float(np.std(mu, ddof=1))
    return _ratio(float(np.mean(mu)), deviation / math.sqrt(effective_samples(mu))), _ratio(deviation)


def _loading_ramp_end(run: RawRun, mu: Column) -> float:
    """Return the sliding distance, m, at which the load is on; 0 where there is no ramp.

    Where the load was measured, that is where it first reaches 95 % of its median, or half of it where the load rises
    for more than 5 % of the run. Otherwise friction shows it.
    """
    distance = run.sliding_distance
    if run.origins.get("normal_force") == "measured":
        return ramp_end_by_load(distance, run.columns["normal_force"], _LOADED, _PART_LOADED)
    return ramp_end_by_friction(distance, mu)


def _at_rest(distance: Column) -> NDArray[np.bool_]:
    """Return a mask of the samples recorded while the bodies did not slide: their friction belongs to no distance.

    It selects no sample if the distance is missing in part or does not increase.
    """
    if not len(distance) or not np.all(np.isfinite(distance)) or not distance[-1] > distance[0]:
        return np.zeros(len(distance), dtype=bool)
    mean = (distance[-1] - distance[0]) / (len(distance) - 1)
    unit = _resolution(distance)
    span = max(_SHORTEST_REST, math.ceil(2 * unit / (_AT_REST * mean)))
    still = (distance[span:] - distance[:-span] + unit < _AT_REST * span * mean).astype(int)
    # Each such span begins one range of samples at rest and ends it after its last sample.
    begun = np.zeros(len(distance) + 1, dtype=int)
    begun[: len(still)] += still
    begun[span + 1 : span + 1 + len(still)] -= still
    return np.asarray(np.cumsum(begun)[:-1] > 0)


def _resolution(distance: Column) -> float:
    """Return by how much a distance increases at least, m, where it stays the same more often than a test is stopped.

    It is then recorded in coarse digits, or in counted laps; 0 elsewhere.
    """
    steps = np.diff(distance)
    stays = int(np.sum(np.diff(np.flatnonzero(steps)) > 1))
    return float(np.min(steps[steps > 0])) if stays > _MOST_STOPS else 0.0


def _fit_window(distance: Column, mu: Column) -> FrictionFit:
    if len(mu) < _FEWEST_SAMPLES:
        return FrictionFit(outcome="none", notes=(f"{len(mu)} friction samples are too few to fit",))
    window = (meters(float(distance[0])), meters(float(distance[-1])))
    if np.median(mu) < 0:
        return _steady_only(mu, ("friction is negative: check the sign of the friction force",), window)
    if window[0].value == window[1].value:
        return _steady_only(mu, ("the sliding distance does not increase: check speed or clock",), window)
    if np.ptp(mu) == 0:
        return _steady_only(mu, ("friction is constant: check whether the channel was on",), window)
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
        running_in_distance=meters(fit.running_in, float(spread[2])),
        covariance=tuple(tuple(row) for row in fit.covariance.tolist()),
        window=window,
        residual_deviation=_ratio(float(np.std(fit.residuals, ddof=3))),
        effective_samples=fit.independent,
    )


def _steady_only(mu: Column, reasons: tuple[str, ...], window: tuple[Quantity, Quantity] | None) -> FrictionFit:
    later = mu[len(mu) // 2 :]
    mean, deviation = float(np.mean(later)), float(np.std(later, ddof=1))
    independent = effective_samples(later)
    variance = float(parameter_covariance(np.ones((1, len(later))), later - mean, independent)[0, 0])
    return FrictionFit(
        outcome="steady-only",
        notes=(*reasons, "the steady-state value is the mean of the second half"),
        steady_state=_ratio(mean, math.sqrt(variance)),
        window=window,
        residual_deviation=_ratio(deviation),
        effective_samples=independent,
    )


def _fit_exponential(distance: Column, mu: Column) -> _Exponential:
    """Fit (A, b, c) by bounded least squares: nearly, to means over stretches of samples, then to all of them."""
    bounds = _bounds(distance, mu)
    start = _best_start(distance, mu, bounds)
    found = _settled(distance, mu, start, np.full(3, True))
    if not (found.last_step < _SETTLED and np.all((bounds[0] < found.parameters) & (found.parameters < bounds[1]))):
        found = _within(bounds, distance, mu, start)
    amplitude, steady, log_c = found.parameters.tolist()
    slopes = _decays(distance, log_c)[:3] * [[1.0], [1.0], [amplitude / math.exp(log_c)]]
    independent = effective_samples(found.residuals)
    return _Exponential(
        parameters=np.array([amplitude, steady, math.exp(log_c)]),
        covariance=parameter_covariance(slopes, found.residuals, independent),
        residuals=found.residuals,
        independent=independent,
        shortest=math.exp(bounds[0, 2]),
        longest=math.exp(bounds[1, 2]),
    )


def _bounds(distance: Column, mu: Column) -> Column:
    """Return the least and the largest A, b and ln c."""
    shortest, longest = _running_in_bounds(distance)
    largest = 10 * float(np.ptp(mu)) + float(np.max(np.abs(mu)))
    return np.array([[-largest, 0.0, math.log(shortest)], [largest, largest, math.log(longest)]])


class _Minimum(NamedTuple):
    """Minimum of the sum of squares: A, b and ln c, and the residuals there."""

    parameters: Column
    residuals: Column
    normal: Column
    """JᵀJ of the derivatives of the curve by the parameters."""
    last_step: float


def _within(bounds: Column, distance: Column, mu: Column, start: Column) -> _Minimum:
    """Search for the least sum of squares where it lies on the bounds or far from where the search starts."""
    from scipy.optimize import least_squares

    largest = bounds[1, 1]
    found = least_squares(
        lambda p: p[:2] @ _decays(distance, p[2])[:2] - mu,
        np.clip(start, [-largest, 1e-12, bounds[0, 2] + 1e-9], [largest, largest, bounds[1, 2] - 1e-9]),
        jac=lambda p: (_decays(distance, p[2])[:3] * [[1.0], [1.0], [p[0]]]).T,
        bounds=bounds,
        x_scale=[max(abs(start[0]), 1e-6), max(abs(start[1]), 1e-6), 1.0],
        xtol=1e-12,
        ftol=1e-12,
        gtol=1e-12,
    )
    return _settled(distance, mu, found.x, found.active_mask == 0)


def _settled(distance: Column, mu: Column, start: Column, free: NDArray[np.bool_]) -> _Minimum:
    """Take Newton's steps in the free parameters for as long as they get shorter.

    A search that stops where the sum of squares no longer falls knows its minimum to half of the digits only: which
    others it ends on depends on the order in which the processor adds.
    """
    p, longest = start.copy(), _NEARLY_SETTLED
    while True:
        decays, scale = _decays(distance, p[2]), np.array([1.0, 1.0, p[0]])
        residuals = p[:2] @ decays[:2] - mu
        normal = np.vecdot(decays[:3, None], decays[:3]) * np.outer(scale, scale)
        gradient, (twist, bend) = scale * (decays[:3] @ residuals), decays[2:] @ residuals
        curvature = normal + np.array([[0.0, 0.0, twist], [0.0, 0.0, 0.0], [twist, 0.0, p[0] * (bend - twist)]])
        step = np.linalg.lstsq(curvature[np.ix_(free, free)], gradient[free], rcond=None)[0]
        largest = max(abs(p[0]), abs(p[1]), _SMALL)
        size = float(np.linalg.norm(step / np.array([largest, largest, 1.0])[free]))
        if not size < longest:
            return _Minimum(p, residuals, normal, longest)
        p[free] -= step
        longest = size


def _decays(distance: Column, log_c: float) -> Column:
    """Return exp(−x), 1, x·exp(−x) and x²·exp(−x) with x = s/c, one row each.

    The derivatives of A·exp(−x) + b by A, b and ln c are the first three, the third times A; that of x·exp(−x) by ln c
    is the fourth less the third.
    """
    x = distance / math.exp(log_c)
    decay = np.exp(-x)
    slope = x * decay
    return np.stack([decay, np.ones_like(decay), slope, x * slope])


def _running_in_bounds(distance: Column) -> tuple[float, float]:
    steps = np.diff(distance)
    spacing = float(np.median(steps[steps > 0]))
    length = float(distance[-1] - distance[0])
    return min(_SHORTEST_RUNNING_IN * spacing, length / 4), _LONGEST_RUNNING_IN * length


def _best_start(distance: Column, mu: Column, bounds: Column) -> Column:
    """Try a ladder of c, and finer ones between the neighbors of the best; for each, A and b follow in closed form.

    On means over stretches of samples, short compared with their distance from the first: where a decay is as short as
    that, nothing is left of it.
    """
    first = np.unique(np.geomspace(1, len(mu), _STRETCHES).astype(int)) - 1
    first = first[first < len(mu)]
    counts = np.diff(np.append(first, len(mu)))
    place, mean = np.add.reduceat(distance, first) / counts, np.add.reduceat(mu, first) / counts
    best = np.array([0.0, float(np.mean(mu)), bounds[1, 2]])
    ladder = np.linspace(bounds[0, 2], bounds[1, 2], _STARTS)
    for _ in range(_LADDERS):
        powers, amplitudes, steadies = _linear_fits(np.exp(-place / np.exp(ladder)[:, None]), mean, counts / len(mu))
        powers[steadies < 0] = np.inf
        rung = int(np.argmin(powers))
        if np.isfinite(powers[rung]):
            best = np.array([amplitudes[rung], steadies[rung], ladder[rung]])
        ladder = np.linspace(ladder[max(rung - 1, 0)], ladder[min(rung + 1, len(ladder) - 1)], _STARTS)
    return best


def _linear_fits(decays: Column, mu: Column, weights: Column) -> tuple[Column, Column, Column]:
    """Return for each decay, a row, the mean square left by A·decay + b fitted to μ, less one of μ, and A and b."""
    middle, steady = decays @ weights, float(mu @ weights)
    centred = decays - middle[:, None]
    variance, covariance = np.square(centred) @ weights, centred @ (weights * (mu - steady))
    amplitude = np.divide(covariance, variance, out=np.zeros_like(variance), where=variance > 0)
    return -amplitude * covariance, amplitude, steady - amplitude * middle


def _reasons_against(fit: _Exponential, distance: Column, mu: Column) -> tuple[str, ...]:
    """Report why the exponential cannot be distinguished from the data; nothing where it can."""
    power = float(fit.residuals @ fit.residuals)
    place, level = distance - np.mean(distance), mu - np.mean(mu)
    slope = float(place @ level) / float(place @ place)
    constant, straight = float(level @ level), float(np.sum((level - slope * place) ** 2))
    c, spread = fit.running_in, math.sqrt(fit.covariance[2, 2])
    if _evidence(power, constant, fit.independent, 2) < _DECISIVE:
        return ("running-in cannot be distinguished from a constant",)
    if _evidence(power, straight, fit.independent, 1) < _DECISIVE or c > 0.99 * fit.longest:
        change = slope * float(distance[-1] - distance[0])
        return (f"friction changes linearly, by {change:+.3f} over the fitted distance, not exponentially",)
    if fit.parameters[0] + fit.parameters[1] < -_CLEARLY * math.sqrt(fit.covariance[:2, :2].sum()):
        return ("the exponential would start at a negative friction",)
    if c - _SURELY * spread < fit.shortest:
        return (f"the decay may be shorter than {_SHORTEST_RUNNING_IN:.0f} samples",)
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
    if distance[0] > _EXTRAPOLATED * fit.running_in:
        begun, left = show(float(f"{distance[0]:.3g}"), None, "m"), math.exp(-distance[0] / fit.running_in)
        notes.append(
            f"A is extrapolated to the start of the sliding distance: at {begun}, where the fit begins, μ differs by "
            f"{left * fit.parameters[0]:.2g} from the steady state"
        )
    if fit.running_in > length:
        notes.append(
            f"the running-in distance of {show(fit.running_in, None, 'm')} exceeds the fitted length of "
            f"{show(length, None, 'm')}: the steady state is an extrapolation"
        )
    if fit.parameters[0] < 0:
        notes.append("friction increases from the start")
    return tuple(notes)


def _ratio(value: float, spread: float | None = None) -> Quantity:
    return Quantity(value=value, unit="1", standard_uncertainty=spread)
