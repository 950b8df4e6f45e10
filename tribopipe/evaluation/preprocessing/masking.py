"""Samples made missing: values that no sensor can have seen, limits, lone spikes, friction without a load.

Impossible values, sentinels, dead load channels and limits of a recipe. Spikes are lone samples far off their
neighbors (F. R. Hampel, Journal of the American Statistical Association 69 (1974) 383). Friction coefficients without
a load to speak of are a quotient of two noises, without information on friction.
"""

import numpy as np

from tribopipe.base.arrays import MAD_TO_DEVIATION, Column, robust_deviation
from tribopipe.documents.preprocessing import Despike, Mask, SignalLimits, UnloadedFriction
from tribopipe.documents.signals import AXES, SIGNALS, SignalName
from tribopipe.evaluation.preprocessing.workbench import Bench, Selection, fewer


def mask_spikes(bench: Bench, step: Despike) -> None:
    """Mask the spikes of measured signals."""
    for name in step.signals:
        values = bench.measured(name)
        if values is not None:
            what = f"more than {step.threshold:g} standard deviations from the median of {step.window} samples"
            bench.mask(name, spikes(values, step.window, step.threshold), what, "a spike")


def spikes(values: Column, window: int, threshold: float) -> Selection:
    """Find the spikes of a signal; missing samples are passed over."""
    from scipy.ndimage import median_filter

    seen = np.isfinite(values)
    known = values[seen]
    found = np.zeros(len(values), dtype=bool)
    if len(known) <= window:
        return found
    off = np.abs(known - median_filter(known, size=window, mode="reflect"))
    local = MAD_TO_DEVIATION * median_filter(off, size=window, mode="reflect")
    steps = np.abs(np.diff(known))
    finest = float(np.min(steps[steps > 0], initial=np.inf))
    least = max(robust_deviation(off), finest if np.isfinite(finest) else 0.0)
    found[seen] = off > threshold * np.maximum(local, least)
    return found


MOST_FRICTION = 10.0
"""No pair of bodies that slide has a friction coefficient beyond."""
_IMPOSSIBLE: dict[SignalName, tuple[float, float, str]] = {
    "relative_humidity": (0.0, 1.0, "outside 0 to 100 %"),
    "temperature": (0.0, 3000.0, "outside 0 to 3000 K"),
    "friction_coefficient": (-MOST_FRICTION, MOST_FRICTION, "beyond ±10"),
}
_FAR_OFF = 1000.0
"""A sentinel is this many times larger than nine tenths of the samples."""
_TWICE = 2
_MOST_ZEROS, _FAR_FROM_ZERO = 2, 10.0
"""Zeros next to each other that nothing measured, and typical differences of samples by which the others are off zero.
"""
_DEAD_SHARE = 0.05
_NOISE = 3.0
"""A channel whose mean is within so many standard deviations of zero reads nothing but noise."""


def mask_samples(bench: Bench, step: Mask) -> None:
    """Mask in every measured signal what cannot have been seen, and what lies outside the limits a lab states."""
    for name in tuple(bench.columns):
        values = bench.measured(name)
        if values is None:
            continue
        if step.impossible and name in _IMPOSSIBLE:
            low, high, words = _IMPOSSIBLE[name]
            bench.mask(name, (values < low) | (values > high), words, "physically impossible")
        if step.impossible and name not in AXES and (values := bench.measured(name)) is not None:
            bench.mask(
                name,
                _sentinels(values),
                f"repeated and {_FAR_OFF:g} times as large as the rest",
                "a placeholder for missing values",
            )
            if (values := bench.measured(name)) is not None:
                what = f"exactly zero between values more than {_FAR_FROM_ZERO:g} steps away"
                bench.mask(name, _lone_zeros(values), what, "a placeholder for missing values")
        if name in step.limits and (values := bench.measured(name)) is not None:
            _mask_beyond(bench, name, values, step.limits[name])
    if step.impossible:
        _leave_out_dead_load(bench)


def _mask_beyond(bench: Bench, name: SignalName, values: Column, limits: SignalLimits) -> None:
    ends = ((limits.lowest, np.less, "below"), (limits.highest, np.greater, "above"))
    for limit, beyond, word in ends:
        if limit is not None:
            shown = limit.shown("degC" if SIGNALS[name].kind == "temperature" else None)
            bench.mask(name, beyond(values, limit.value), f"{word} {shown}", "limit set in the recipe")
            values = bench.columns.get(name, values)


def _sentinels(values: Column) -> Selection:
    """Find values far beyond all others that stand there more than once, of either sign."""
    size = np.abs(values)
    typical = float(np.percentile(fewer(size), 90)) if len(fewer(size)) else 0.0
    beyond = size > _FAR_OFF * typical
    if not typical or not np.any(beyond):
        return np.zeros(len(values), dtype=bool)
    found, counts = np.unique(size[beyond], return_counts=True)
    return np.isin(size, found[counts >= _TWICE])


def _lone_zeros(values: Column) -> Selection:
    """Find zeros, one or two at a time, next to which all samples are of one sign and far from zero: lost ones."""
    lone = np.zeros(len(values), dtype=bool)
    if np.count_nonzero(values == 0) < _TWICE:
        return lone
    seen = np.isfinite(values) & (values != 0)
    known, place = values[seen], np.flatnonzero(seen)
    if len(known) < 2:
        return lone
    usual = float(np.median(np.abs(np.diff(values[np.isfinite(values)]))))
    far = np.minimum(np.abs(known[:-1]), np.abs(known[1:])) > _FAR_FROM_ZERO * usual
    close = np.diff(place) <= 1 + _MOST_ZEROS
    first = np.flatnonzero(far & close & (known[:-1] * known[1:] > 0))
    for offset in range(1, 1 + _MOST_ZEROS):
        between = place[first] + offset
        lone[between[between < place[first + 1]]] = True
    lone &= values == 0
    return lone if np.count_nonzero(lone) >= _TWICE else np.zeros_like(lone)


def _leave_out_dead_load(bench: Bench) -> None:
    """Go on with the nominal load where the measured one is noise about zero, or too little for any friction."""
    load, friction = bench.measured("normal_force"), bench.measured("friction_force")
    if load is None:
        return
    some, nominal = fewer(load), bench.manifest.conditions.normal_load
    if len(some) < 2 or np.percentile(np.abs(some), 99) >= _DEAD_SHARE * nominal.value:
        return
    within = f"excluded: below {100 * _DEAD_SHARE:.0f} % of the nominal load of {nominal.shown()}"
    if abs(np.mean(some)) <= _NOISE * np.std(some):
        what = f"{within} and about zero throughout"
        bench.leave_out("normal_force", what, "a dead channel; the nominal load is used")
    elif friction is not None and np.nanmedian(np.abs(friction)) > MOST_FRICTION * np.median(np.abs(some)):
        what = f"{within}, and would give friction coefficients beyond ±{MOST_FRICTION:g}"
        why = "a dead channel that was not zeroed, or a wrong unit; the nominal load is used"
        bench.leave_out("normal_force", what, why)


def mask_unloaded_friction(bench: Bench, step: UnloadedFriction) -> None:
    """Mask μ where the measured load is below a share of the nominal one, and where it is out of all reason.

    A load that never reaches half the nominal one is no measure of whether anything pressed: one of both is wrong.
    """
    mu, load, nominal = (
        bench.columns.get("friction_coefficient"),
        bench.measured("normal_force"),
        bench.manifest.conditions.normal_load,
    )
    if mu is None:
        return
    if load is not None and step.share and np.nanmax(load) >= nominal.value / 2:
        what = f"load below {step.share:.3g} of the nominal load of {nominal.shown()}"
        bench.mask("friction_coefficient", load < step.share * nominal.value, what, "no load")
        mu = bench.columns.get("friction_coefficient", mu)
    bench.mask("friction_coefficient", np.abs(mu) > MOST_FRICTION, "beyond ±10", "physically impossible")
