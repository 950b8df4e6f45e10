"""Contact mechanics the Global Incremental Wear Model starts from (paper, Eq. 3–5)."""

import numpy as np
from numpy.typing import ArrayLike

from tribopipe.base.arrays import Column

HARDNESS_UNIT = 9.80665e6
"""HV is a kilogram-force a square millimetre: 1 HV = 9.80665 MPa."""


def contact_modulus(*, pin_modulus: ArrayLike, pin_ratio: float, disc_modulus: ArrayLike, disc_ratio: float) -> Column:
    """Return E_c of 1/E_c = (1 − ν_p²)/E_p + (1 − ν_d²)/E_d (Eq. 3), Pa. Moduli in Pa."""
    pin = (1 - pin_ratio**2) / np.asarray(pin_modulus, dtype=float)
    disc = (1 - disc_ratio**2) / np.asarray(disc_modulus, dtype=float)
    return np.asarray(1 / (pin + disc))


def hertz_radius(*, normal_load: ArrayLike, pin_radius: ArrayLike, modulus: ArrayLike) -> Column:
    """Return the contact radius of an unworn sphere, a₀ = (3 F_N R_P / 4 E_c)^⅓ (Eq. 4), m."""
    load, radius = np.asarray(normal_load, dtype=float), np.asarray(pin_radius, dtype=float)
    return np.asarray(np.cbrt(3 * load * radius / (4 * np.asarray(modulus, dtype=float))))


def elastic_approach(*, normal_load: ArrayLike, modulus: ArrayLike, contact_radius: ArrayLike) -> Column:
    """Return the elastic displacement under a flat circular contact, h^e = F_N / (2 E_c a) (Eq. 5), m."""
    load = np.asarray(normal_load, dtype=float)
    return np.asarray(load / (2 * np.asarray(modulus, dtype=float) * np.asarray(contact_radius, dtype=float)))
