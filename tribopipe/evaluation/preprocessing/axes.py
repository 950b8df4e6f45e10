"""Axes made continuous: restarts joined, starts carried over from the test before subtracted."""

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.base.errors import counted
from tribopipe.documents.preprocessing import ContinuousAxes
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.signals import AXES, SIGNALS, SignalName
from tribopipe.evaluation.preprocessing.workbench import Bench
from tribopipe.physics.axis_faults import continuous, mended, segments

_LATE = 0.05
"""Share of what an axis covers by which it begins later than another one where it was carried over."""
_CLOCK = 100.0
"""Ratio of start to range from which an axis is a clock, or a counter that was not reset."""


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
