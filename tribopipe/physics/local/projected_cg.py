"""The contact of a grid whose elasticity is known as an operator, by conjugate gradients on the points in contact.

Within the contact, the pressure that evens out the gap and carries the load minimises ½·Σp·u(p) + Σp·gap among all
that carry it. Conjugate gradients of the gap less its mean lead there (I. A. Polonsky and L. M. Keer, Wear 231, 1999).
Points that come to pull leave the contact at once. Points that overlap join it as soon as the gap within is more even
than they overlap. Each time the search restarts from there, so that no direction of another contact is followed.
"""

from collections.abc import Callable

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.base.errors import ContactError
from tribopipe.physics.local.surface import Contact

_MOST_STEPS = 3000
_CONVERGED = 1e-8
"""Unevenness of the gap in contact, and overlap next to it, in shares of the approach."""


def pressed(
    displacement: Callable[[Column], Column], gap: Column, cell: float, load: float, start: Column | None = None
) -> Contact:
    """Return p ≥ 0 with gap + displacement(p) − approach ≥ 0, zero where p > 0, and cell·Σp = load.

    ``displacement`` is linear, symmetric and positive definite; a gap may be infinite where there is nothing to touch.
    ``start`` is a pressure to begin from. Raises ``ContactError`` where the search does not end.
    """
    pressure = _carrying(load / cell, np.isfinite(gap).astype(float) if start is None else start)
    inside, distance = pressure > 0, gap + displacement(pressure)
    direction, last = np.zeros_like(gap), np.inf
    for _ in range(_MOST_STEPS):
        approach = float(distance[inside].mean())
        apart = distance - approach
        uneven, overlap = float(np.abs(apart[inside]).max()), -float(apart.min(where=~inside, initial=0.0))
        if max(uneven, overlap) <= _CONVERGED * (approach - gap.min()):
            return Contact(_carrying(load / cell, pressure), approach)
        if uneven < overlap:
            inside, last = inside | (apart < 0), np.inf
            continue
        residual = np.where(inside, apart, 0.0)
        square = float(np.vdot(residual, residual))
        direction, last = square / last * direction - residual, square
        displaced = displacement(direction)
        step = square / float(np.vdot(direction, displaced))
        pressure, distance = pressure + step * direction, distance + step * displaced
        if pressure.min() < 0:
            pressure = _carrying(load / cell, np.maximum(pressure, 0.0))
            inside, distance, last = pressure > 0, gap + displacement(pressure), np.inf
    raise ContactError(
        f"local wear: found no contact in {_MOST_STEPS} steps; expected the points in contact to settle; check the "
        "profile, or make the grid coarser"
    )


def _carrying(total: float, pressure: Column) -> Column:
    """Return pressure in proportion that adds up to a total."""
    return np.asarray(pressure * (total / pressure.sum()))
