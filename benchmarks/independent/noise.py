"""Noise of a sensor: series of it, and the covariance of its block means."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray
from scipy.linalg import toeplitz
from scipy.signal import lfilter

Column = NDArray[np.float64]
_LONGER = 4
"""Pink noise is cut from a series so many times as long, so that its ends know nothing of each other."""


class Noise(Protocol):
    """One kind of noise."""

    def draw(self, rng: Generator, count: int, interval: float) -> Column:
        """Return a series of samples, ``interval`` seconds apart."""
        ...

    def covariance(self, count: int, interval: float, blocks: int) -> Column:
        """Return the covariance of the means of so many equal blocks of that series."""
        ...


@dataclass(frozen=True)
class White:
    """Independent samples."""

    spread: float

    def draw(self, rng: Generator, count: int, interval: float) -> Column:  # noqa: ARG002
        """Return a series."""
        return self.spread * rng.standard_normal(count)

    def covariance(self, count: int, interval: float, blocks: int) -> Column:  # noqa: ARG002
        """Return the covariance of block means."""
        return np.eye(blocks) * self.spread**2 / (count // blocks)


@dataclass(frozen=True)
class Autoregressive:
    """AR(1): an exponential autocorrelation with a time constant, s."""

    spread: float
    time: float

    def draw(self, rng: Generator, count: int, interval: float) -> Column:
        """Return a series, stationary from its first sample."""
        memory = float(np.exp(-interval / self.time))
        shocks = np.sqrt(1 - memory**2) * rng.standard_normal(count)
        shocks[0] = rng.standard_normal()
        return np.asarray(self.spread * lfilter([1.0], [1.0, -memory], shocks))

    def covariance(self, count: int, interval: float, blocks: int) -> Column:
        """Return the covariance of block means."""
        return _of_blocks(self.spread**2 * np.exp(-interval / self.time * np.arange(count)), blocks)


@dataclass(frozen=True)
class Pink:
    """1/f noise; the standard deviation is that of the frequencies above one per record."""

    spread: float

    def _power(self, count: int) -> Column:
        """Return the variance at each frequency of a longer series; that at frequency 0 does not matter."""
        frequency = np.arange(_LONGER * count // 2 + 1)
        power = 1 / np.maximum(frequency, 1)
        power[0] = 0.0
        return np.asarray(power * self.spread**2 / np.sum(power[frequency >= _LONGER]))

    def draw(self, rng: Generator, count: int, interval: float) -> Column:  # noqa: ARG002
        """Return a series."""
        power = self._power(count)
        phases = rng.standard_normal((2, len(power)))
        spectrum = np.sqrt(power / 2) * (phases[0] + 1j * phases[1])
        return np.asarray(np.fft.irfft(spectrum, _LONGER * count)[:count] * _LONGER * count / np.sqrt(2))

    def covariance(self, count: int, interval: float, blocks: int) -> Column:  # noqa: ARG002
        """Return the covariance of block means."""
        lags = np.fft.irfft(self._power(count), _LONGER * count) * _LONGER * count / 2
        return _of_blocks(lags[:count], blocks)


@dataclass(frozen=True)
class Walk:
    """A random walk from 0, with this standard deviation at the end of the record."""

    spread: float

    def draw(self, rng: Generator, count: int, interval: float) -> Column:  # noqa: ARG002
        """Return a series."""
        return np.asarray(np.cumsum(rng.standard_normal(count)) * self.spread / np.sqrt(count))

    def covariance(self, count: int, interval: float, blocks: int) -> Column:  # noqa: ARG002
        """Return the covariance of block means, of a walk in continuous time."""
        start = np.arange(blocks) / blocks
        earlier = np.minimum.outer(start, start)
        within = np.where(np.eye(blocks, dtype=bool), 1 / 3, 1 / 2)
        return np.asarray(self.spread**2 * (earlier + within / blocks))


def _of_blocks(lags: Column, blocks: int) -> Column:
    """Return the covariance of block means from the autocovariance at each lag."""
    size = len(lags) // blocks
    both = np.concatenate([lags[size - 1 : 0 : -1], lags, np.zeros(size)])
    triangle = np.convolve(np.ones(size), np.ones(size)) / size**2
    means = np.convolve(both, triangle, mode="valid")[: blocks * size : size]
    return np.asarray(toeplitz(means))
