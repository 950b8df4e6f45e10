"""Glitches of a counter: a few readings that fall back, or leap ahead, between others that are in order.

A revolution counter read while it changes gives 186, 185, 188. Where a clock next to it runs on, the run itself is in
order, and the wrong readings are found between the ones around them.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tribopipe.base.arrays import Column
from tribopipe.physics.axis_restarts import segments

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
