"""The noise of a reading that goes on: from the whole of it, or from its parts where something changed in between."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.special import chdtri

from tribopipe.base.arrays import Column
from tribopipe.evaluation.drift import SensorTrace
from tribopipe.evaluation.wear.problem import about_smooth
from tribopipe.extras.live.state import Means
from tribopipe.physics.autocorrelation import effective_samples, inflation

_PARTS = 5
"""Of a test, in each of which the noise is found by itself."""
_SMOOTH = 4
"""Powers of √s in a smooth curve: few, as each takes noise out of a short record."""
_PER_FREEDOM = 3.0
"""Independent samples that show as much of the noise as one that is known to be independent: over a window of M lags
the relative variance of an autocorrelation time τ is 2·(2M + 1)/n (N. Madras, A. D. Sokal, Journal of Statistical
Physics 50 (1988) 109), and a window of about 1.5·τ is summed."""
_SURE = 0.95
_LEAST = 1e-12
"""Standard deviation, m, below which a reading counts as without noise."""


@dataclass(frozen=True)
class Noise:
    """Of the reading, its autocorrelation counted in."""

    variance: float
    """Of one sample, times the autocorrelation time, m²."""
    freedom: float
    """Degrees of freedom by which that is known."""

    @property
    def most(self) -> float:
        """Variance, m², that it is below with a probability of 95 %."""
        freedom = max(self.freedom, 1.0)
        return self.variance * freedom / float(chdtri(freedom, _SURE))


def noise_of(fine: Means, trace: SensorTrace, segments: Column, planned: float) -> Noise:
    """Return the noise of a reading about a smooth curve.

    It is that of the middle one of its parts where the whole is rougher than that can be: what changes in a test is no
    noise. A test is divided up to its ``planned`` distance, m.
    """
    each = float(fine.samples[0])
    whole = _noise(*about_smooth(trace, fine.sliding_distance, segments, _SMOOTH), each)
    parts = sorted(_parts(fine, planned, each), key=lambda part: part.variance)
    if parts and whole.variance > (middle := parts[(len(parts) - 1) // 2]).most:
        return middle
    return whole


def noise_of_all(fine: Means, trace: SensorTrace, segments: Column) -> Noise:
    """Return the noise of a whole run about a smooth curve, as the fit of a finished run takes it."""
    return _noise(*about_smooth(trace, fine.sliding_distance, segments), float(fine.samples[0]))


def _parts(fine: Means, planned: float, each: float) -> Iterator[Noise]:
    """Give the noise in each part of a test that is whole."""
    number = np.floor(fine.sliding_distance / planned * _PARTS)
    for part in range(min(int(number[-1]), _PARTS)):
        root, depth = fine.root[number == part], fine.depth[number == part]
        if len(root) > 2 * _SMOOTH:
            smooth = np.polynomial.Polynomial.fit(root, depth, _SMOOTH)
            yield _noise(depth - smooth(root), _SMOOTH + 1, each)


def _noise(residuals: Column, parameters: int, each: float) -> Noise:
    """Return the noise by residuals of means over so many samples ``each``."""
    variance = max(inflation(residuals, parameters) * each, _LEAST**2)
    return Noise(variance, (effective_samples(residuals) - parameters) / _PER_FREEDOM)
