"""Counting independent samples, against series whose autocorrelation is known."""

import numpy as np
import pytest

from tribopipe.extras.simulate.instrument import correlated as _correlated
from tribopipe.physics.autocorrelation import effective_samples, inflation, left_of


@pytest.mark.parametrize("length", [0.01, 2.0, 20.0])
def test_effective_samples_are_those_of_a_first_order_process(length):
    count, memory = 200_000, np.exp(-1 / length)
    noise = _correlated(np.random.default_rng(5), count, length)
    assert effective_samples(noise) == pytest.approx(count * (1 - memory) / (1 + memory), rel=0.2)


def test_uncertainty_of_a_mean_of_correlated_samples_is_its_scatter():
    rng = np.random.default_rng(11)
    series = [_correlated(rng, 4000, 10.0) for _ in range(400)]
    stated = np.mean([np.sqrt(inflation(one - one.mean(), 1) / len(one)) for one in series])
    assert stated == pytest.approx(np.std([one.mean() for one in series]), rel=0.1)


def test_anticorrelation_counts_as_no_extra_information():
    alternating = np.tile([1.0, -1.0], 500)
    assert effective_samples(alternating) == 1000


def test_constant_residuals_are_no_information_problem():
    assert effective_samples(np.zeros(50)) == 50


@pytest.mark.parametrize("count", [5, 9, 70, 2001])
@pytest.mark.parametrize("length", [0.01, 2.0, 12.0, 80.0])
def test_sums_by_products_and_by_transform_are_those_of_all_lags(count, length):
    noise = _correlated(np.random.default_rng(count), count, length)
    centred = noise - noise.mean()
    covariance = np.correlate(centred, centred, "full")[count - 1 :]
    pairs = covariance[: count - count % 2].reshape(-1, 2).sum(axis=1)
    kept = pairs[: np.argmax(pairs < 0)] if np.any(pairs < 0) else pairs
    time = max(1.0, 2 * kept.sum() / covariance[0] - 1)
    assert effective_samples(noise) == pytest.approx(max(2.0, count / time), rel=1e-12)


def test_what_smooth_curves_leave_is_what_least_squares_leaves_and_twins_count_once():
    rng = np.random.default_rng(2)
    place = np.linspace(0, 1, 3000)
    curves = np.stack([np.ones_like(place), place, 3 * place, np.sqrt(place)])
    reading = curves.sum(axis=0) + rng.standard_normal(place.size)
    left, independent = left_of(reading, curves)
    parameters, _, rank, _ = np.linalg.lstsq(curves.T, reading)
    assert independent == rank == 3
    np.testing.assert_allclose(left, reading - parameters @ curves, atol=1e-11)
