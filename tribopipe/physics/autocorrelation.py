"""How much independent information correlated samples hold."""

from collections.abc import Iterator

import numpy as np

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
