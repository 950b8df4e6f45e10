"""Faults of axes: time or a counter that restarts within one test, and lone readings of a counter that are wrong.

A step back is a restart where the axis falls back to where its segment began, and grows from there. Anything else,
such as a row out of order or a reading of 0 among others, is a fault of the file, which nothing here corrects.

A revolution counter read while it changes gives 186, 185, 188. Where a clock next to it runs on, the run itself is in
order, and the wrong readings are found between the ones around them.
"""

from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tribopipe.base.arrays import Column

_NEARLY_ALL = 0.9
"""Share of what a segment covered by which an axis falls back at least where it restarts."""
_ABOUT = 0.25
"""Share of a sampling interval within which a segment begins where the one before began."""
_STEPS = 3
"""A fall of fewer sampling intervals is no restart but disorder among samples."""
_LEAP = 10
"""Most sampling intervals by which an axis passes its old end in one."""
_ON_COURSE = 0.75
"""Share of its usual pace at which an axis that passes its old end again has gone on from there all along."""


@dataclass(frozen=True)
class Segments:
    """Restart of an axis."""

    starts: tuple[int, ...] = ()
    """Number of the first sample of each segment but the first; None if the axis falls back otherwise, too."""
    fault: int | None = None
    """First sample at which the axis falls back without restarting."""


def segments(axis: Column) -> Segments:
    """Find where an axis restarts; missing samples are passed over."""
    seen = np.flatnonzero(np.isfinite(axis))
    values = axis if len(seen) == len(axis) else axis[seen]
    falls = np.flatnonzero(values[1:] < values[:-1]) + 1
    bounds = [0, *falls.tolist(), len(values)]
    for start, fall, end in zip(bounds, bounds[1:], bounds[2:], strict=False):
        if not _begins_anew(values[start:fall], values[fall:end]):
            return Segments(fault=int(seen[fall]))
    return Segments(tuple(seen[falls].tolist()))


def _begins_anew(before: Column, after: Column) -> bool:
    if len(before) == 1:
        return len(after) > 1  # a stale reading, of the test or step before
    covered, fall = before[-1] - before[0], before[-1] - after[0]
    usual = _usual_step(before if len(before) > len(after) else after)
    if after[0] > before[0] + _ABOUT * usual and (fall < _NEARLY_ALL * covered or fall < _STEPS * usual):
        return False
    beyond = np.flatnonzero(after > before[-1])
    if not len(beyond):
        return True
    # Where it leaps back to the course it fell from, or is soon on it, the samples between are the fault.
    first = int(beyond[0])
    leap, ahead = after[first] - after[first - 1], after[first] - before[-1]
    return bool(leap <= _LEAP * usual and ahead < _ON_COURSE * (first + 1) * usual)


def _usual_step(axis: Column) -> float:
    steps = np.diff(axis)
    growing = steps[steps > 0]
    return float(np.median(growing)) if len(growing) else 0.0


def continuous(axis: Column) -> Column:
    """Return an axis whose segments follow each other at one median sampling interval of the segment before.

    A first sample alone before a restart is a stale reading: it is placed an interval before the second. An axis
    without restarts, or with faults, is returned as it is.
    """
    starts = segments(axis).starts
    if not starts:
        return axis
    seen = np.isfinite(axis)
    joined = axis[seen]
    bounds = [0, *(int(np.count_nonzero(seen[:start])) for start in starts), len(joined)]
    parts = [joined[start:end].copy() for start, end in pairwise(bounds)]
    if len(parts[0]) == 1:
        lead = parts[1][0] - _interval(parts[0], parts[1])
        parts[0][0] = max(lead, 0.0)
        parts[1] -= min(lead, 0.0)
    for before, after in pairwise(parts if len(parts[0]) > 1 else parts[1:]):
        np.add(after, before[-1] + _interval(before, after) - after[0], out=after)
    result = axis.copy()
    result[seen] = np.concatenate(parts)
    return result


def _interval(before: Column, after: Column) -> float:
    """Return the median sampling interval of a segment, or of the next one where it has but one sample."""
    steps = np.diff(before if len(before) > 1 else after)
    return float(np.median(steps)) if len(steps) else 0.0


_TOGETHER = 2
"""Most wrong readings in a row; more of them are disorder."""
_FAR = 10.0
"""Usual steps by which a lone reading leaps ahead."""
_SHARE = 0.001
"""Share of the readings at which glitches may be; one glitch is always allowed."""


class Mended(NamedTuple):
    """A counter without its glitches, and the samples at which it had them."""

    values: Column
    samples: tuple[int, ...] = ()


def mended(counter: Column, clock: Column | None) -> Mended:
    """Return a counter with glitches interpolated between the readings around them, sample by sample.

    It is returned as it is where there is no clock that runs on, and where more is wrong with it than glitches.
    """
    if clock is None or segments(clock).fault is not None:
        return Mended(counter)
    kept, most = counter.copy(), max(1, int(_SHARE * len(counter))) * _TOGETHER
    kept[_leaps(counter)] = np.nan
    while (fault := segments(kept).fault) is not None:
        wrong = _wrong_readings(kept, fault)
        if not 0 < len(wrong) <= _TOGETHER:
            return Mended(counter)
        kept[wrong] = np.nan
    found, seen = np.flatnonzero(np.isnan(kept) & ~np.isnan(counter)), np.flatnonzero(np.isfinite(kept))
    if not 0 < len(found) <= most or not seen[0] < found[0] <= found[-1] < seen[-1]:
        return Mended(counter)
    kept[found] = np.interp(found, seen, kept[seen])
    return Mended(kept, tuple(found.tolist()))


def _leaps(counter: Column) -> NDArray[np.intp]:
    """Return lone readings far above both neighbors, which a restart is not: it falls below the reading before."""
    before, at, after = counter[:-2], counter[1:-1], counter[2:]
    steps = np.diff(counter)
    growing = steps[steps > 0]
    usual = float(np.median(growing)) if len(growing) else 0.0
    return np.flatnonzero((at > after) & (after >= before) & (at - before > _FAR * usual)) + 1


def _wrong_readings(counter: Column, fault: int) -> NDArray[np.intp]:
    """Return the samples that fall below the previous reading, or those before that jump above it, if fewer."""
    seen = np.flatnonzero(np.isfinite(counter))
    before, after = seen[seen < fault], seen[seen >= fault]
    back = counter[after] >= counter[before[-1]]
    below = after[: int(np.argmax(back))] if np.any(back) else after
    low = counter[before[::-1]] <= counter[fault]
    above = before[len(before) - int(np.argmax(low)) :] if np.any(low) else before
    return above if len(above) < len(below) else below
