"""Slow wander f(t) of a reading: a stationary process with memory, its amplitude and length marginalized.

Matérn's covariance of order 3/2 (M. L. Stein, Interpolation of Spatial Data, 1999, 2.7) is once differentiable, that of
order 1/2 (Ornstein and Uhlenbeck) is not; both together describe settling, wobble, random walks and 1/f noise.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from tribopipe.base.arrays import Column

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
