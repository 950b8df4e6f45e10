"""Nodes along an axis, fine where the contact is and coarse far from it, and the pressure along them."""

import math

import numpy as np
from numpy.typing import NDArray

from tribopipe.base.arrays import Column


def graded(finest: float, last: float, share: float) -> Column:
    """Return points from 0 to ``last``, m: spacings are the finest near 0, further out a share of the distance."""
    points = [0.0]
    while points[-1] < last:
        points.append(points[-1] + max(finest, share * points[-1]))
    return np.asarray(np.array(points) * (last / points[-1]))


_LEAF = 27
"""Grid points that are not worth dividing any further."""


def continued(nodes: Column, last: float, growth: float) -> Column:
    """Return the nodes and more of them to beyond ``last``, m, each spacing larger than the one before by a factor."""
    spacing = nodes[-1] - nodes[-2]
    count = int(np.ceil(np.log1p((last - nodes[-1]) * (growth - 1) / (spacing * growth)) / np.log(growth)))
    return np.append(nodes, nodes[-1] + spacing * np.cumsum(growth ** np.arange(1, count + 1)))


def tributary(nodes: Column, radial: bool = False) -> Column:
    """Return ∫Nᵢ·dx of each node's linear shape function Nᵢ, m; ∫Nᵢ·2πr·dr, m², where nodes are radii."""
    inner, outer = nodes[:-1], nodes[1:]
    to_inner, to_outer = np.ones_like(inner), np.ones_like(inner)
    if radial:
        to_inner, to_outer = 2 * np.pi * (2 * inner + outer) / 3, 2 * np.pi * (inner + 2 * outer) / 3
    halves = (outer - inner) / 2
    return np.asarray(np.append(halves * to_inner, 0.0) + np.append(0.0, halves * to_outer))


def nested_dissection(grid: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the points of a grid so ordered that factors of a matrix that couples neighbors fill little.

    The plane that halves the grid's longest side comes last, after either half in the same order (A. George, SIAM J.
    Numer. Anal. 10, 1973, 345). In three dimensions factors are half as large as by minimum degree.
    """
    if grid.size <= _LEAF:
        return grid.ravel()
    longest = int(np.argmax(grid.shape))
    below, plane, above = np.split(grid, [grid.shape[longest] // 2, grid.shape[longest] // 2 + 1], axis=longest)
    return np.concatenate([nested_dissection(below), nested_dissection(above), plane.ravel()])


_INNER = 0.8
"""Share of the contact where the pressure has to be smooth."""


def edge(places: Column, pressure: Column) -> float:
    """Return where the pressure ends, m: where p², near the edge linear in the place's square (Hertz), is zero.

    It is read off the two nodes before the last one in contact, since that one bears part of its share only; and it is
    no further from that one than half the way to its neighbors.
    """
    last = int(np.flatnonzero(pressure)[-1])
    least = places[last] if last == 0 else (places[last] + places[last - 1]) / 2
    most = places[last] if last + 1 == len(places) else (places[last] + places[last + 1]) / 2
    if last < 2:
        return float(most)
    return float(np.clip(vanishing(places, pressure, last - 2), least, most))


def vanishing(places: Column, pressure: Column, first: int) -> float:
    """Return where the line of p² over the square of the place, through a node and the next one, is zero, m."""
    two = slice(first, first + 2)
    (inner, outer), (p, q) = places[two] ** 2, pressure[two] ** 2
    return math.sqrt(outer + q * (outer - inner) / (p - q)) if p > q else math.inf


def roughness(places: Column, pressure: Column, end: float) -> float:
    """Return the oscillation of p, or ∫p dz, over the inner 80 % of a contact that ends there, relative to its mean."""
    inner = pressure[places < _INNER * end]
    if inner.size < 3:
        return 0.0
    oscillation = inner[1:-1] - (inner[2:] + inner[:-2]) / 2
    return float(np.sqrt(np.mean(oscillation**2)) / 2 / np.mean(inner))
