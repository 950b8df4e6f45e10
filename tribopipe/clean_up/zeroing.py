"""Force sensors zeroed on what they read while nothing touches.

When nothing touches, the lab may say. Otherwise the measured load tells: a run that begins or ends on a level stretch,
from which the load then goes off by at least half the nominal load, did so without contact if that stretch reads zero,
or less than zero seen in the direction of loading. A level above zero may be a small load, and is left alone.
"""

import math

import numpy as np

from tribopipe.clean_up.bench import Bench, Selection, fewer
from tribopipe.noise import effective_samples
from tribopipe.records.clean_up import Zero
from tribopipe.records.quantity import Quantity
from tribopipe.run import Column

_FEWEST = 10
"""Samples of a level stretch."""
_LEVEL = 0.02
"""Share of the step to the load within which a stretch is level."""
_NOISE = 6.0
"""Or standard deviations of its noise."""
_TRIMMED = 0.1
"""Share of a stretch, next to the loading, that is left out."""
_TOLD = 2.0
"""Standard uncertainties by which a reading differs from zero at least where it is taken off."""


def zero_forces(bench: Bench, step: Zero) -> None:
    """Take the mean reading without contact off each force."""
    where = _stated(bench, step) if step.windows else _unloaded(bench)
    for name in step.signals:
        force = bench.measured(name)
        seen = force[where & np.isfinite(force)] if force is not None and where is not None else np.empty(0)
        if force is None or len(seen) < 2:
            continue
        zero, spread = float(np.mean(seen)), float(np.std(seen, ddof=1))
        uncertainty = spread / math.sqrt(effective_samples(seen))
        if abs(zero) > max(_TOLD * uncertainty, 1e-9 * float(np.nanmax(np.abs(force)))):
            offset = Quantity(value=zero, unit="N", standard_uncertainty=uncertainty)
            why = f"mean of {len(seen)} samples {'in the windows stated' if step.windows else 'without contact'}"
            bench.put(name, force - zero, f"zero of {offset.shown('mN')} taken off", why, offset=offset)


def _stated(bench: Bench, step: Zero) -> Selection:
    time = bench.columns["time"]
    inside = np.zeros(len(time), dtype=bool)
    for window in step.windows:
        inside |= (time >= window.start.value) & (time <= window.end.value)
    return inside


def _unloaded(bench: Bench) -> Selection | None:
    """Find the level stretches without contact at either end of the run; none where the load does not tell."""
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


def _level_stretch(load: Column, nominal: float) -> int:
    """Return how many samples the level stretch without contact has with which the record begins; 0 where none."""
    start = load[:_FEWEST]
    if not np.all(np.isfinite(start)):
        return 0
    level, noise = float(np.median(start)), float(np.std(start))
    low, high = np.percentile(fewer(load), [5, 95])
    step = float(max(high - level, low - level, key=abs))
    away = math.copysign(1.0, step)
    if abs(step) < nominal / 2 or level * away > noise:
        return 0
    off = np.flatnonzero(np.abs(load - level) > max(_NOISE * noise, _LEVEL * abs(step)))
    length = int((1 - _TRIMMED) * (off[0] if len(off) else len(load)))
    return length if length >= _FEWEST else 0
