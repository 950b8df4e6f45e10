"""How much independent information correlated samples hold."""

import numpy as np

from tribopipe.run import Column

_FEWEST = 2.0
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
    length = 1 << (2 * n - 1).bit_length()  # a power of two, for which the transform is quick
    spectrum = np.fft.rfft(centred, length)
    correlation = np.fft.irfft(np.abs(spectrum) ** 2, length)[:n] / power
    pairs = correlation[: n - n % 2].reshape(-1, 2).sum(axis=1)
    negative = np.flatnonzero(pairs < 0)
    kept = pairs[: negative[0]] if len(negative) else pairs
    time = max(1.0, 2 * float(np.sum(kept)) - 1)
    return max(_FEWEST, n / time)


def inflation(residuals: Column, parameters: int) -> float:
    """Return the variance of one residual times τ: what a least-squares (JᵀJ)⁻¹ is multiplied by.

    Smooth fitted curves take as many independent samples out of correlated residuals as they have ``parameters``: out
    of their sum of squares (JCGM 100:2008, H.3) and out of their slowest part, which makes up τ.
    """
    n, independent = len(residuals), effective_samples(residuals)
    left = 1 - min(_MOST_TAKEN, parameters / independent)
    return float(np.dot(residuals, residuals)) / n / left * (n / independent) / left
