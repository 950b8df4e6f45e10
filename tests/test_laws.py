"""Wear laws and the friction along the way, against quadrature and high-precision arithmetic."""

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

from tribopipe.base.errors import FitError
from tribopipe.documents.quantity import Quantity
from tribopipe.physics.friction_path import ExponentialFriction, MeasuredFriction
from tribopipe.physics.laws import LAWS, WearLaw

TABLE_2 = {200: (0.226, 0.496, 32.877), 400: (0.244, 0.396, 607.837), 800: (0.284, 0.404, 81.704)}


@given(st.floats(-1, 2), st.floats(0, 2), st.floats(1e-3, 1e6), st.floats(1e-6, 1e6))
def test_sarkar_s_distance_in_closed_form_is_its_integral(amplitude, steady, running_in, distance):
    friction = ExponentialFriction(amplitude, steady, running_in)
    points = [x for x in (running_in, 5 * running_in, 20 * running_in) if x < distance]
    wanted, _ = quad(
        lambda s: np.sqrt(1 + 3 * float(friction.coefficient(s)) ** 2),
        0,
        distance,
        points=points or None,
        epsrel=1e-11,
        limit=500,
    )
    assert float(friction.sarkar_distance(distance)) == pytest.approx(wanted, rel=1e-9)


@pytest.mark.parametrize("load", TABLE_2)
@pytest.mark.parametrize("distance", [1e-9, 1e-3, 1.0, 500.0])
def test_sarkar_s_distance_keeps_its_digits_however_short(load, distance):
    amplitude, steady, running_in = TABLE_2[load]
    with mpmath.workdps(40):
        exact = mpmath.quad(
            lambda s: mpmath.sqrt(1 + 3 * (amplitude * mpmath.exp(-s / running_in) + steady) ** 2), [0, distance]
        )
    found = float(ExponentialFriction(amplitude, steady, running_in).sarkar_distance(distance))
    assert found == pytest.approx(float(exact), rel=1e-14)


def test_constant_friction_gives_the_constant_factor():
    friction = ExponentialFriction(0.0, 0.45)
    assert float(friction.sarkar_distance(500.0)) == pytest.approx(500 * np.sqrt(1 + 3 * 0.45**2), rel=1e-15)


def test_measured_friction_converges_to_the_closed_form_at_second_order():
    truth = ExponentialFriction(*TABLE_2[200])
    errors = []
    for samples in (500, 1000, 2000):
        s = np.linspace(0, 500, samples + 1)
        measured = MeasuredFriction(s, truth.coefficient(s))
        errors.append(float(measured.sarkar_distance(500.0) / truth.sarkar_distance(500.0) - 1))
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.05)
    assert errors[1] / errors[2] == pytest.approx(4, rel=0.05)


def test_measured_friction_is_held_constant_outside_its_samples():
    measured = MeasuredFriction(np.array([2.0, 4.0]), np.array([0.2, 0.4]))
    first, last = np.sqrt(1 + 3 * 0.2**2), np.sqrt(1 + 3 * 0.4**2)
    np.testing.assert_allclose(
        measured.sarkar_distance([0, 1, 2, 4, 6]),
        [0, first, 2 * first, 3 * first + last, 3 * first + 3 * last],
        rtol=1e-14,
    )
    np.testing.assert_allclose(measured.coefficient([0, 3, 9]), [0.2, 0.3, 0.4], rtol=1e-14)


def test_archard_s_distance_is_the_distance():
    s = np.array([0.0, 1.0, 500.0])
    np.testing.assert_array_equal(LAWS["archard"].effective_distance(s, None), s)
    np.testing.assert_array_equal(LAWS["archard"].rate_factor(s, None), 1.0)


def test_rate_factor_is_the_slope_of_the_effective_distance():
    friction, s = ExponentialFriction(*TABLE_2[400]), np.linspace(1, 500, 50)
    law = LAWS["sarkar"]
    slope = (law.effective_distance(s + 1e-4, friction) - law.effective_distance(s - 1e-4, friction)) / 2e-4
    np.testing.assert_allclose(slope, law.rate_factor(s, friction), rtol=1e-8)


@pytest.mark.parametrize(("law", "title"), [("sarkar", "Sarkar's law"), ("dissipated_energy", "The dissipated-energy")])
def test_law_with_friction_says_that_it_is_missing(law, title):
    with pytest.raises(FitError, match=f"^{title}.*--friction"):
        LAWS[law].effective_distance(np.array([1.0]), None)


@given(st.floats(-0.5, 2), st.floats(0.6, 2), st.floats(1e-3, 1e6), st.floats(1e-6, 1e6))
def test_friction_work_in_closed_form_is_the_integral_of_friction(amplitude, steady, running_in, distance):
    friction = ExponentialFriction(amplitude, steady, running_in)
    with mpmath.workdps(30):
        a, b, c, s = map(mpmath.mpf, (amplitude, steady, running_in, distance))
        exact = b * s + a * c * (1 - mpmath.exp(-s / c))
    assert float(LAWS["dissipated_energy"].effective_distance(distance, friction)) == pytest.approx(
        float(exact), rel=1e-12
    )


def test_friction_work_of_measured_friction_is_exact_at_samples_and_outside_them():
    measured = MeasuredFriction(np.array([2.0, 4.0, 5.0]), np.array([0.2, 0.4, 0.4]))
    np.testing.assert_allclose(
        LAWS["dissipated_energy"].effective_distance(np.array([0, 1, 2, 4, 5, 6.0]), measured),
        [0, 0.2, 0.4, 1.0, 1.4, 1.8],
        rtol=1e-14,
    )


@given(st.floats(0, 1e3), st.floats(1e-2, 1e5), st.floats(1e-6, 1e6))
def test_running_in_is_an_integral_in_closed_form(excess, length, distance):
    law = LAWS["running_in"].at({"law_excess": excess, "law_length": length})
    with mpmath.workdps(30):
        r, l, s = map(mpmath.mpf, (excess, length, distance))  # noqa: E741
        exact = s + r * l * (1 - mpmath.exp(-s / l))
    assert float(law.effective_distance(distance, None)) == pytest.approx(float(exact), rel=1e-12)


@pytest.mark.parametrize("law", ["archard", "dissipated_energy", "running_in", "sarkar"])
def test_effective_distance_is_the_quadrature_of_the_rate_factor(law):
    friction, s = ExponentialFriction(*TABLE_2[200]), np.array([0.0, 0.1, 3.0, 500.0])
    by_quadrature = WearLaw.effective_distance(LAWS[law], s, friction)
    np.testing.assert_allclose(LAWS[law].effective_distance(s, friction), by_quadrature, rtol=1e-8)


def test_energy_wear_coefficient_is_the_worn_volume_over_the_friction_work():
    """5 N over 100 m at μ = 0.4 is 200 J; 0.06 mm³ worn is 3e-4 mm³/J, which is a k_D of 3e-7 mm³/(N·mm)."""
    distance = float(LAWS["dissipated_energy"].effective_distance(100.0, ExponentialFriction(0.0, 0.4)))
    k_d = Quantity(value=0.06e-9 / (5.0 * distance), unit="m^2/N")
    assert k_d.to("mm^3/(N*mm)").value == pytest.approx(3e-7, rel=1e-12)
    assert 1000 * k_d.to("mm^3/(N*mm)").value == pytest.approx(0.06 / 200, rel=1e-12)


def test_friction_that_does_no_work_is_refused_and_left_out_of_draws():
    law, draws = LAWS["dissipated_energy"], ExponentialFriction(0.0, np.array([[0.1], [-0.1]]))
    with pytest.raises(FitError, match=r"found a mean friction coefficient of -0\.1; expected a value above zero"):
        law.effective_distance(np.array([1.0, 2.0]), ExponentialFriction(0.0, -0.1))
    found = law.effective_distance(np.array([1.0, 2.0]), draws)
    np.testing.assert_array_equal(np.isnan(found), [[False, False], [True, True]])
