"""Lines with fewer points that look the same, for figures and browser windows; never for data."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tribopipe.base.arrays import Column

Places = NDArray[np.intp]
"""Numbers of samples."""
_COLUMNS = 750
"""About the number of pixels across a figure."""


def thinned(x: Column, y: Column) -> tuple[Column, Column]:
    """Keep the lowest and the highest sample in each column of pixels, so that a line looks the same.

    Samples missing in either are left out. Where x goes back, columns are made of equally many samples.
    """
    seen = np.isfinite(x) & np.isfinite(y)
    x, y = x[seen], y[seen]
    if len(x) <= 2 * _COLUMNS:
        return x, y
    kept = extremes(y, first_of_columns(x, _COLUMNS))
    return x[kept], y[kept]


def first_of_columns(x: Column, columns: int) -> Places:
    """Return the first sample in each column of pixels that has any; x is finite and not empty."""
    if not (grows(x) and x[-1] > x[0]):
        return np.unique(np.linspace(0, len(x), columns, endpoint=False).astype(np.intp))
    edges = np.linspace(x[0], x[-1], columns, endpoint=False)
    return np.unique(np.searchsorted(x, edges))


def grows(x: Column) -> bool:
    """Return whether values never decrease; False if any is missing."""
    return bool(np.all(x[1:] >= x[:-1]))


def extremes(y: Column, starts: Places) -> Places:
    """Return, in order, the first and last sample, and the lowest and highest of each column starting at ``starts``.

    A column in which every sample is missing is represented by its first.
    """
    lengths = np.diff(starts, append=len(y))
    kept = [np.array([0, len(y) - 1])]
    for extreme in (np.fmin, np.fmax):
        values = extreme.reduceat(y, starts)
        at_it = np.flatnonzero(y == np.repeat(values, lengths))
        _, first = np.unique(np.searchsorted(starts, at_it, side="right"), return_index=True)
        kept.append(at_it[first])
    kept.append(starts[np.isnan(values)])
    return np.unique(np.concatenate(kept))


@dataclass(frozen=True)
class Window:
    """The visible range of an axis, in its displayed unit; all of it if no end is specified."""

    start: float | None
    end: float | None
    width: int
    """Number of pixels across."""

    def span(self, axes: Sequence[Column]) -> tuple[float, float]:
        """Return its ends, by default those of the axes; 0 and 1 if these have no values."""
        known = [axis[np.isfinite(axis)] for axis in axes]
        ends = [end for axis in known if axis.size for end in (float(np.min(axis)), float(np.max(axis)))]
        low, high = (min(ends), max(ends)) if ends else (0.0, 1.0)
        return low if self.start is None else self.start, high if self.end is None else self.end


class Points(NamedTuple):
    """The reduced curve; NaN where nothing was recorded."""

    x: Column
    y: Column
    lower: Column | None
    upper: Column | None


@dataclass(frozen=True)
class Shown:
    """The samples of an axis in a window, and one on each side, so that lines extend beyond it."""

    places: slice | Places
    x: Column
    hidden: NDArray[np.bool_] | None
    """Samples among them outside the window, if the axis decreases in places."""
    starts: Places | None
    """First sample in each column of pixels; None if there is room for every sample."""

    def thinned(self, y: Column, lower: Column | None = None, upper: Column | None = None) -> Points:
        """Return the extremes of a curve and of its band in each column of pixels."""
        y = y[self.places]
        low, high = (None if line is None else line[self.places] for line in (lower, upper))
        if self.hidden is not None:
            y = np.where(self.hidden, np.nan, y)
        if self.starts is None:
            return Points(self.x, y, low, high)
        kept = extremes(y, self.starts)
        column = np.searchsorted(self.starts, kept, side="right") - 1
        low = None if low is None else np.fmin.reduceat(low, self.starts)[column]
        high = None if high is None else np.fmax.reduceat(high, self.starts)[column]
        return Points(self.x[kept], y[kept], low, high)


def shown(x: Column, span: tuple[float, float], width: int) -> Shown:
    """Return the part of an axis between two of its values, for a number of columns of pixels.

    Samples of which x is missing are left out. Where x goes back, columns are made of equally many samples.
    """
    before = after = 0
    if grows(x) and np.isfinite(x[:1]).all():
        first, last = int(np.searchsorted(x, span[0])), int(np.searchsorted(x, span[1], side="right"))
        before, after = min(first, 1), min(len(x) - last, 1)
        places: slice | Places = slice(first - before, last + after)
        hidden = None
    else:
        inside = (x >= span[0]) & (x <= span[1])
        places = np.flatnonzero(np.isfinite(x))
        hit = np.flatnonzero(inside[places])
        places = places[hit[0] : hit[-1] + 1] if hit.size else places[:0]
        hidden = ~inside[places]
    seen = x[places]
    starts = _starts(seen, before, after, width) if len(seen) > 2 * width else None
    return Shown(places, seen, hidden, starts)


def _starts(seen: Column, before: int, after: int, width: int) -> Places:
    """Return the first sample of each column; samples outside the window have their own columns."""
    inside = first_of_columns(seen[before : len(seen) - after], width) + before
    return np.concatenate([np.arange(before), inside, np.arange(len(seen) - after, len(seen))])
