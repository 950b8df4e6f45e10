"""The Global Incremental Wear Model for a pin on a disc, against certified digits, limits and plain integration."""

import mpmath
import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from tribopipe.base.errors import ContactError
from tribopipe.physics.friction_path import ExponentialFriction
from tribopipe.physics.geometry import cap_height, cap_radius
from tribopipe.physics.hertz import contact_modulus, elastic_approach, hertz_radius
from tribopipe.physics.laws import LAWS
from tribopipe.physics.pin_on_disc import FlatPin, SphericalPin

RADIUS = 0.794e-3
SI3N4 = contact_modulus(pin_modulus=304e9, pin_ratio=0.24, disc_modulus=304e9, disc_ratio=0.24)
WC_CO = contact_modulus(pin_modulus=320e9, pin_ratio=0.24, disc_modulus=305e9, disc_ratio=0.24)
DISTANCES = np.array([10.0, 50.0, 100.0, 250.0, 500.0])
TABLE_2 = ExponentialFriction(0.226, 0.496, 32.877)

# Depths in µm at DISTANCES, worked out in 40-digit arithmetic (mm³/(N mm) = 1e-6 m²/N).
CERTIFIED = {
    "Si3N4 200 mN, Archard": (
        0.2,
        13.5e-15,
        SI3N4,
        None,
        "3.276881128288 7.357384070702 10.41765143924 16.49998514648 23.37263750258",
    ),
    "Si3N4 400 mN, Archard": (
        0.4,
        13.5e-15,
        SI3N4,
        None,
        "4.631594330148 10.40883555202 14.74387725499 23.36653793757 33.12080449065",
    ),
    "Si3N4 200 mN, Sarkar": (
        0.2,
        10.2e-15,
        SI3N4,
        TABLE_2,
        "3.559175055723 7.725113375678 10.72713985886 16.68852094500 23.48391395212",
    ),
    "WC-Co 400 mN, Archard": (
        0.4,
        0.75e-17,
        WC_CO,
        None,
        "0.05208080111 0.1806371537666 0.2846375253204 0.4922109821785 0.7248884320725",
    ),
}

loads = st.floats(-3, 3).map(lambda x: 10.0**x)
radii = st.floats(-4, np.log10(0.05)).map(lambda x: 10.0**x)
moduli = st.floats(9, 12).map(lambda x: 10.0**x)
coefficients = st.floats(-20, -11).map(lambda x: 10.0**x)
distances = st.floats(-6, 7).map(lambda x: 10.0**x)


def pin_of(load: float, radius: float, pin_modulus: float, disc_modulus: float) -> SphericalPin:
    modulus = contact_modulus(pin_modulus=pin_modulus, pin_ratio=0.3, disc_modulus=disc_modulus, disc_ratio=0.2)
    assume(load / (2 * modulus) < 0.99 * radius**2)
    return SphericalPin(normal_load=load, radius=radius, modulus=modulus)


@pytest.mark.parametrize("case", CERTIFIED)
def test_exact_model_meets_the_certified_depths(case):
    load, coefficient, modulus, friction, depths = CERTIFIED[case]
    law = LAWS["archard" if friction is None else "sarkar"]
    volume = coefficient * load * law.effective_distance(DISTANCES, friction)
    depth = SphericalPin(normal_load=load, radius=RADIUS, modulus=modulus).worn(volume).depth
    np.testing.assert_allclose(depth * 1e6, [float(text) for text in depths.split()], rtol=1e-10)


@given(loads, radii, moduli, moduli, coefficients, distances)
def test_distance_found_from_the_depth_is_the_distance_slid(
    load, radius, pin_modulus, disc_modulus, coefficient, distance
):
    pin = pin_of(load, radius, pin_modulus, disc_modulus)
    volume = coefficient * load * distance
    assume(volume < 0.999 * pin.most_volume)
    depth = pin.worn(volume).depth
    assert float(pin.volume(depth)) == pytest.approx(volume, rel=1e-12)
    assert float(pin.worn(pin.volume(depth)).depth) == pytest.approx(float(depth), rel=1e-12)


@given(loads, radii, moduli, moduli, st.floats(1e-12, 0.9))
def test_contact_radius_satisfies_the_geometry_of_figure_2(load, radius, pin_modulus, disc_modulus, worn_share):
    pin = pin_of(load, radius, pin_modulus, disc_modulus)
    state = pin.worn(worn_share * pin.most_volume)
    elastic = elastic_approach(normal_load=load, modulus=pin.modulus, contact_radius=state.radius)
    # The cap's height is wear plus elastic approach: a = √(2Rh − h²).
    assert float(cap_height(scar_radius=state.radius, sphere_radius=radius)) == pytest.approx(
        float(state.depth + elastic), rel=1e-9
    )


@given(st.floats(-15, -11).map(lambda x: 10.0**x), radii, moduli)
def test_worn_volume_is_the_cap_s_where_the_elastic_part_is_small(load_share, radius, modulus):
    pin = SphericalPin(normal_load=load_share * 2 * modulus * radius**2, radius=radius, modulus=modulus)
    volume = 0.5 * float(pin.most_volume)
    height = float(pin.worn(volume).depth)
    assert np.pi * height**2 * (3 * radius - height) / 3 == pytest.approx(volume, rel=1e-6)


def test_exact_model_agrees_with_an_integration_of_the_differential_equation():
    load, coefficient = 0.4, 0.75e-17
    pin = SphericalPin(normal_load=load, radius=RADIUS, modulus=WC_CO)

    def rate(_: float, depth: np.ndarray) -> np.ndarray:
        def gap(a: float) -> float:
            return a**2 / (RADIUS + np.sqrt(RADIUS**2 - a**2)) - load / (2 * float(WC_CO) * a) - float(depth[0])

        return np.array([coefficient * load / (np.pi * brentq(gap, 1e-6, RADIUS, xtol=1e-18, rtol=1e-14) ** 2)])

    # s = x² smooths the start, where the depth rises steeply.
    solved = solve_ivp(
        lambda x, h: 2 * x * rate(x, h), (0, 500**0.5), [0.0], rtol=1e-11, atol=1e-20, t_eval=DISTANCES**0.5
    )
    depth = pin.worn(coefficient * load * DISTANCES).depth
    np.testing.assert_allclose(depth, solved.y[0], rtol=1e-9)


def test_depth_at_zero_wear_is_zero_and_grows_with_distance():
    depth = SphericalPin(normal_load=0.2, radius=RADIUS, modulus=SI3N4).worn(np.linspace(0, 1e-12, 500)).depth
    assert depth[0] == 0
    assert np.all(np.diff(depth) > 0)


def plain_loop(load, radius, modulus, coefficient, distance, steps):
    """Fig. 2, written down a second time."""
    a = (3 * load * radius / (4 * modulus)) ** (1 / 3)
    elastic, worn, step = load / (2 * modulus * a), 0.0, distance / steps
    for _ in range(steps):
        pressure = load / (np.pi * a**2)
        worn = coefficient * pressure * step + worn
        total = worn + elastic
        a = np.sqrt(2 * radius * total - total**2)
        elastic = load / (2 * modulus * a)
    return worn


@pytest.mark.parametrize("steps", [50, 500, 5000])
def test_published_scheme_is_the_plain_loop_of_figure_2(steps):
    load, coefficient = 0.2, 13.5e-15
    volumes = np.full(steps, coefficient * load * 500.0 / steps)
    depth = SphericalPin(normal_load=load, radius=RADIUS, modulus=SI3N4).published_depth(volumes)
    assert len(depth) == steps + 1
    assert depth[-1] == pytest.approx(plain_loop(load, RADIUS, float(SI3N4), coefficient, 500.0, steps), rel=1e-12)


def test_published_scheme_converges_to_the_exact_model_at_first_order():
    load, coefficient = 0.4, 0.75e-17
    pin = SphericalPin(normal_load=load, radius=RADIUS, modulus=WC_CO)
    exact = float(pin.worn(coefficient * load * 500.0).depth)
    steps = np.array([500, 1000, 2000, 4000])
    errors = [pin.published_depth(np.full(n, coefficient * load * 500.0 / n))[-1] / exact - 1 for n in steps]
    orders = -np.diff(np.log(np.abs(errors))) / np.diff(np.log(steps))
    np.testing.assert_allclose(orders, 1.0, atol=0.03)


@pytest.mark.parametrize(("steps", "error"), [(500, 0.097), (50_000, 3.3e-5)])
def test_published_scheme_is_as_far_off_as_stated_for_200_mn(steps, error):
    pin = SphericalPin(normal_load=0.2, radius=RADIUS, modulus=SI3N4)
    volume = 13.5e-15 * 0.2 * 500.0
    depth = pin.published_depth(np.full(steps, volume / steps))[-1]
    assert depth / float(pin.worn(volume).depth) - 1 == pytest.approx(error, rel=0.02)


def test_published_scheme_refuses_steps_that_wear_the_tip_away():
    pin = SphericalPin(normal_load=0.2, radius=RADIUS, modulus=SI3N4)
    with pytest.raises(ContactError, match="use more steps"):
        pin.published_depth([1.0])


def test_hertz_radius_is_that_of_equation_4():
    # Eq. 4 and Hertz's approach a²/R with p₀: F = 4/3 E_c √R δ^1.5.
    a = float(hertz_radius(normal_load=0.2, pin_radius=RADIUS, modulus=SI3N4))
    assert 4 / 3 * float(SI3N4) * a**3 / RADIUS == pytest.approx(0.2, rel=1e-14)


def test_flat_pin_wears_in_proportion_to_distance_and_back():
    pin = FlatPin(2e-3)
    volume = np.array([0.0, 1e-12, 5e-9])
    state = pin.worn(volume)
    np.testing.assert_allclose(state.depth, volume / (np.pi * 4e-6), rtol=1e-15)
    np.testing.assert_allclose(pin.volume(state.depth), volume, rtol=1e-15)
    assert pin.published_depth([1e-9, 1e-9])[-1] == pytest.approx(2e-9 / (np.pi * 4e-6), rel=1e-14)


def test_elastic_contact_as_large_as_the_tip_is_refused():
    with pytest.raises(ContactError, match="as large as the tip"):
        SphericalPin(normal_load=1000.0, radius=1e-4, modulus=0.5e9)


def test_wear_beyond_the_tip_is_refused():
    pin = SphericalPin(normal_load=0.2, radius=RADIUS, modulus=SI3N4)
    with pytest.raises(ContactError, match="more than the volume of the tip"):
        pin.worn(1.01 * pin.most_volume)
    with pytest.raises(ContactError, match="between 0 and the tip"):
        pin.volume(1.01 * RADIUS)


@given(st.floats(-9, 0).map(lambda x: 10.0**x), radii)
def test_cap_height_and_radius_invert_each_other(share, radius):
    height = share * radius
    a = cap_radius(height=height, sphere_radius=radius)
    assume(float(a) < radius)
    assert float(cap_height(scar_radius=a, sphere_radius=radius)) == pytest.approx(height, rel=1e-6)
    exact = mpmath.mpf(radius) - mpmath.sqrt(mpmath.mpf(radius) ** 2 - mpmath.mpf(float(a)) ** 2)
    assert float(cap_height(scar_radius=a, sphere_radius=radius)) == pytest.approx(float(exact), rel=1e-7)


def test_a_long_curve_is_the_same_as_its_parts():
    pin = SphericalPin(0.2, RADIUS, SI3N4)
    volumes = np.linspace(0, float(pin.volume(2e-5)), 40_000)
    whole, part = pin.worn(volumes), pin.worn(volumes[20_000:20_010])
    for name in ("depth", "radius", "area"):
        np.testing.assert_array_equal(getattr(whole, name)[20_000:20_010], getattr(part, name))
