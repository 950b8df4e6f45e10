"""Steps of a depth reading: where it jumps and stays, as after a knock or when the sensor slips."""

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.physics.autocorrelation import left_of

_BINS = 400
_FEWEST = 60
"""Bins below which a step cannot be distinguished from noise."""
_TERMS = 9
_DECISIVE = 8.0
"""Standard deviations of usual changes from bin to bin beyond which one is a step."""
_LEAST = 2e-4
"""Usual change, over the range of the reading, below which no step matters."""
_KEPT = 0.6
"""Share of a step that has to last."""
_SPAN = 6
"""Bins on either side over which it has to last."""
_MOST = 5
_TO_DEVIATION = 1.4826


def steps(time: Column, progress: Column, depth: Column) -> list[int]:
    """Return the numbers of the samples at which a reading steps.

    Parameters
    ----------
    time, progress, depth
        Time, what wear grows along, and the reading, m, of each sample; shape (samples,).

    Returns
    -------
    list of int
        First sample after each step, ascending; none where there are fewer than 60 samples, or more than five steps,
        which are no steps then but another kind of disturbance.
    """
    edges = np.unique(np.linspace(0, len(time), min(_BINS, len(time)) + 1).astype(int))
    if len(edges) <= _FEWEST:
        return []
    counts = np.diff(edges)
    mean = np.add.reduceat(depth, edges[:-1]) / counts
    root = np.sqrt(np.maximum(np.add.reduceat(progress, edges[:-1]) / counts, 0.0) / progress[-1])
    curves = np.polynomial.chebyshev.chebvander(2 * root - 1, _TERMS).T
    found: list[int] = []
    # The smooth curve rings about a step until it is fitted as one: the next is sought beside all found so far.
    while (place := _largest(left_of(mean, curves)[0], float(np.ptp(mean)), found)) is not None:
        found.append(place)
        curves = np.vstack([curves, np.arange(len(mean)) > place])
        if len(found) > _MOST:
            return []
    return sorted(_sample(depth, edges[place], edges[place + 3]) for place in found)


def _largest(smooth: Column, reach: float, found: list[int]) -> int | None:
    """Return the bin before the largest step of what is left of a reading; none where no change is one."""
    change = smooth[2:] - smooth[:-2]
    center = np.median(change)
    scale = max(_TO_DEVIATION * float(np.median(np.abs(change - center))), _LEAST * reach)
    for place in np.argsort(-np.abs(change - center)).tolist():
        size = change[place] - center
        if abs(size) <= _DECISIVE * scale:
            return None
        if all(abs(place - other) > _SPAN for other in found) and _lasts(smooth, place + 1, size):
            return int(place)
    return None


def _lasts(smooth: Column, middle: int, size: float) -> bool:
    before, after = smooth[max(0, middle - _SPAN) : middle], smooth[middle + 1 : middle + 1 + _SPAN]
    if min(len(before), len(after)) < _SPAN // 2:
        return False
    return bool((np.median(after) - np.median(before)) / size > _KEPT)


def _sample(depth: Column, first: int, last: int) -> int:
    """Return where samples are best divided into two levels."""
    some = depth[first:last]
    count = np.arange(1, len(some))
    before = np.cumsum(some)[:-1] / count
    after = (np.sum(some) - np.cumsum(some)[:-1]) / (len(some) - count)
    return int(first + 1 + np.argmax(np.abs(after - before) * np.sqrt(count * (len(some) - count))))
