"""Force signals: signs, and zeros taken from what a sensor reads while nothing touches.

Compressive loads and friction in one direction are positive, and the signals named in the recipe are inverted.

When nothing touches, the lab may state. Otherwise the measured load shows: a run that begins or ends on a level
stretch, from which the load then goes off by at least half the nominal load, did so without contact if that stretch
reads zero, or less than zero seen in the direction of loading. A level above zero may be a small load, and is left
alone. Where it is at most a fiftieth of the load, a friction force of more than twice this level is no friction of it,
and is subtracted. A level that is no nearer to zero than half the step to the load is left alone, since it may be the
load itself, upside down.

A zero that is clearly different after the test has moved with it. It is interpolated linearly in time, and is as
uncertain as if it had moved at any one moment in between.
"""

import math

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.base.units import show
from tribopipe.documents.preprocessing import FrictionSign, Invert, PressingLoad, Zero
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.signals import SignalName
from tribopipe.evaluation.preprocessing.workbench import Bench, Selection, fewer
from tribopipe.physics.autocorrelation import effective_samples

_LEAST_LOAD = 0.05
"""Share of the nominal load that a load measured upside down has at least."""
_ONE_WAY = 0.9
"""Share of the samples with friction that have the same sign in a test in one direction."""
_FRICTIONS: tuple[SignalName, ...] = ("friction_force", "friction_coefficient")


def pulls(load: Column, nominal: float) -> bool:
    """Return whether a load reads negative where it is on, by at least a twentieth of the nominal load."""
    some = fewer(load)
    if not len(some) or np.min(some) >= 0:
        return False
    on = some[np.abs(some) >= np.percentile(np.abs(some), 95) / 2]
    return bool(np.median(on) < -_LEAST_LOAD * nominal)


def turn_load(bench: Bench, _: PressingLoad) -> None:
    """Turn a load over that reads negative where it is on."""
    load = bench.measured("normal_force")
    if load is not None and pulls(load, bench.manifest.conditions.normal_load.value):
        bench.put("normal_force", -load, "sign inverted", "negative under load", factor=-1.0)


def turn_friction(bench: Bench, _: FrictionSign) -> None:
    """Turn friction over that reads negative throughout a test in one direction."""
    if bench.manifest.conditions.stroke is not None:
        return
    for name in _FRICTIONS:
        friction = bench.measured(name)
        if friction is not None and _is_negative(friction):
            bench.put(name, -friction, "sign inverted", "negative in a unidirectional test", factor=-1.0)


def invert(bench: Bench, step: Invert) -> None:
    """Turn over what the recipe names, where it was measured."""
    for name in dict.fromkeys(step.signals):
        values = bench.measured(name)
        if values is not None:
            bench.put(name, -values, "sign inverted", "as specified in the recipe", factor=-1.0)
        elif name in bench.columns and bench.origins[name] != "measured":
            bench.leave(name, "sign not inverted, since it was not measured", bench.origins[name])


def _is_negative(friction: Column) -> bool:
    some = fewer(friction)
    if not len(some) or not np.median(some) < 0:
        return False
    rubbing = some[np.abs(some) > 0.2 * np.median(np.abs(some))]
    return bool(np.mean(rubbing < 0) >= _ONE_WAY)


_FEWEST = 10
"""Samples of a level stretch."""
_FEWEST_SEEN = 2
"""Samples by which a zero and its uncertainty can be found."""
_LEVEL = 0.02
"""Share of the step to the load within which a stretch is level."""
_NEARER = 0.5
"""Share of the step to the load by which a level without contact is off zero at most."""
_NOISE = 6.0
"""Or standard deviations of its noise."""
_MOST_FRICTION = 2.0
"""Friction coefficient beyond which a friction force is the zero of its sensor."""
_TRIMMED = 0.1
"""Share of a stretch, next to the loading, that is left out."""
_TOLD = 2.0
"""Standard uncertainties by which a reading differs from zero at least where it is subtracted."""
_MOVED = 5.0
"""Standard uncertainties of their difference by which a zero differs after the test at least if it has moved."""
_ENDS = (0, -1)


def zero_forces(bench: Bench, step: Zero) -> None:
    """Subtract the mean reading without contact from each force, and derive friction recorded with them again."""
    where = _stated(bench, step) if step.windows else _unloaded(bench)
    if where is None:
        return
    why = "in the stated windows" if step.windows else "without contact"
    names = step.signals if step.windows else [name for name in step.signals if not _may_be_a_load(bench, name, where)]
    zeroed = [name for name in names if _zeroed(bench, name, where, why)]
    if zeroed and bench.measured("friction_force") is not None and bench.measured("friction_coefficient") is not None:
        what = "the recorded coefficient is replaced by one calculated from the zeroed forces"
        bench.leave_out("friction_coefficient", what, "the instrument calculates it from forces that are not zeroed")


def _zeroed(bench: Bench, name: SignalName, where: Selection, why: str) -> bool:
    """Subtract from a force its mean reading where nothing touches; return whether that was possible."""
    force = bench.measured(name)
    if force is None:
        return False
    seen = force[where & np.isfinite(force)]
    if len(seen) < _FEWEST_SEEN:
        samples = "1 sample" if len(seen) == 1 else f"{len(seen)} samples"
        bench.leave(name, f"not zeroed: {samples} {why}; expected at least {_FEWEST_SEEN}", "too few")
        return False
    moved = _moving_zero(bench.columns["time"], force, where)
    zero, offset = _steady_zero(seen) if moved is None else moved
    if abs(offset.value) <= max(_TOLD * offset.u_or_zero, 1e-9 * float(np.nanmax(np.abs(force)))) and moved is None:
        return False
    first, last = (show(float(f"{end:.3g}"), None, "N", "mN") for end in (zero[0], zero[-1]))
    shown = offset.shown("mN") if moved is None else f"{first} to {last}"
    bench.put(name, force - zero, f"zero of {shown} subtracted", f"mean of {len(seen)} samples {why}", offset=offset)
    return True


def _steady_zero(seen: Column) -> tuple[Column, Quantity]:
    """Return the mean of a force without contact, N, as a column and with its standard uncertainty."""
    zero, spread = float(np.mean(seen)), float(np.std(seen, ddof=1))
    uncertainty = spread / math.sqrt(effective_samples(seen))
    return np.full(1, zero), Quantity(value=zero, unit="N", standard_uncertainty=uncertainty)


def _moving_zero(time: Column, force: Column, where: Selection) -> tuple[Column, Quantity] | None:
    """Return the zero at each sample, N, by those of the stretches without contact, and its mean.

    None where there is only one, or where they do not differ clearly.
    """
    seen = where & np.isfinite(force) & np.isfinite(time)
    stretches = np.split(np.flatnonzero(seen), np.flatnonzero(np.diff(np.flatnonzero(seen)) > 1) + 1)
    stretches = [places for places in stretches if len(places) >= _FEWEST_SEEN]
    if len(stretches) < len(_ENDS):
        return None
    zeros = [_steady_zero(force[places])[1] for places in stretches]
    ends = [zeros[end] for end in _ENDS]
    spread = math.hypot(*(one.u_or_zero for one in ends))
    moved = abs(ends[1].value - ends[0].value)
    if moved <= max(_MOVED * spread, 1e-9 * float(np.nanmax(np.abs(force)))):
        return None
    middles = [float(np.mean(time[places])) for places in stretches]
    zero = np.interp(time, middles, [one.value for one in zeros])
    # At any one moment, with the same probability for each: a rectangular distribution.
    uncertainty = math.hypot(spread, moved / math.sqrt(12))
    return zero, Quantity(value=float(np.nanmean(zero)), unit="N", standard_uncertainty=uncertainty)


def _stated(bench: Bench, step: Zero) -> Selection:
    time = bench.columns["time"]
    inside = np.zeros(len(time), dtype=bool)
    for window in step.windows:
        inside |= (time >= window.start.value) & (time <= window.end.value)
    return inside


def _unloaded(bench: Bench) -> Selection | None:
    """Find the level stretches without contact at either end of the run; None if the load does not show them."""
    load = bench.measured("normal_force")
    if load is None or len(load) < 2 * _FEWEST:
        return None
    nominal = bench.manifest.conditions.normal_load.value
    first, last = _level_stretch(load, nominal), _level_stretch(load[::-1], nominal)
    if first + last == 0 or first + last >= len(load):
        return None
    where = np.zeros(len(load), dtype=bool)
    where[:first] = True
    where[len(load) - last :] = True
    return where


def _may_be_a_load(bench: Bench, name: SignalName, where: Selection) -> bool:
    """Return whether a stretch reads a small load, and the force no more than its friction, or the load itself."""
    load, force = bench.measured("normal_force"), bench.measured(name)
    if load is None or force is None:
        return False
    seen = load[where & np.isfinite(load)]
    pressing = math.copysign(1.0, float(np.nanmedian(load)) - float(np.mean(seen)))
    level = max(pressing * float(np.mean(seen)), 0.0)
    if level <= float(np.std(seen)):
        return False
    return name == "normal_force" or abs(float(np.nanmean(force[where]))) <= _MOST_FRICTION * level


def _level_stretch(load: Column, nominal: float) -> int:
    """Return how many samples the level stretch without contact has with which the record begins; 0 where none."""
    start = load[:_FEWEST]
    if not np.all(np.isfinite(start)):
        return 0
    level, noise = float(np.median(start)), float(np.std(start))
    low, high = np.percentile(fewer(load), [5, 95])
    step = float(max(high - level, low - level, key=abs))
    above = level * math.copysign(1.0, step)
    if abs(step) < nominal / 2 or above > max(noise, _LEVEL * abs(step)) or abs(level) >= _NEARER * abs(step):
        return 0
    off = np.flatnonzero(np.abs(load - level) > max(_NOISE * noise, _LEVEL * abs(step)))
    length = int((1 - _TRIMMED) * (off[0] if len(off) else len(load)))
    return length if length >= _FEWEST else 0
