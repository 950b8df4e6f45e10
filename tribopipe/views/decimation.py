"""Fewer points for a line of many samples, that look the same: for figures and screens only, never for data."""

import numpy as np
from numpy.typing import NDArray

from tribopipe.base.arrays import Column

Places = NDArray[np.intp]
"""Numbers of samples."""
_COLUMNS = 750
"""About as many as a figure has pixels side by side."""


def thinned(x: Column, y: Column) -> tuple[Column, Column]:
    """Keep the lowest and the highest sample of each column of pixels, so that a line looks the same.

    Samples missing in either are left out. Where x goes back, columns are made of equally many samples.
    """
    seen = np.isfinite(x) & np.isfinite(y)
    x, y = x[seen], y[seen]
    if len(x) <= 2 * _COLUMNS:
        return x, y
    kept = extremes(y, first_of_columns(x, _COLUMNS))
    return x[kept], y[kept]


def first_of_columns(x: Column, columns: int) -> Places:
    """Return the first sample of each column of pixels that has any; x is finite and not empty."""
    if not (grows(x) and x[-1] > x[0]):
        return np.unique(np.linspace(0, len(x), columns, endpoint=False).astype(np.intp))
    edges = np.linspace(x[0], x[-1], columns, endpoint=False)
    return np.unique(np.searchsorted(x, edges))


def grows(x: Column) -> bool:
    """Return whether values never go back; missing ones do."""
    return bool(np.all(x[1:] >= x[:-1]))


def extremes(y: Column, starts: Places) -> Places:
    """Return, in order, the first and last sample, and the lowest and highest of each column that begins at ``starts``.

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
