"""Counting independent samples, against series whose autocorrelation is known."""

import numpy as np
import pytest

from tribopipe.noise import effective_samples, inflation
from tribopipe.simulate.drawing import correlated as _correlated


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
