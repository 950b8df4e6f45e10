"""The pressure along a line of nodes from the middle of a contact outwards."""

import math

import numpy as np

from tribopipe.base.arrays import Column

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
    (inner, outer), (p, q) = places[last - 2 : last] ** 2, pressure[last - 2 : last] ** 2
    found = math.sqrt(outer + q * (outer - inner) / (p - q)) if p > q else most
    return float(np.clip(found, least, most))


def roughness(places: Column, pressure: Column) -> float:
    """Return by how much p, or ∫p dz, alternates from node to node well inside the contact, relative to its mean."""
    inner = pressure[places < _INNER * edge(places, pressure)]
    if inner.size < 3:
        return 0.0
    alternation = inner[1:-1] - (inner[2:] + inner[:-2]) / 2
    return float(np.sqrt(np.mean(alternation**2)) / 2 / np.mean(inner))
