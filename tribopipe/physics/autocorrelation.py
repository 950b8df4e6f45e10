"""Effective number of independent samples, and uncertainty of parameters fitted to correlated samples.

Parameters of least squares have their covariance under noise that is white over short stretches and wanders over long
ones.

The integrated autocorrelation time of residuals misses a slow wander, of which a fitted curve takes the slowest part.
So the residuals' means over blocks are described as

e = σ·(w + √r·f)

with w white and f a stationary process with memory, Matérn of order 1/2 or 3/2 and correlation length ℓ. σ is found by
restricted maximum likelihood, which knows what the fit has taken (D. A. Harville, JASA 72 (1977) 320); r, ℓ and the
order are averaged over with the weight that this likelihood and a prior give them. The parameters stay those of
ordinary least squares; their covariance is (JᵀJ)⁻¹·JᵀCJ·(JᵀJ)⁻¹ with the covariance C of the noise.
"""

import math
from collections.abc import Iterator
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tribopipe.base.arrays import Column

_FEWEST = 2.0
_FEW_LAGS = (8, 64)
_REMEMBERED = 0.5
"""Autocorrelation at the last of few lags above which some more will not do."""
_INDEPENDENT = 1e-13
"""Square of the share of a curve that others must leave for it to count as another one."""
_MOST_TAKEN = 0.5
"""Share of the independent samples that fitted parameters are counted with at most."""


def effective_samples(residuals: Column) -> float:
    """Return the number of independent samples that a stationary series amounts to: n/τ.

    τ = 1 + 2·Σρ_k is the integrated autocorrelation time, summed up to the first pair of lags whose sum is negative
    (C. J. Geyer, Statistical Science 7 (1992) 473, initial positive sequence). τ is at least 1, so that
    anticorrelation is never counted as extra information.
    """
    n = len(residuals)
    centred = residuals - np.mean(residuals)
    power = float(np.dot(centred, centred))
    if n < 4 or power == 0:
        return max(_FEWEST, float(n))
    for covariance in _covariances(centred):
        pairs = covariance[: len(covariance) // 2 * 2].reshape(-1, 2).sum(axis=1)
        negative = np.flatnonzero(pairs < 0)
        if len(negative):
            pairs = pairs[: negative[0]]
            break
    time = max(1.0, 2 * float(np.sum(pairs)) / power - 1)
    return max(_FEWEST, n / time)


def _covariances(centred: Column) -> Iterator[Column]:
    """Yield the first autocovariances, of more lags each time, and at last all; each times the number of samples.

    Most noise is forgotten within a few lags, whose products cost far less than a Fourier transform of everything.
    """
    n = len(centred)
    for lags in _FEW_LAGS:
        if lags < n:
            few = np.array([np.dot(centred[lag:], centred[: n - lag]) for lag in range(lags)])
            yield few
            if few[-1] > _REMEMBERED * few[0]:
                break
    length = _quick_length(2 * n - 1)
    spectrum = np.fft.rfft(centred, length)
    yield np.fft.irfft(spectrum.real**2 + spectrum.imag**2, length)[:n]


def _quick_length(least: int) -> int:
    """Return a length, at least so many, for which the Fourier transform is quick."""
    return min(odd << (-(-least // odd) - 1).bit_length() for odd in (1, 3, 5, 9, 15, 25))


def left_of(reading: Column, smooth: Column) -> tuple[Column, int]:
    """Return what smooth curves, the rows given, leave of a reading after least squares, and how many are independent.

    By their normal equations, whose sums cost a fraction of any other way and which curves unlike each other bear well.
    """
    normal = smooth @ smooth.T
    lengths = np.sqrt(np.diag(normal))
    powers, along = np.linalg.eigh(normal / np.outer(lengths, lengths))
    kept = powers > _INDEPENDENT * powers[-1]
    basis = along[:, kept] / lengths[:, None]
    parameters = basis @ (basis.T @ (smooth @ reading) / powers[kept])
    return reading - parameters @ smooth, int(np.count_nonzero(kept))


def inflation(residuals: Column, parameters: int, independent: float | None = None) -> float:
    """Return the variance of one residual times τ: what a least-squares (JᵀJ)⁻¹ is multiplied by.

    The number of ``independent`` residuals is counted where it is not known.

    Smooth fitted curves take as many independent samples out of correlated residuals as they have ``parameters``: out
    of their sum of squares (JCGM 100:2008, H.3) and out of their slowest part, which makes up τ.
    """
    n, independent = len(residuals), independent or effective_samples(residuals)
    left = 1 - min(_MOST_TAKEN, parameters / independent)
    return float(np.dot(residuals, residuals)) / n / left * (n / independent) / left


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
    basis = _basis(slopes)
    fits = [_likelihood(basis, means, wander) for wander in wanders]
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


def _basis(slopes: Column) -> Column:
    """Return orthonormal rows for what slopes span; some may be alike in the means of blocks."""
    scaled = slopes / np.maximum(np.sqrt(np.vecdot(slopes, slopes)), np.finfo(float).tiny)[:, None]
    _, lengths, rows = np.linalg.svd(scaled, full_matrices=False)
    return np.asarray(rows[lengths**2 > _INDEPENDENT * lengths[0] ** 2])


def _likelihood(basis: Column, means: Column, wander: _Wander) -> tuple[Column, Column]:
    """Return for each r the logarithm of the restricted likelihood, and σ²; −∞ for a wander out of all proportion."""
    blocks, fitted = len(means), len(basis)
    design, data = basis @ wander.along, means @ wander.along
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
