"""What a virtual instrument draws: errors once per run, noise, and post-test measurements about the truth."""

import math
from collections.abc import Callable

import numpy as np
from numpy.random import Generator

from tribopipe.base.arrays import Column
from tribopipe.documents.plan import RecordingSensors
from tribopipe.documents.quantity import Quantity

TrueValue = Callable[[Quantity], float]
"""What makes the true value of a quantity out of the stated one."""


def systematic_errors(seed: int, *, drawn: bool) -> TrueValue:
    """Return what makes the true value of a quantity out of the stated one: another error each time, or none."""
    # A stream of its own, so that the noise is the same with these errors and without.
    rng = np.random.Generator(np.random.PCG64([seed, 1]))

    def off(stated: Quantity) -> float:
        error = (stated.standard_uncertainty or 0.0) * float(rng.standard_normal())
        return stated.value + (error if drawn else 0.0)

    return off


def read_depth(true: Column, time: Column, sensors: RecordingSensors, rng: Generator) -> Column:
    """Return the depth as digitised, m, from what the sensor would show at ``time``, s, without noise."""
    noise = correlated(rng, len(time), sensors.depth_correlation_time.value * sensors.sampling_rate.value)
    step = sensors.depth_resolution.value
    return np.asarray(np.round((true + sensors.depth_noise.value * noise) / step) * step)


def read_forces(
    friction: Column, load: float, nominal: float, sensors: RecordingSensors, rng: Generator
) -> tuple[Column, Column]:
    """Return friction force and normal force as recorded, N, from the true friction coefficient and the true load.

    The load cell shows the nominal load: by how much the true one is off is the error of its calibration.
    """
    count = len(friction)
    noise = correlated(rng, count, sensors.friction_correlation_time.value * sensors.sampling_rate.value)
    mu = friction + sensors.friction_noise.value * noise
    wobble = 1 + sensors.load_noise.value * rng.standard_normal(count)
    return mu * (load * wobble), nominal * wobble


def correlated(rng: Generator, count: int, length: float) -> Column:
    """Draw first-order autoregressive noise of unit variance that forgets itself over ``length`` samples."""
    from scipy.signal import lfilter

    memory = math.exp(-1 / length)
    white = rng.standard_normal(count)
    start = white[:1] * memory
    shaped, _ = lfilter([math.sqrt(1 - memory**2)], [1.0, -memory], white[1:], zi=start)
    return np.concatenate([white[:1], shaped])


def measured(true: float, spread: float, rng: Generator, unit: str = "m") -> Quantity:
    """Draw a post-test measurement about its true value."""
    return Quantity(value=true + spread * float(rng.standard_normal()), unit=unit, standard_uncertainty=spread)
