"""A smooth function at very many places, from its values at few: interpolation between Chebyshev's points.

Thousands of draws at hundreds of places are millions of evaluations of a function that varies slowly in few variables.
On the box that holds all places, a polynomial through some hundred values gives it to ten digits. Whether it does is
tried at some of the places themselves (L. N. Trefethen, Approximation Theory and Approximation Practice, SIAM 2019).
"""

from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np
from numpy.polynomial.chebyshev import chebvander
from numpy.typing import NDArray

Array = NDArray[np.float64]
Function = Callable[[Array], Array]
"""Of places, (variables, n), to values, (outcomes, n)."""
_FEWEST, _PER_SPAN = 5, 3.0
"""Points along a variable, at least, and in addition for each unit that it spans."""
_MOST = 64
"""Points along a variable, at most."""
_FINER = 1.6
"""By which there are more points in a second trial."""
_TRIED = 16
"""Places at which the polynomial is compared with the function."""
_CLOSE = 1e-10
_BLOCK = 32_768
"""Places evaluated at a time, so that they stay in the processor's cache."""


def at_many(function: Function, places: Array) -> Array | None:
    """Return a function at places, from its values at fewer; None where it is not smooth enough, or has no number.

    Parameters
    ----------
    function
        Of places, shape (variables, n), to values of size about one, shape (outcomes, n).
    places
        Shape (variables, n).

    Returns
    -------
    ndarray or None
        Shape (outcomes, n); differs from the function by less than 1e-10.
    """
    low, high = places.min(axis=1), places.max(axis=1)
    tried = places[:, np.linspace(0, places.shape[1] - 1, _TRIED).astype(int)]
    true = function(tried)
    for finer in (1.0, _FINER):
        counts = [_count(span, finer) for span in (high - low).tolist()]
        if np.prod(counts) > places.shape[1]:
            return None
        polynomial = _through(function, low, high, counts)
        if polynomial is None:
            return None
        if np.all(np.abs(polynomial(tried) - true) < _CLOSE):
            return polynomial(places)
    return None


def _count(span: float, finer: float) -> int:
    return 1 if not span else min(_MOST, int(finer * (_FEWEST + _PER_SPAN * span)))


def _through(function: Function, low: Array, high: Array, counts: Sequence[int]) -> Function | None:
    """Return the polynomial through a function at Chebyshev's points of a box; None where it has no number at one."""
    points = [np.cos(np.pi * (np.arange(count) + 0.5) / count) for count in counts]
    grid = np.stack([axis.ravel() for axis in np.meshgrid(*points, indexing="ij")])
    middle, half = (low + high) / 2, (high - low) / 2
    values = function(middle[:, None] + half[:, None] * grid)
    if not np.all(np.isfinite(values)):
        return None
    coefficients = values.reshape(len(values), *counts)
    for axis, (along, count) in enumerate(zip(points, counts, strict=True), start=1):
        inverse = np.linalg.inv(chebvander(along, count - 1))
        coefficients = np.moveaxis(np.tensordot(inverse, coefficients, (1, axis)), 0, axis)
    scale = np.where(half > 0, half, 1.0)

    def polynomial(places: Array) -> Array:
        edges = [*range(0, places.shape[1], _BLOCK), places.shape[1]]
        parts = (places[:, first:last] for first, last in pairwise(edges))
        return np.concatenate([_summed(coefficients, (part.T - middle) / scale) for part in parts], axis=1)

    return polynomial


def _summed(coefficients: Array, places: Array) -> Array:
    """Return sums of products of Chebyshev's polynomials, (outcomes, n), at places from −1 to 1, (n, variables)."""
    found = np.moveaxis(coefficients, 0, -1)  # the first variable first, outcomes last
    first, *others = (chebvander(column, count - 1) for column, count in zip(places.T, found.shape, strict=False))
    found = np.tensordot(first, found, (1, 0))
    for powers in others:
        found = np.einsum("nk,nk...->n...", powers, found)
    return np.asarray(found.T)
