"""Covariance of least-squares parameters under noise that is white over short stretches and wanders over long ones.

The integrated autocorrelation time of residuals misses a slow wander, of which a fitted curve takes the slowest part.
So the residuals' means over blocks are described as

    e = σ·(w + √r·f)

with w white and f a stationary process with memory, Matérn of order 1/2 or 3/2 and correlation length ℓ. σ is found by
restricted maximum likelihood, which knows what the fit has taken (D. A. Harville, JASA 72 (1977) 320); r, ℓ and the
order are averaged over with the weight that this likelihood and a prior give them. The parameters stay those of
ordinary least squares; their covariance is (JᵀJ)⁻¹·JᵀCJ·(JᵀJ)⁻¹ with the covariance C of the noise.
"""

import math
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tribopipe.base.arrays import Column

_BLOCKS = 100
_ROUGH = (0.007, 0.02, 0.06, 0.2, 0.6)
"""ℓ of order 1/2 over the length of the record."""
_SMOOTH = (0.02, 0.05, 0.1, 0.2, 0.4, 0.8)
"""ℓ of order 3/2 over the length of the record."""
_RATIOS = np.concatenate([[0.0], np.geomspace(0.1, 1e3, 9)])
"""r: variance of the wander over that of the white part of a block's mean."""
_STEADY = 0.98
"""Prior probability that nothing wanders; the rest is distributed uniformly over the other r. Smaller, white noise is
taken for more uncertain than it is; larger, a wander as slow as the fitted curve goes unnoticed."""
_PRIOR = np.log([_STEADY, *np.full(len(_RATIOS) - 1, (1 - _STEADY) / (len(_RATIOS) - 1))])
_MOST_WANDER = 40.0
"""Variance of the wander over that of the residuals, at most: a fit takes the larger part of a slow wander, not all."""
_FEWEST_LEFT = 3.0
"""Independent blocks that are left at least, so that the mean of a variance exists."""


class _Wander(NamedTuple):
    """A covariance of f over the blocks, as its eigenvalues and eigenvectors."""

    powers: Column
    along: Column


def parameter_covariance(jacobian: Column, residuals: Column, independent: float) -> Column:
    """Return the covariance of least-squares parameters (JᵀJ)⁻¹·JᵀCJ·(JᵀJ)⁻¹.

    Parameters
    ----------
    jacobian
        Derivatives of the fitted curve by its parameters, one row a parameter, one column an evenly spaced sample.
    residuals
        What the curve leaves of each sample.
    independent
        How many independent ones that amounts to, by their short memory (``effective_samples``).

    Returns
    -------
    Column
        Of shape (parameters, parameters), in their units.

    """
    samples, starts = len(residuals), _block_starts(len(residuals))
    counts = np.diff(np.append(starts, samples))
    normal = jacobian @ jacobian.T
    means, slopes = (np.add.reduceat(rows, starts, axis=-1) / counts for rows in (residuals, jacobian))
    white, wander = _noise_powers(
        slopes, means, _wanders(len(starts)), _beyond_blocks(len(starts), independent, samples)
    )
    # Noise that alternates, as stick-slip does, is never counted as less than its own variance.
    per_sample = max(white * samples / len(starts), float(residuals @ residuals) / max(1, samples - len(jacobian)))
    pulled = slopes * counts
    inverse = np.linalg.pinv(normal)
    return np.asarray(per_sample * inverse + inverse @ (pulled @ wander @ pulled.T) @ inverse)


def _beyond_blocks(blocks: int, independent: float, samples: int) -> float:
    """Return by what factor noise with a short memory weighs more in a long mean than the variance of blocks shows.

    Of an autoregressive process with the memory x, in blocks, 1/(1 − x·(1 − exp(−1/x))): neighboring blocks, taken for
    independent, share some of it.
    """
    memory = blocks / 2 * (1 / independent - 1 / samples)
    return 1 / (1 + memory * math.expm1(-1 / memory)) if memory > 0 else 1.0


def _block_starts(samples: int) -> NDArray[np.intp]:
    return np.unique(np.linspace(0, samples, min(_BLOCKS, samples), endpoint=False).astype(int))


@cache
def _wanders(blocks: int) -> tuple[_Wander, ...]:
    """Return covariances of f over so many evenly spaced blocks, of each order and length."""
    apart = np.abs(np.subtract.outer(np.arange(blocks), np.arange(blocks))) / blocks
    rough = [np.exp(-apart / length) for length in _ROUGH]
    smooth = [(1 + x) * np.exp(-x) for x in (np.sqrt(3) * apart / length for length in _SMOOTH)]
    found = [np.linalg.eigh(covariance) for covariance in (*rough, *smooth)]
    return tuple(_Wander(np.maximum(powers, 0.0), along) for powers, along in found)


def _noise_powers(slopes: Column, means: Column, wanders: tuple[_Wander, ...], beyond: float) -> tuple[float, Column]:
    """Return the variance of the white part of a block's mean, and the covariance of the wander over the blocks.

    Where nothing wanders, the white part stands for all of the noise's memory, and is the larger by ``beyond``.
    """
    fits = [_likelihood(slopes, means, wander) for wander in wanders]
    logs = np.array([logs + _PRIOR for logs, _ in fits])
    weights = np.exp(logs - np.max(logs))
    weights /= np.sum(weights)
    variances = weights * np.array([variances for _, variances in fits])
    variances[:, 0] *= beyond
    wander = sum(
        (one.along * (one.powers * float(by @ _RATIOS))) @ one.along.T
        for one, by in zip(wanders, variances, strict=True)
    )
    return float(np.sum(variances)), np.asarray(wander)


def _likelihood(slopes: Column, means: Column, wander: _Wander) -> tuple[Column, Column]:
    """Return for each r the logarithm of the restricted likelihood, and σ²; −∞ for a wander out of all proportion."""
    blocks, fitted = len(means), len(slopes)
    scaled = slopes / np.maximum(np.sqrt(np.vecdot(slopes, slopes)), np.finfo(float).tiny)[:, None]
    design, data = scaled @ wander.along, means @ wander.along
    powers = 1 + np.multiply.outer(_RATIOS, wander.powers)
    normal = np.einsum("ib,jb,rb->rij", design, design, 1 / powers)
    pull = np.einsum("ib,b,rb->ri", design, data, 1 / powers)
    best = np.einsum("rij,rj->ri", np.linalg.pinv(normal), pull)
    left = np.maximum((data**2 / powers).sum(axis=1) - np.vecdot(best, pull), np.finfo(float).tiny)
    free = blocks - fitted
    logs = -0.5 * (np.log(powers).sum(axis=1) + np.linalg.slogdet(normal)[1] + free * np.log(left))
    variances = left / max(_FEWEST_LEFT, free - 2)
    possible = variances * _RATIOS <= _MOST_WANDER * float(np.mean(means**2))
    return np.where(possible, logs, -np.inf), variances
