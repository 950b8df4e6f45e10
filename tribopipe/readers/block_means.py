"""Means of consecutive samples, which stand for a recording that is too long to be held.

Least squares on means of n samples each is least squares on what the samples state about a curve that bends little
within n.
So that restarts and faults of an axis stay what they are, the samples on both sides of a place where one goes back
stand alone, and so do the first and the last of all. Missing samples are left out of means, and so are error codes: a
thousand times what is usual, in the midst of samples that are not.
"""

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tribopipe.base.arrays import Column
from tribopipe.documents.manifest import RunManifest
from tribopipe.documents.signals import SignalName
from tribopipe.evaluation.preprocessing.workbench import fewer

MOST = 1_000_000
"""Means that stand for a recording, about."""
_IN_A_STROKE = 20
"""Samples that a stroke of a test there and back is left with at least."""
_FAR_OFF = 1000.0
"""An error code is so many times as large as nine tenths of the samples about it."""
_AXES: tuple[SignalName, ...] = ("time", "rotations", "sliding_distance")

Places = NDArray[np.int64]
Name = str | int
Block = Mapping[Name, NDArray[Any]]
"""Columns of one length, signals by their names and others by number: numbers, of which NaN are missing, or texts."""


def samples_in_a_mean(rows: int, manifest: RunManifest, first: Mapping[SignalName, Column]) -> int:
    """Return how many of so many samples to take the mean of, by the ``first`` of them: 1 to hold them all."""
    wanted = max(1, -(-rows // MOST))
    if manifest.conditions.stroke is None:
        return wanted
    return max(1, min(wanted, _samples_in_a_stroke(manifest, first) // _IN_A_STROKE))


def _samples_in_a_stroke(manifest: RunManifest, first: Mapping[SignalName, Column]) -> int:
    """Return how many samples one stroke has; 0 where nothing shows."""
    stroke, speed = manifest.conditions.stroke, manifest.conditions.nominal_speed
    if stroke is None:
        return 0
    if "sliding_distance" in first:
        length, axis = stroke.value, first["sliding_distance"]
    elif "time" in first and speed is not None:
        length, axis = stroke.value / speed.value, first["time"]
    else:
        return 0
    steps = np.diff(axis)
    growing = steps[steps > 0]
    return round(length / float(np.median(growing))) if len(growing) else 0


class Means:
    """Means of columns that come in blocks: the same whatever the blocks are, but for what is an error code in one."""

    rows: int
    """Samples that were added, once all are."""

    def __init__(self, samples: int, axes: Sequence[str] = _AXES) -> None:
        """Take means of so many ``samples``; ``axes`` are the columns that should grow."""
        self._samples, self._axes = samples, axes
        self._rows = 0
        self._carried: dict[Name, NDArray[Any]] = {}
        self._first_alone = True
        self._means: dict[Name, list[NDArray[Any]]] = {}
        self._starts: list[Places] = [np.empty(0, np.int64)]

    def add(self, block: Mapping[Any, NDArray[Any]]) -> None:
        """Add a block of samples, a ``Block``; those since the last whole mean wait for more."""
        if not self._carried:
            self._carried = {name: values[:0] for name, values in block.items()}
        joined = {name: np.concatenate([self._carried[name], values]) for name, values in block.items()}
        starts, alone = self._places(joined)
        last = int(starts[-1])
        self._take(joined, starts[:-1], last)
        self._carried = {name: values[last:].copy() for name, values in joined.items()}
        self._first_alone = last + 1 in alone
        self._rows += last

    def finish(self) -> tuple[dict[Name, NDArray[Any]], Places]:
        """Return the means of each column, and how many samples were added before each of them."""
        length = len(next(iter(self._carried.values())))
        self._take(self._carried, np.unique([0, length - 1]), length)
        self.rows = self._rows + length
        found = {name: np.concatenate(self._means.pop(name)) for name in list(self._means)}  # one after the other freed
        return found, np.concatenate(self._starts)

    def _places(self, block: Block) -> tuple[Places, set[int]]:
        """Return where means begin, and where one has to, whatever stands before it."""
        length = len(next(iter(block.values())))
        forced = {0, 1} if self._first_alone else {0}
        for name in self._axes:
            if name in block:
                falls = np.flatnonzero(block[name][1:] < block[name][:-1]) + 1
                forced.update(falls.tolist(), (falls - 1).tolist(), (falls + 1).tolist())
        bounds = [*sorted(place for place in forced if place < length), length]
        starts = [np.arange(start, end, self._samples) for start, end in pairwise(bounds)]
        return np.concatenate(starts), forced

    def _take(self, block: Block, starts: Places, end: int) -> None:
        if not len(starts):
            return
        counts = np.diff(starts, append=end)
        self._starts.append(starts + self._rows)
        for name, values in block.items():
            part = values[:end]
            mean = part[starts] if part.dtype == object else _means(part, starts, counts, axis=name in self._axes)
            self._means.setdefault(name, []).append(mean)


def _means(values: Column, starts: Places, counts: Places, *, axis: bool) -> Column:
    """Return the mean of each stretch; of an axis that of all its samples, missing where one is."""
    if len(starts) == len(values):
        return values.copy()
    if axis:
        return np.asarray(np.add.reduceat(values, starts) / counts)
    known = _without_codes(values, starts, counts)
    seen = np.isfinite(known)
    sums, found = np.add.reduceat(np.where(seen, known, 0.0), starts), np.add.reduceat(seen, starts, dtype=np.int64)
    means = np.divide(sums, found, out=np.full(len(starts), np.nan), where=found > 0)
    # What does not change has itself as its mean, to the last digit.
    return np.asarray(np.clip(means, np.fmin.reduceat(known, starts), np.fmax.reduceat(known, starts)))


def _without_codes(values: Column, starts: Places, counts: Places) -> Column:
    """Make error codes missing. Where all samples of a stretch are so large, a level may have changed: they stay."""
    size = np.abs(values)
    some = fewer(size)
    limit = _FAR_OFF * float(np.percentile(some, 90)) if len(some) else 0.0
    beyond = size > limit
    if not limit or not np.any(beyond):
        return values
    mixed = np.add.reduceat(beyond, starts, dtype=np.int64) < counts
    return np.where(beyond & np.repeat(mixed, counts), np.nan, values)
