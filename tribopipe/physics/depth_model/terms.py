"""Contributions to the depth signal other than wear: offsets, drift, settling, temperature, counterbody, wander.

Offsets and the rate of the line have flat priors. Whether the reading follows a recorded temperature, and whether it
settles, are alternatives, each with a normal prior of its amplitude about zero; they are averaged over by their
evidence. What follows the temperature may settle in addition: a thermometer is never quite where the frame is warm.

Wander f(t) is a stationary process with memory, its amplitude and length marginalized. Matérn's covariance of order
3/2 (M. L. Stein, Interpolation of Spatial Data, 1999, 2.7) is once differentiable, that of order 1/2 (Ornstein and
Uhlenbeck) is not; both together describe settling, wobble, random walks and 1/f noise.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from tribopipe.base.arrays import Column

SETTLING_TIMES = tuple(np.geomspace(0.04, 0.6, 22).tolist())
"""Time constants of an exponential settling, as shares of the test."""
AMPLITUDES = (0.03, 0.15, 0.6)
"""Standard deviations of the amplitude of a settling, as shares of the wear at the end,"""
_WARMED = 0.6
"""and of what a reading follows of the temperature."""
_FOLLOWS = 0.5
"""Prior probability that it follows a temperature that moved."""
_LEAST_WARMING = 0.05
"""Standard deviation of a recorded temperature, K, below which nothing follows from it."""


@dataclass(frozen=True)
class Alternative:
    """Terms that a reading may have in addition to the line: settling, temperature, both or none."""

    column: int | None
    """Which settling, if any."""
    deviation: float
    """Prior standard deviation of the amplitude of the settling, as a share of the wear at the end."""
    warmed: float
    """The same of what follows the temperature; 0 where nothing does."""
    probability: float
    """Prior probability."""


@dataclass(frozen=True)
class OptionalTerms:
    """Columns of optional terms at each block, of amplitude one, and their alternatives."""

    temperature: Column
    """Shape (blocks, 1), or (blocks, 0) where none was recorded or it did not move."""
    settling: Column
    """With each of ``SETTLING_TIMES``, shape (blocks, times)."""
    alternatives: tuple[Alternative, ...]
    """None of them first, and those without the temperature before those with it."""

    @property
    def columns(self) -> Column:
        """All of them, shape (blocks, terms)."""
        return np.hstack([self.temperature, self.settling])

    @property
    def time_constants(self) -> tuple[float | None, ...]:
        """Of each column: of settling, as a share of the test; none of temperature."""
        return (*[None] * self.temperature.shape[1], *SETTLING_TIMES)


def settling(time: Column, constant: float) -> Column:
    """Return 1 − exp(−t/τ) from the first sample on, with t and τ as fractions of the test."""
    return np.asarray(-np.expm1(-(time - time[0]) / constant))


def optional_terms(time: Column, temperature: Column | None) -> OptionalTerms:
    """Return the optional terms of a reading.

    Parameters
    ----------
    time
        Mean time of each block as a share of the test, shape (blocks,).
    temperature
        Mean temperature of each block, K; None if it was not recorded or did not move.

    Returns
    -------
    OptionalTerms
        Settling with each time constant and prior amplitude, with and without temperature, and none of them.
    """
    columns = np.column_stack([settling(time, constant) for constant in SETTLING_TIMES])
    if temperature is None or float(np.std(temperature)) <= _LEAST_WARMING:
        return OptionalTerms(np.empty((len(time), 0)), columns, (*_alternatives(0.0, 1.0),))
    warming = (temperature - temperature[0]) / float(np.ptp(temperature))
    alternatives = (*_alternatives(0.0, 1 - _FOLLOWS), *_alternatives(_WARMED, _FOLLOWS))
    return OptionalTerms(warming[:, None], columns, alternatives)


def _alternatives(warmed: float, probability: float) -> Iterator[Alternative]:
    """Yield no settling, and each."""
    yield Alternative(None, 0.0, warmed, probability / 2)
    share = probability / 2 / len(AMPLITUDES) / len(SETTLING_TIMES)
    for deviation in AMPLITUDES:
        for column in range(len(SETTLING_TIMES)):
            yield Alternative(column, deviation, warmed, share)


LENGTHS = {1.5: (0.02, 0.06, 0.2, 0.6), 0.5: (0.02, 0.06, 0.6)}
"""Correlation lengths, as shares of the test, by the order of the process."""
_NOISE_MEMORY = 0.06
"""Correlation length up to which a process of order 1/2 is noise with a memory, and no misfit."""


def matern(time: Column, length: float, order: float) -> Column:
    """Return the correlation matrix of f at times, as shares of the test, for a correlation length.

    exp(−d) for order 1/2 with d = |t − t'|/ℓ, and (1 + √3·d)·exp(−√3·d) for order 3/2.
    """
    apart = np.abs(time[:, None] - time) / length
    if order == 0.5:
        return np.asarray(np.exp(-apart))
    return np.asarray((1 + np.sqrt(3) * apart) * np.exp(-np.sqrt(3) * apart))


@dataclass(frozen=True)
class Wander:
    """The process at the blocks of a test in the basis in which it and white noise are both diagonal."""

    powers: Column
    """Eigenvalues of its correlation, rows weighted by the root of their weights, shape (blocks,)."""
    basis: Column
    """Eigenvectors, shape (blocks, blocks)."""
    correlation: Column
    """Of f at the blocks."""
    is_noise: bool
    """Whether it is noise with a short memory, as sensors have it, rather than a misfit."""


def wanders(time: Column, weights: Column) -> list[Wander]:
    """Return the process for each correlation length.

    Parameters
    ----------
    time
        Time of each block as a share of the test, shape (blocks,).
    weights
        Samples behind each block over their mean, shape (blocks,).
    """
    return list(_of_blocks(*(np.asarray(one, dtype=float).tobytes() for one in (time, weights))))


@lru_cache(maxsize=4)
def _of_blocks(time_bytes: bytes, weights_bytes: bytes) -> tuple[Wander, ...]:
    """Return the processes of blocks; drift correction and the fit under each law ask for the same ones."""
    time, root = np.frombuffer(time_bytes), np.sqrt(np.frombuffer(weights_bytes))
    found = []
    for order, lengths in LENGTHS.items():
        for length in lengths:
            correlation = matern(time, length, order)
            powers, basis = np.linalg.eigh(correlation * np.outer(root, root))
            is_noise = order == 0.5 and length <= _NOISE_MEMORY
            found.append(Wander(np.maximum(powers, 0.0), basis, correlation, is_noise))
    return tuple(found)
