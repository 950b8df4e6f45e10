"""Geometry of a worn spherical tip: a cap cut off a sphere, in forms that lose no digits."""

import numpy as np
from numpy.typing import ArrayLike

from tribopipe.run import Column


def cap_height(*, scar_radius: ArrayLike, sphere_radius: ArrayLike) -> Column:
    """Return the height of the cap under a flat scar: R − √(R² − a²), m.

    Written a²/(R + √(R² − a²)), which keeps all digits of shallow caps. a and R in m, a ≤ R.
    """
    a, r = np.asarray(scar_radius, dtype=float), np.asarray(sphere_radius, dtype=float)
    # A draw of a scar as wide as the tip may be wider: half a sphere is gone then.
    return np.asarray(a**2 / (r + np.sqrt(np.maximum(r**2 - a**2, 0.0))))


def cap_radius(*, height: ArrayLike, sphere_radius: ArrayLike) -> Column:
    """Return the scar radius of a cap: a = √(c(2R − c)), m. c and R in m, c ≤ R."""
    c, r = np.asarray(height, dtype=float), np.asarray(sphere_radius, dtype=float)
    return np.asarray(np.sqrt(c * (2 * r - c)))
