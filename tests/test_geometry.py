"""Volumes of caps, of what lies between two flats, and of tracks: against 50 digits, quadrature and limits."""

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tribopipe.physics.geometry import (
    circle_volume,
    scar_depth,
    scar_radius_at,
    segment_area,
    worn_depth,
    worn_volume,
)

mpf = mpmath.mpf
radii = st.floats(-4, -1.5).map(lambda x: 10.0**x)
shares = st.one_of(st.floats(-7, -1e-3).map(lambda x: 10.0**x), st.floats(0.01, 0.999))
flats = st.one_of(st.just(0.0), st.floats(1e-4, 0.95))
"""Share of the scar that the flat was as wide as."""


def missing(radius, scar):
    """Height of a cap, to 50 digits."""
    return radius - mpmath.sqrt(radius**2 - scar**2)


def cap(radius, scar):
    height = missing(radius, scar)
    return mpmath.pi * height**2 * (3 * radius - height) / 3


def segment(radius, half):
    """ASTM G99: r²·arcsin(d/2r) − (d/4)·√(4r² − d²)."""
    width = 2 * half
    return radius**2 * mpmath.asin(width / 2 / radius) - width / 4 * mpmath.sqrt(4 * radius**2 - width**2)


@given(radii, shares, flats)
def test_volume_between_two_flats_is_that_of_50_digits(radius, share, flat_share):
    scar, flat = share * radius, flat_share * share * radius
    with mpmath.workdps(50):
        r, b, a = mpf(radius), mpf(scar), mpf(flat)
        depth, volume = missing(r, b) - missing(r, a), cap(r, b) - cap(r, a)
    found = scar_depth(scar_radius=scar, sphere_radius=radius, flat_radius=flat)
    assert float(found) == pytest.approx(float(depth), rel=1e-14)
    lost = worn_volume(depth=float(depth), sphere_radius=radius, flat_radius=flat)
    assert float(lost) == pytest.approx(float(volume), rel=1e-14)


@given(radii, shares)
def test_segment_is_that_of_50_digits(radius, share):
    half = share * radius
    with mpmath.workdps(50):
        expected = segment(mpf(radius), mpf(half))
    assert float(segment_area(half_chord=half, radius=radius)) == pytest.approx(float(expected), rel=1e-13)


@given(radii, shares, flats)
def test_depth_of_a_volume_is_the_depth_it_was_made_of(radius, share, flat_share):
    flat = flat_share * radius
    depth = share * float(scar_depth(scar_radius=radius, sphere_radius=radius, flat_radius=flat))
    volume = worn_volume(depth=depth, sphere_radius=radius, flat_radius=flat)
    found = worn_depth(volume=volume, sphere_radius=radius, flat_radius=flat)
    assert float(found) == pytest.approx(depth, rel=1e-13)
    assert float(worn_depth(volume=-volume, sphere_radius=radius, flat_radius=flat)) == -float(found)
    scar = scar_radius_at(depth=depth, sphere_radius=radius, flat_radius=flat)
    # Beside a flat much wider than what was worn, the scar itself has too few digits for the depth.
    back = scar_depth(scar_radius=scar, sphere_radius=radius, flat_radius=flat)
    assert float(back) == pytest.approx(depth, rel=1e-12, abs=1e-15 * radius)


def test_half_a_sphere_is_the_most_that_is_lost():
    half = 2 / 3 * np.pi * 1e-9
    assert worn_volume(depth=1e-3, sphere_radius=1e-3) == pytest.approx(half, rel=1e-15)
    np.testing.assert_allclose(worn_depth(volume=[half, 2 * half, np.inf], sphere_radius=1e-3), 1e-3, rtol=1e-14)
    assert worn_depth(volume=0.0, sphere_radius=1e-3) == 0


def test_volume_of_a_thin_slice_is_its_flat_times_its_height():
    volume = worn_volume(depth=1e-12, sphere_radius=1e-3, flat_radius=0.3e-3)
    assert float(volume) == pytest.approx(np.pi * 0.09e-6 * 1e-12, rel=2e-8)


def test_circular_track_is_that_of_astm_g99():
    # 2πR[r²·asin(d/2r) − (d/4)·√(4r² − d²)] with R = 10 mm, r = 3 mm, d = 0.7 mm, in 50-digit arithmetic.
    with mpmath.workdps(50):
        r, half = mpf("3e-3"), mpf("0.35e-3")
        volume = 2 * mpmath.pi * mpf("10e-3") * segment(r, half)
    area = segment_area(half_chord=0.35e-3, radius=3e-3)
    assert float(circle_volume(area=area, track_radius=10e-3)) == pytest.approx(float(volume), rel=1e-14)


def test_arrays_of_draws_broadcast_and_stay_finite_beyond_the_sphere():
    radius = np.array([[0.79e-3], [0.80e-3]])
    volume = np.array([1e-13, 1e-12, 1e-6])
    depth = worn_depth(volume=volume, sphere_radius=radius, flat_radius=50e-6)
    assert depth.shape == (2, 3)
    assert np.all(np.isfinite(depth))
    assert np.all(np.isfinite(segment_area(half_chord=1e-3, radius=radius)))
