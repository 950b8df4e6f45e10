"""Wear laws and the friction along the way, against quadrature and high-precision arithmetic."""

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

from tribopipe.base.errors import FitError
from tribopipe.physics.friction_path import ExponentialFriction, MeasuredFriction
from tribopipe.physics.laws import LAWS

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


def test_sarkar_without_friction_says_what_is_missing():
    with pytest.raises(FitError, match="--friction"):
        LAWS["sarkar"].effective_distance(np.array([1.0]), None)
