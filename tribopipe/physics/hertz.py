"""Hertz's contact, round and elliptic, from which the incremental model starts (paper, Eq. 3–5 and 3.1)."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from tribopipe.base.arrays import Column
from tribopipe.base.errors import ContactError
from tribopipe.base.units import show

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


@dataclass(frozen=True)
class HertzEllipse:
    """Elliptic contact area under load: p(x, z) = p₀·√(1 − x²/a_x² − z²/a_z²)."""

    half_width: float
    """a_x, m."""
    half_length: float
    """a_z, m."""
    peak_pressure: float
    """p₀ = 3F_N/(2π·a_x·a_z), Pa."""
    approach: float
    """Approach of remote points of the bodies, m."""

    @property
    def mean_pressure(self) -> float:
        """F_N/(π·a_x·a_z), Pa."""
        return self.peak_pressure / 1.5


def hertz_ellipse(*, normal_load: float, radius_x: float, radius_z: float, modulus: float) -> HertzEllipse:
    """Return the contact of two bodies whose relative radii of curvature are R_x and R_z; N, m, Pa.

    The pressure above displaces the surface by

        u(x, z) = (p₀·a_x·a_z / E_c)·[R_F(0, a_x², a_z²) − (x²/3)·R_D(0, a_z², a_x²) − (z²/3)·R_D(0, a_x², a_z²)]

    with Carlson's symmetric elliptic integrals (K. L. Johnson, Contact Mechanics, 1985, §3.5 and §4.2, has the same in
    Legendre's, which cancel near a circle). Setting the brackets equal to x²/2R_x and z²/2R_z gives the axes' ratio

        R_x/R_z = R_D(0, a_x², a_z²) / R_D(0, a_z², a_x²)

    and then their size. Either radius may be the larger one. Raises ``ContactError`` where an argument is not positive.
    """
    from scipy.optimize import brentq
    from scipy.special import elliprd, elliprf

    given = {
        "a load": normal_load,
        "a radius of curvature in x": radius_x,
        "a radius of curvature in z": radius_z,
        "a modulus": modulus,
    }
    for what, value in given.items():
        if not (value > 0 and math.isfinite(value)):
            raise ContactError(
                f"contact: found {what} of {show(value, None, '1')}; expected a positive value; check load, radii and "
                "moduli"
            )
    wanted = math.log(radius_x / radius_z)

    def excess(log_ratio: float) -> float:
        square = math.exp(2 * log_ratio)
        return float(math.log(elliprd(0.0, square, 1.0) / elliprd(0.0, 1.0, square))) - wanted

    # The ratio of radii grows at least as fast as that of the axes, so that the root lies between 0 and their log.
    log_ratio = brentq(excess, min(wanted, 0.0) - 1e-9, max(wanted, 0.0) + 1e-9, xtol=1e-15, rtol=1e-15)
    ratio = math.exp(log_ratio)
    half_length = math.cbrt(normal_load * radius_x / (math.pi * modulus) * float(elliprd(0.0, 1.0, ratio**2)))
    half_width = ratio * half_length
    peak = 1.5 * normal_load / (math.pi * half_width * half_length)
    approach = peak * half_width * half_length / modulus * float(elliprf(0.0, half_width**2, half_length**2))
    return HertzEllipse(half_width, half_length, peak, approach)
