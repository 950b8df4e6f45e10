"""Axes made continuous: restarts joined, starts carried over from the test before subtracted, coarse times spread."""

from collections.abc import Sequence

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
_OFTEN, _COPIED = 0.1, 0.1
"""Share of the samples with the time of the one before, from which on a clock has coarse steps; and share of these in
which all signals are the same as before, from which on they are copies."""


def join_axes(bench: Bench, step: ContinuousAxes) -> None:
    """Join what restarts, let what was carried over begin at 0, and spread the times of a clock with coarse steps."""
    _spread_times(bench)
    for name in AXES:
        axis = _without_glitches(bench, name)
        if axis is None:
            continue
        joined = continuous(axis)
        if joined is not axis:
            starts = segments(axis).starts
            restarts = len(starts)
            _mask_stale(bench, starts[0])
            bench.put(name, joined, _count(restarts), "each test has one continuous axis", parts=restarts + 1)
    leads = {name: _lead(axis) for name in AXES if (axis := bench.measured(name)) is not None}
    for name in leads:
        _begin(bench, name, leads, step)


def _spread_times(bench: Bench) -> None:
    time, others = bench.measured("time"), (bench.measured(name) for name in bench.columns if name not in AXES)
    if time is not None and is_coarse(time, [values for values in others if values is not None]):
        why = "the clock has coarser steps than the sampling"
        bench.put("time", _spread(time), "repeated time stamps replaced by equal intervals", why)


def _spread(time: Column) -> Column:
    starts = np.flatnonzero(np.diff(time, prepend=np.nan) != 0)
    counts = np.diff(starts, append=len(time))
    every = np.diff(time[starts], append=np.nan) / counts
    usual = float(np.median(every[every > 0]))
    # Before a pause, a restart and the end, samples are as far apart as anywhere.
    every = np.where(every > 0, np.minimum(every, usual), usual)
    return time + (np.arange(len(time)) - np.repeat(starts, counts)) * np.repeat(every, counts)


def is_coarse(time: Column, signals: Sequence[Column]) -> bool:
    """Return whether times repeat because the clock has coarser steps than the sampling: often, in rows that differ."""
    repeated = np.flatnonzero(np.diff(time) == 0)
    if len(repeated) == len(time) - 1:
        return False
    same = [values[repeated] == values[repeated + 1] for values in signals]
    copied = float(np.mean(np.all(same, axis=0))) if same and len(repeated) else 1.0
    return len(repeated) > _OFTEN * len(time) and copied < _COPIED


def _mask_stale(bench: Bench, start: int) -> None:
    """Mask the signals of a first sample alone before a restart: it is of the test before, or a row of factors."""
    stale = np.arange(len(bench.columns["time"])) < start
    for name in tuple(bench.columns) if start == 1 else ():
        if name not in AXES and bench.measured(name) is not None:
            bench.mask(name, stale, "before the axes restart", "not of this test")


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
