"""Hertz's elliptic contact against Legendre's integrals in many digits, the sphere, and Boussinesq's half-space."""

import re

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tribopipe.base.errors import ContactError
from tribopipe.physics.hertz import HertzEllipse, hertz_ellipse, hertz_radius

LOAD, RADIUS, MODULUS = 0.3, 4e-3, 84.7e9
AXIS_RATIOS = ["1.000000000001", "1.000001", "1.001", "1.2", "1.5", "2", "5", "10", "100", "1000", "10000"]


def approx(value, rel):
    """As pytest's, which takes all below 1e-12 for equal: a picometre and a thousandth of a cubic millimetre."""
    return pytest.approx(value, rel=rel, abs=0)


def johnson(axis_ratio, load, short_radius, modulus):
    """Johnson's §4.2 the way round he does not go: from the ratio of the axes to that of the radii, 60 digits.

    The surface sinks by (L − M·x² − N·y²)/(π·E_c), x along the longer axis a and y along b, with

        L = π·p₀·b·K(e)    M = π·p₀·b/(e²a²)·(K − E)    N = π·p₀·b/(e²a²)·((a/b)²·E − K)    e² = 1 − b²/a²

    Returns the relative radius along a, then a, b, p₀ and the approach.
    """
    with mpmath.workdps(60):
        q, load, short_radius, modulus = (mpmath.mpf(value) for value in (axis_ratio, load, short_radius, modulus))
        square = 1 - 1 / q**2
        first, second = mpmath.ellipk(square), mpmath.ellipe(square)
        long_radius = short_radius * (q**2 * second - first) / (first - second)
        # 1/2R'' = N/(πE_c) with p₀ = 3F/(2πab) and a = q·b.
        b = mpmath.cbrt(3 * load * short_radius / (mpmath.pi * modulus * q**3 * square) * (q**2 * second - first))
        peak = 3 * load / (2 * mpmath.pi * q * b**2)
        approach = peak * b * first / modulus
        return [float(value) for value in (long_radius, q * b, b, peak, approach)]


@pytest.mark.parametrize("orientation", ["long across", "long along"])
@pytest.mark.parametrize("ratio", AXIS_RATIOS)
def test_ellipse_is_that_of_legendre_s_integrals(ratio, orientation):
    long_radius, a, b, peak, approach = johnson(ratio, LOAD, RADIUS, MODULUS)
    if orientation == "long across":
        found = hertz_ellipse(normal_load=LOAD, radius_x=long_radius, radius_z=RADIUS, modulus=MODULUS)
        axes = (found.half_width, found.half_length)
    else:
        found = hertz_ellipse(normal_load=LOAD, radius_x=RADIUS, radius_z=long_radius, modulus=MODULUS)
        axes = (found.half_length, found.half_width)
    np.testing.assert_allclose([*axes, found.peak_pressure, found.approach], [a, b, peak, approach], rtol=1e-10)


@pytest.mark.parametrize("excess", [1e-12, 1e-6])
def test_axes_near_a_circle_differ_by_two_thirds_of_what_the_radii_do(excess):
    found = hertz_ellipse(normal_load=LOAD, radius_x=RADIUS * (1 + excess), radius_z=RADIUS, modulus=MODULUS)
    assert found.half_width / found.half_length - 1 == pytest.approx(2 / 3 * excess, abs=0.2 * excess**2 + 1e-15)


def test_equal_radii_are_hertz_s_sphere():
    found = hertz_ellipse(normal_load=LOAD, radius_x=RADIUS, radius_z=RADIUS, modulus=MODULUS)
    a = float(hertz_radius(normal_load=LOAD, pin_radius=RADIUS, modulus=MODULUS))
    assert found.half_width == approx(a, rel=1e-14)
    assert found.half_length == approx(a, rel=1e-14)
    assert found.approach == approx(a**2 / RADIUS, rel=1e-14)
    assert found.mean_pressure == approx(LOAD / (np.pi * a**2), rel=1e-14)
    assert found.peak_pressure == approx(2 * MODULUS * a / (np.pi * RADIUS), rel=1e-14)


def sunk(ellipse: HertzEllipse, x: float, z: float) -> float:
    """Return (1/πE_c)·∬ p/r dA at a point within the ellipse, in polar coordinates about it, m.

    There r cancels. Along a ray p is a root that vanishes at its end s₁, smooth in t with s = s₁(1 − t²).
    """
    nodes, weights = np.polynomial.legendre.leggauss(60)
    t = (nodes + 1) / 2
    angle = np.linspace(0, 2 * np.pi, 4000, endpoint=False)[:, None]
    across, along = np.cos(angle) / ellipse.half_width, np.sin(angle) / ellipse.half_length
    within = 1 - (x / ellipse.half_width) ** 2 - (z / ellipse.half_length) ** 2
    outward = across * x / ellipse.half_width + along * z / ellipse.half_length
    square = across**2 + along**2
    end = within / (outward + np.sqrt(outward**2 + square * within))
    s = end * (1 - t**2)
    pressure = ellipse.peak_pressure * np.sqrt(np.maximum(within - 2 * outward * s - square * s**2, 0.0))
    rays = (pressure * 2 * end * t) @ (weights / 2)
    return float(2 * np.mean(rays) / MODULUS)


@pytest.mark.parametrize("radius_x", [0.4e-3, 3e-3, 4e-3, 9e-3, 80e-3])
@pytest.mark.parametrize(("across", "along"), [(0, 0), (0.5, 0), (0, 0.7), (0.4, -0.6), (-0.9, 0.3)])
def test_pressure_sinks_the_surface_by_what_the_shape_of_the_bodies_asks_for(radius_x, across, along):
    ellipse = hertz_ellipse(normal_load=LOAD, radius_x=radius_x, radius_z=RADIUS, modulus=MODULUS)
    x, z = across * ellipse.half_width, along * ellipse.half_length
    asked = ellipse.approach - x**2 / (2 * radius_x) - z**2 / (2 * RADIUS)
    assert sunk(ellipse, x, z) == approx(asked, rel=1e-8)


@pytest.mark.parametrize("radius_x", [0.4e-3, 4e-3, 80e-3])
def test_pressure_carries_the_load(radius_x):
    ellipse = hertz_ellipse(normal_load=LOAD, radius_x=radius_x, radius_z=RADIUS, modulus=MODULUS)
    nodes, weights = np.polynomial.legendre.leggauss(40)
    # Rings of the ellipse, ρ² = 1 − t².
    t = (nodes + 1) / 2
    carried = 2 * np.pi * ellipse.half_width * ellipse.half_length * ellipse.peak_pressure * (t**2) @ weights / 2
    assert float(carried) == approx(LOAD, rel=1e-13)


exponents = st.floats(-3, 3)


@given(exponents, exponents, exponents, st.floats(0.01, 100))
def test_turning_and_scaling_the_bodies_turns_and_scales_the_ellipse(load, radius_x, radius_z, scale):
    load, radius_x, radius_z = 10**load, 1e-3 * 10**radius_x, 1e-3 * 10**radius_z
    one = hertz_ellipse(normal_load=load, radius_x=radius_x, radius_z=radius_z, modulus=MODULUS)
    turned = hertz_ellipse(normal_load=load, radius_x=radius_z, radius_z=radius_x, modulus=MODULUS)
    large = hertz_ellipse(
        normal_load=load * scale**2, radius_x=radius_x * scale, radius_z=radius_z * scale, modulus=MODULUS
    )
    values = np.array([one.half_width, one.half_length, one.peak_pressure, one.approach])
    np.testing.assert_allclose(
        [turned.half_length, turned.half_width, turned.peak_pressure, turned.approach], values, rtol=1e-13
    )
    np.testing.assert_allclose(
        [large.half_width, large.half_length, large.peak_pressure, large.approach],
        values * [scale, scale, 1, scale],
        rtol=1e-13,
    )


NAMES = {
    "normal_load": "a load",
    "radius_x": "a radius of curvature in x",
    "radius_z": "a radius of curvature in z",
    "modulus": "a modulus",
}


@pytest.mark.parametrize("value", [0.0, -1e-3, float("nan"), float("inf")])
@pytest.mark.parametrize("argument", NAMES)
def test_what_is_not_positive_is_refused_in_one_sentence(argument, value):
    given = {"normal_load": LOAD, "radius_x": RADIUS, "radius_z": RADIUS, "modulus": MODULUS} | {argument: value}
    with pytest.raises(ContactError) as caught:
        hertz_ellipse(**given)
    text = str(caught.value)
    assert re.fullmatch(rf"contact: found {NAMES[argument]} of \S+; expected [^;]+; check [^;]+", text)
    assert "\n" not in text
    assert ". " not in text
