"""Uncertainty of fitted curves under noise with memory: how often intervals hold the truth."""

import numpy as np
import pytest
from scipy.linalg import toeplitz
from scipy.signal import lfilter

from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import FrictionRecipe
from tribopipe.evaluation.friction import fit_friction
from tribopipe.physics.autocorrelation import effective_samples, parameter_covariance

SAMPLES = 1200
PLACE = np.linspace(0, 1, SAMPLES)


def white(rng):
    return rng.standard_normal(SAMPLES)


def autoregressive(rng):
    return lfilter([(1 - 0.9**2) ** 0.5], [1, -0.9], rng.standard_normal(SAMPLES + 200))[200:]


def wander(rng):
    """White noise, and a Gaussian process of twice its size that changes over a tenth of the record."""
    knots = np.linspace(0, 1, 60)
    covariance = np.exp(-0.5 * (np.subtract.outer(knots, knots) / 0.1) ** 2) + 1e-8 * np.eye(60)
    slow = np.linalg.cholesky(covariance) @ rng.standard_normal(60)
    return 0.5 * rng.standard_normal(SAMPLES) + np.interp(PLACE, knots, slow)


def one_over_f(rng):
    frequencies = np.maximum(np.fft.rfftfreq(2 * SAMPLES), 0.5 / SAMPLES)
    amplitudes = (rng.standard_normal(SAMPLES + 1) + 1j * rng.standard_normal(SAMPLES + 1)) / np.sqrt(frequencies)
    noise = np.fft.irfft(amplitudes)[:SAMPLES]
    return noise / np.std(noise)


NOISES = [white, autoregressive, wander, one_over_f]


@pytest.mark.slow
@pytest.mark.parametrize("noise", NOISES)
def test_intervals_of_a_line_hold_the_truth(noise):
    jacobian, held, runs = np.stack([np.ones(SAMPLES), PLACE - 0.5]), np.zeros(2), 200
    for seed in range(runs):
        reading = noise(np.random.default_rng(seed))
        found = np.linalg.lstsq(jacobian.T, reading)[0]
        residuals = reading - found @ jacobian
        covariance = parameter_covariance(jacobian, residuals, effective_samples(residuals))
        held += np.abs(found) < 1.96 * np.sqrt(np.diag(covariance))
    assert np.all(held / runs >= 0.93 - 3 * (0.95 * 0.05 / runs) ** 0.5)


def test_white_noise_has_the_covariance_of_ordinary_least_squares():
    jacobian, found = np.stack([np.ones(SAMPLES), PLACE - 0.5]), []
    for seed in range(50):
        reading = white(np.random.default_rng(seed))
        residuals = reading - np.linalg.lstsq(jacobian.T, reading)[0] @ jacobian
        found.append(np.diag(parameter_covariance(jacobian, residuals, effective_samples(residuals))))
    ordinary = np.diag(np.linalg.inv(jacobian @ jacobian.T))
    np.testing.assert_allclose(np.sqrt(np.median(found, axis=0) / ordinary), 1, atol=0.2)


def test_memory_half_as_long_as_a_block_is_not_lost():
    jacobian, found = np.stack([np.ones(SAMPLES), np.exp(-PLACE / 0.1)]), []
    taken = np.linalg.pinv(jacobian.T)
    truth = np.sqrt(np.diag(taken @ toeplitz(0.8 ** np.arange(SAMPLES)) @ taken.T))
    for seed in range(60):
        noise = lfilter([0.6], [1, -0.8], np.random.default_rng(seed).standard_normal(2 * SAMPLES))
        residuals = noise[SAMPLES:] - (taken @ noise[SAMPLES:]) @ jacobian
        found.append(np.sqrt(np.diag(parameter_covariance(jacobian, residuals, effective_samples(residuals)))))
    np.testing.assert_array_less(0.95 * truth, np.median(found, axis=0))
    np.testing.assert_array_less(np.median(found, axis=0), 1.2 * truth)


def test_curves_that_differ_within_one_block_only_leave_the_steady_value_its_uncertainty():
    decay = np.exp(-PLACE / 1e-4)
    jacobian = np.stack([decay, np.ones(SAMPLES), 1e4 * PLACE * decay])
    residuals = white(np.random.default_rng(0))
    covariance = parameter_covariance(jacobian, residuals, SAMPLES)
    assert np.sqrt(covariance[1, 1]) == pytest.approx(SAMPLES**-0.5, rel=0.2)


@pytest.mark.slow
@pytest.mark.parametrize("noise", NOISES)
def test_intervals_of_friction_hold_the_truth(bare_run, noise):
    from test_friction import with_friction

    distance, truth, held, found = 100 * PLACE, (0.2, 0.5, 15.0), np.zeros(3), 0
    whole = FrictionRecipe(start=Quantity(value=1e-12, unit="m"))
    for seed in range(200):
        mu = 0.2 * np.exp(-distance / 15) + 0.5 + 0.02 * noise(np.random.default_rng(seed))
        fit = fit_friction(with_friction(bare_run, mu, distance), whole)
        if fit.outcome == "exponential":
            found += 1
            for place, one in enumerate((fit.amplitude, fit.steady_state, fit.running_in_distance)):
                held[place] += abs(one.value - truth[place]) < 1.96 * one.standard_uncertainty
    # Where the wander hides the running-in, the steady value alone is reported.
    assert found > 40
    assert np.all(held / found >= 0.93 - 3 * (0.95 * 0.05 / found) ** 0.5)
