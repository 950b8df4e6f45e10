"""The contact of a surface whose elasticity is a dense matrix, by an active set: exact up to rounding."""

import numpy as np
from numpy.typing import NDArray

from tribopipe.base.arrays import Column
from tribopipe.base.errors import ContactError
from tribopipe.physics.local.surface import Contact

_MOST_ROUNDS = 200
_TOUCHING = 1e-12
"""Share of the largest gap closed by the load, below which a gap counts as none."""


def pressed(
    compliance: Column, gap: Column, areas: Column, load: float, touching: NDArray[np.bool_] | None = None
) -> Contact:
    """Return p ≥ 0 with gap + compliance·p − approach ≥ 0, zero where p > 0, and Σ areas·p = load.

    Points that pull leave the contact and points that overlap join it, until there are neither. ``touching`` is where
    the search begins; near the answer it takes two or three rounds. Raises ``ContactError`` where it does not end.
    """
    inside = gap <= gap.min() if touching is None else touching.copy()
    for _ in range(_MOST_ROUNDS):
        at = np.flatnonzero(inside)
        pressure, approach = touching_at(at, compliance, gap, areas, load)
        if np.any(pressure < 0):
            inside[at[pressure < 0]] = False
            continue
        left = gap + compliance[:, at] @ pressure - approach
        overlapping = ~inside & (left < -_TOUCHING * abs(approach))
        if not overlapping.any():
            found = np.zeros_like(gap)
            found[at] = pressure
            return Contact(found, approach)
        inside |= overlapping
    raise ContactError(
        f"local wear: found no contact in {_MOST_ROUNDS} rounds; expected the points in contact to settle; check the "
        "profile, or make the grid coarser"
    )


def touching_at(
    at: NDArray[np.intp], compliance: Column, gap: Column, areas: Column, load: float
) -> tuple[Column, float]:
    """Return the pressure at these points, which may pull, were they all to touch and bear the load, and the approach.

    It is approach·x − y, where compliance·x = 1 and compliance·y = gap.
    """
    x, y = np.linalg.solve(compliance[np.ix_(at, at)], np.column_stack([np.ones(at.size), gap[at]])).T
    approach = (load + areas[at] @ y) / (areas[at] @ x)
    return approach * x - y, float(approach)
