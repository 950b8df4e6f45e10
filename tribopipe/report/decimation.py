"""Fewer points for a line of many samples, that look the same: for figures only, never for data."""

import numpy as np
from numpy.typing import NDArray

from tribopipe.run import Column

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
    starts = _first_of_each_column(x)
    lengths = np.diff([*starts, len(x)])
    kept = [np.array([0, len(x) - 1])]
    for extreme in (np.minimum, np.maximum):
        at_it = np.flatnonzero(y == np.repeat(extreme.reduceat(y, starts), lengths))
        _, first = np.unique(np.searchsorted(starts, at_it, side="right"), return_index=True)
        kept.append(at_it[first])
    order = np.unique(np.concatenate(kept))
    return x[order], y[order]


def _first_of_each_column(x: Column) -> NDArray[np.intp]:
    """Return the number of the first sample of each column of pixels that has any."""
    grows = bool(np.all(x[1:] >= x[:-1])) and x[-1] > x[0]
    if not grows:
        return np.linspace(0, len(x), _COLUMNS, endpoint=False).astype(np.intp)
    edges = np.linspace(x[0], x[-1], _COLUMNS, endpoint=False)
    return np.unique(np.searchsorted(x, edges))
