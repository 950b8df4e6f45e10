"""Axes made continuous: restarts joined, starts carried over from the test before subtracted, idle ends left out.

A distance that follows from the nominal speed counts before the motor starts, and after it stops, unless friction shows
that nothing slides.
"""

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.base.errors import counted
from tribopipe.documents.preprocessing import ContinuousAxes, Idle
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.signals import AXES, SIGNALS, SignalName
from tribopipe.evaluation.preprocessing.workbench import Bench
from tribopipe.physics.axis_faults import continuous, mended, segments

_LATE = 0.05
"""Share of what an axis covers by which it begins later than another one where it was carried over."""
_CLOCK = 100.0
"""Ratio of start to range from which an axis is a clock, or a counter that was not reset."""
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


def join_axes(bench: Bench, step: ContinuousAxes) -> None:
    """Join what restarts, and let what was carried over begin at 0."""
    for name in AXES:
        axis = _without_glitches(bench, name)
        if axis is None:
            continue
        joined = continuous(axis)
        if joined is not axis:
            restarts = len(segments(axis).starts)
            bench.put(name, joined, _count(restarts), "each test has one continuous axis", parts=restarts + 1)
    leads = {name: _lead(axis) for name in AXES if (axis := bench.measured(name)) is not None}
    for name in leads:
        _begin(bench, name, leads, step)


def _without_glitches(bench: Bench, name: SignalName) -> Column | None:
    """Interpolate the glitches of a counter, and return it."""
    axis = bench.measured(name)
    if axis is None or name == "time":
        return axis
    found = mended(axis, bench.measured("time"))
    if found.samples:
        count = len(found.samples)
        what = f"{counted(count, 'wrong reading')} interpolated, the first at {found.samples[0] + 1}"
        bench.put(name, found.values, what, "a counter does not run backward")
    return found.values


def _begin(bench: Bench, name: SignalName, leads: dict[SignalName, float], step: ContinuousAxes) -> None:
    axis = bench.columns[name]
    first = axis[np.isfinite(axis)][0]
    other = min((lead for one, lead in leads.items() if one != name), default=np.inf)
    covered = np.nanmax(axis) - first
    if step.carried_over == "always":
        start, why = first, "carried over from an earlier test, as stated in the recipe"
    elif step.carried_over == "auto" and min(leads[name], other) > _CLOCK:
        start, why = first, f"a clock or counter that was not reset: its first value exceeds {_CLOCK:g} times its range"
    elif step.carried_over == "auto" and leads[name] - max(other, 0.0) > _LATE:
        start, why = first - max(other, 0.0) * covered, "carried over from an earlier test, as another axis shows"
    else:
        return
    if start:
        offset = Quantity(value=float(start), unit=SIGNALS[name].unit)
        bench.put(name, axis - start, f"initial value of {offset} subtracted", why, offset=offset)


def _lead(axis: Column) -> float:
    """Return the first value as a share of what the axis covers."""
    seen = axis[np.isfinite(axis)]
    covered = np.max(seen) - seen[0]
    return float(seen[0] / covered) if covered > 0 else 0.0


def _count(restarts: int) -> str:
    return "joined at the only restart" if restarts == 1 else f"joined at {restarts} restarts"


def leave_out_idle(bench: Bench, _: Idle) -> None:
    """Let a distance by the nominal speed stand still, and mask the depth, before friction begins and after it ends."""
    rubbed = _rubbed(bench) if bench.origins["sliding_distance"] == "derived from nominal speed" else None
    if rubbed is None:
        return
    first, last = rubbed
    distance = bench.columns["sliding_distance"]
    idle = np.ones(len(distance), dtype=bool)
    idle[first : last + 1] = False
    start = distance[first - 1] if first else 0.0
    slid = np.clip(distance, start, distance[min(last + 1, len(distance) - 1)]) - start
    left_out = Quantity(value=float(np.ptp(distance) - np.ptp(slid)), unit="m")
    why = f"no friction in {counted(int(np.count_nonzero(idle)), 'sample')} at the ends: nothing slides"
    bench.put("sliding_distance", slid, f"{left_out.shown('m')} left out", why, offset=left_out)
    if "depth" in bench.columns:
        bench.mask("depth", idle, "without sliding", "no friction")


def _rubbed(bench: Bench) -> tuple[int, int] | None:
    """Return the first and last sample with friction; None where that is the whole recording, or is not known."""
    from scipy.ndimage import median_filter

    names: tuple[SignalName, ...] = ("friction_force", "friction_coefficient")
    friction = next((values for name in names if (values := bench.measured(name)) is not None), None)
    if friction is None:
        return None
    nominal = bench.manifest.conditions.normal_load.value if bench.measured("friction_force") is not None else 1.0
    size, slippery = np.abs(friction), _SLIPPERY * nominal
    least = min(_STILL * float(np.nanpercentile(size, _USUAL)), _NOISY * slippery)
    # A missing sample shows no standstill.
    rubbing = median_filter(np.where(np.isnan(size), np.inf, size), size=_AROUND, mode="nearest") > least
    if not np.any(rubbing):
        return None
    first, behind = (
        idle if idle >= _FEWEST_IDLE and abs(float(np.mean(end[:idle]))) < slippery else 0
        for end, idle in ((friction, int(np.argmax(rubbing))), (friction[::-1], int(np.argmax(rubbing[::-1]))))
    )
    return (first, len(size) - 1 - behind) if first or behind else None
