"""Ends of a recording at which nothing slides under the whole load.

A distance that follows from the nominal speed counts before the motor starts, and after it stops, unless friction shows
that nothing slides. What a depth sensor reads there, or while the load comes on or goes off, is displacement of the
specimens, not wear.
"""

import math

import numpy as np

from tribopipe.base.arrays import Column, robust_deviation
from tribopipe.base.errors import counted
from tribopipe.documents.preprocessing import Idle
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.signals import SignalName
from tribopipe.evaluation.preprocessing.workbench import Bench, Selection, fewer

_STILL, _SLIPPERY = 0.05, 0.01
"""Share of the usual friction, and mean friction coefficient, below which bodies do not touch or do not move."""
_NOISY = 2.0
"""Multiple of that coefficient which the noise of a friction of nothing may reach."""
_USUAL = 75
"""Percentile of the friction that is the usual one, also of a recording half of which is idle."""
_AROUND = 5
"""Samples over whose median a single one does not count."""
_FEWEST_IDLE = 2
"""Samples without friction at an end of a recording that are no loading."""
_RAMP_SHARE = 0.05
"""A loading ramp takes at most this share of a run."""
_LOADED = 0.98
"""Share of the usual load from which on the displacement by what is left of it is small next to wear."""
_ABOVE_NOISE = 3.0
"""Standard deviations of the noise of a load that a single sample of it may lie below."""


def leave_out_idle(bench: Bench, _: Idle) -> None:
    """Mask the depth at idle ends and ramps of the load, and let a distance by the nominal speed stand still there."""
    distance, rubbed = bench.columns["sliding_distance"], _rubbed(bench)
    idle = _outside(rubbed, len(distance))
    if rubbed is not None and bench.origins["sliding_distance"] == "derived from nominal speed":
        first, last = rubbed
        start = distance[first - 1] if first else 0.0
        slid = np.clip(distance, start, distance[min(last + 1, len(distance) - 1)]) - start
        left_out = Quantity(value=float(np.ptp(distance) - np.ptp(slid)), unit="m")
        why = f"no friction in {counted(int(np.count_nonzero(idle)), 'sample')} at the ends: nothing slides"
        bench.put("sliding_distance", slid, f"{left_out.shown('m')} left out", why, offset=left_out)
    if "depth" in bench.columns:
        idle |= _outside(_moved(bench), len(distance)) | _at_ramps(bench)
        bench.mask("depth", idle, "not sliding under full load", "displacement by loading is no wear")


def _outside(ends: tuple[int, int] | None, count: int) -> Selection:
    """Return which samples are before the first or after the last of a part; none where there is no part."""
    outside = np.zeros(count, dtype=bool)
    if ends is not None:
        outside[: ends[0]] = True
        outside[ends[1] + 1 :] = True
    return outside


def _moved(bench: Bench) -> tuple[int, int] | None:
    """Return the first and last sample of motion by a measured axis; None where that is the whole recording."""
    if bench.origins["sliding_distance"] in ("unknown", "derived from nominal speed"):
        return None
    distance = bench.columns["sliding_distance"]
    moving = np.flatnonzero(np.diff(distance) > 0)
    if not len(moving):
        return None
    first, behind = int(moving[0]), len(distance) - 2 - int(moving[-1])
    first, behind = (idle if idle >= _FEWEST_IDLE else 0 for idle in (first, behind))
    return (first, len(distance) - 1 - behind) if first or behind else None


def _rubbed(bench: Bench) -> tuple[int, int] | None:
    """Return the first and last sample with friction; None where that is the whole recording, or is not known."""
    names: tuple[SignalName, ...] = ("friction_force", "friction_coefficient")
    friction = next((values for name in names if (values := bench.measured(name)) is not None), None)
    if friction is None:
        return None
    nominal = bench.manifest.conditions.normal_load.value if bench.measured("friction_force") is not None else 1.0
    size, slippery = np.abs(friction), _SLIPPERY * nominal
    least = min(_STILL * float(np.percentile(fewer(size), _USUAL)), _NOISY * slippery)
    # A missing sample shows no standstill.
    around = np.pad(np.isnan(size) | (size > least), _AROUND // 2, mode="edge")
    rubbing = np.convolve(around, np.ones(_AROUND), mode="valid") > _AROUND / 2
    if not np.any(rubbing):
        return None
    first, behind = (
        idle if idle >= _FEWEST_IDLE and abs(float(np.mean(end[:idle]))) < slippery else 0
        for end, idle in ((friction, int(np.argmax(rubbing))), (friction[::-1], int(np.argmax(rubbing[::-1]))))
    )
    return (first, len(size) - 1 - behind) if first or behind else None


def _at_ramps(bench: Bench) -> Selection:
    """Return which samples are of a ramp of the load at either end."""
    distance = bench.columns["sliding_distance"]
    if not np.all(np.isfinite(distance)):
        return np.zeros(len(distance), dtype=bool)
    slid = distance - distance[0]
    left = slid[-1] - slid
    return np.asarray((slid < _ramp_end(bench, slid, 1)) | (left < _ramp_end(bench, left[::-1], -1)))


def _ramp_end(bench: Bench, distance: Column, step: int) -> float:
    """Return how far from an end, m, a ramp of the load reaches; the columns are taken with ``step``."""
    load, mu = bench.measured("normal_force"), bench.columns.get("friction_coefficient")
    if load is not None:
        steps, usual = np.diff(load), float(np.nanmedian(load))
        if not usual > 0:
            return 0.0
        noise = robust_deviation(steps[np.isfinite(steps)]) / math.sqrt(2) / usual
        return ramp_end_by_load(distance, load[::step], min(_LOADED, 1 - _ABOVE_NOISE * noise))
    return 0.0 if mu is None else ramp_end_by_friction(distance, np.abs(mu[::step]))


def ramp_end_by_load(distance: Column, load: Column, share: float, slowly: float = 0.0) -> float:
    """Return the sliding distance, m, at which a load first reaches a share of its median; 0 where there is no ramp.

    Where that takes more than 5 % of the run, it is the share ``slowly`` that counts.
    """
    usual = np.nanmedian(load)
    loaded = np.flatnonzero(load >= share * usual)
    if len(loaded) and distance[loaded[0]] > _RAMP_SHARE * distance[-1]:
        loaded = np.flatnonzero(load >= slowly * usual) if slowly else loaded[:0]
    return float(distance[loaded[0]]) if len(loaded) and loaded[0] > 0 else 0.0


def ramp_end_by_friction(distance: Column, mu: Column) -> float:
    """Return the sliding distance, m, at which friction shows that the load is on; 0 where there is no ramp.

    A ramp starts below half of the later level and crosses that within 5 % of the run; it ends at the highest friction
    within three times the distance of the crossing. A true rise of friction loses only its first metres by this, which
    an exponential does not miss.
    """
    half = 0.5 * float(np.nanmedian(mu))
    crossed = np.flatnonzero(mu >= half)
    if not len(crossed) or distance[crossed[0]] > _RAMP_SHARE * distance[-1] or not np.any(mu[: crossed[0]] < half):
        return 0.0
    first = int(crossed[0])
    until = max(first + 2, int(np.searchsorted(distance, 3 * distance[first], side="right")))
    return float(distance[first + int(np.nanargmax(mu[first:until]))])
