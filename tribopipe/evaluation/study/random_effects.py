"""One k_D from several runs, with the scatter between them: a random-effects mean.

Run i found x_i with its own variance u_i², and the runs scatter by τ about the mean beyond that. τ² is Paule and
Mandel's estimate (`paule_mandel`); weights are 1/(u_i² + τ²). x is √k_D rather than k_D: worn depth grows about as
√k_D, and it is errors of depth that make k_D uncertain, so that they are about symmetric in x, and k_D = 0 is a value
like any other. Errors that runs share cannot be averaged away and are left out of u_i; they enter as every draw of the
mean takes all runs together.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.random import Generator
from numpy.typing import ArrayLike

from tribopipe.base.arrays import Column
from tribopipe.results.study import BetweenRuns

_FEWEST_TO_JUDGE = 4
"""Minimum number of runs: with fewer, an outlier cannot be distinguished from scatter."""
_UNLIKELY = 0.01
"""Probability below which runs are not taken to have agreed so well by chance."""
_OUTLIER_LEVEL = 0.05
"""Probability of calling any run of a sound set an outlier, shared out among the runs."""
_NEGLIGIBLE = 1e-14
"""Tolerance of τ² relative to the smallest within-run variance."""


class Scale(NamedTuple):
    """The x that runs are averaged in."""

    power: float
    """x = k_D^power."""

    def of(self, coefficient: ArrayLike) -> Column:
        """Return x for k_D, m²/N."""
        return np.asarray(coefficient, dtype=float) ** self.power

    def back(self, x: ArrayLike) -> Column:
        """Return k_D, m²/N, for x; no k_D has a root below zero."""
        return np.asarray(x) if self.power == 1 else np.maximum(x, 0.0) ** (1 / self.power)


DEPTHS, VOLUMES = Scale(0.5), Scale(1.0)
"""Of k_D by wear depths, and by wear volumes."""


@dataclass(frozen=True)
class Combination:
    """Random-effects mean of x over several runs."""

    weights: Column
    scatter: float
    """τ, in units of x."""
    summary: BetweenRuns | None
    scale: Scale

    def best(self, coefficients: ArrayLike) -> float:
        """Return k_D, m²/N, of all runs from that of each."""
        return float(self.scale.back(self.scale.of(coefficients) @ self.weights))

    def draw(self, draws: Column, rng: Generator) -> tuple[Column, Column]:
        """Return k_D of all runs and of a further one for draws of each run's k_D, (draws, runs).

        τ is known from n runs only: in each draw it is τ·√((n − 1)/χ²), χ² with n − 1 degrees of freedom. Of two or
        three runs that has no variance, and no more of it counts than up to its 99 % quantile.
        """
        from scipy.stats import chi2

        count, runs = draws.shape
        mean = self.scale.of(draws) @ self.weights
        if not self.scatter:
            return self.scale.back(mean), self.scale.back(mean)
        least = float(chi2.ppf(_UNLIKELY, runs - 1))
        scatter = self.scatter * np.sqrt((runs - 1) / np.maximum(rng.chisquare(runs - 1, count), least))
        of_mean = math.sqrt(float(self.weights @ self.weights))
        known = self.scale.back(mean + scatter * of_mean * rng.standard_normal(count))
        return known, self.scale.back(self.scale.of(known) + scatter * rng.standard_normal(count))


def combine(ids: Sequence[str], best: Sequence[float], draws: Column, scale: Scale = DEPTHS) -> Combination:
    """Weigh runs by their best k_D and by Monte Carlo of it, (draws, runs)."""
    if len(ids) == 1:
        return Combination(np.ones(1), 0.0, None, scale)
    from scipy.stats import chi2

    covariance = np.cov(scale.of(draws).T)
    shared = float(np.mean(covariance[~np.eye(len(ids), dtype=bool)]))
    own = np.maximum(np.diag(covariance) - max(shared, 0.0), 1e-3 * np.diag(covariance))
    x = scale.of(best)
    scatter = paule_mandel(x, own)
    weights = 1 / (own + scatter**2)
    weights /= weights.sum()
    mean = float(weights @ x)
    plain = 1 / own
    q = float(plain @ (x - plain @ x / plain.sum()) ** 2)
    summary = BetweenRuns(
        runs=len(ids),
        # dk/k = dx/x / power
        scatter=scatter / abs(mean) / scale.power,
        within=math.sqrt(float(np.mean(own))) / abs(mean) / scale.power,
        p_value=float(chi2.sf(q, len(ids) - 1)),
        weights=tuple(weights.tolist()),
        outliers=tuple(ids[place] for place in _outliers(x, own)),
    )
    return Combination(weights, scatter, summary, scale)


def paule_mandel(x: Column, variance: Column) -> float:
    """Return the standard deviation τ between runs, beyond what their own uncertainties explain.

    τ² solves Σ w_i·(x_i − x̄)² = n − 1 with w_i = 1/(u_i² + τ²) and x̄ = Σ w_i·x_i / Σ w_i; τ is 0 if the sum is
    smaller already without scatter.

    Parameters
    ----------
    x : ndarray, shape (n,)
        Result of each run, in any unit.
    variance : ndarray, shape (n,)
        Its own variance u_i², in that unit squared.

    Returns
    -------
    float
        τ, in the unit of ``x``.

    References
    ----------
    R. C. Paule, J. Mandel, J. Res. NBS 87 (1982) 377.
    """
    from scipy.optimize import brentq

    def excess(between: float) -> float:
        weights = 1 / (variance + between)
        return float(weights @ (x - weights @ x / weights.sum()) ** 2) - (len(x) - 1)

    if not excess(0.0) > 0:  # nan where a run has no uncertainty
        return 0.0
    # The sum is less than Σ (x_i − mean)²/τ², so that τ² is less than the variance of x.
    largest = 2 * float(np.var(x, ddof=1))
    return math.sqrt(brentq(excess, 0.0, largest, xtol=_NEGLIGIBLE * float(np.min(variance))))


def _outliers(x: Column, variance: Column) -> list[int]:
    """Return the places of runs that disagree with the mean of all others by Student's t, Bonferroni-corrected."""
    from scipy.stats import t

    count = len(x)
    if count < _FEWEST_TO_JUDGE:
        return []
    found = []
    for place in range(count):
        others = np.arange(count) != place
        scatter = paule_mandel(x[others], variance[others])
        weights = 1 / (variance[others] + scatter**2)
        mean, of_mean = float(weights @ x[others] / weights.sum()), 1 / float(weights.sum())
        distance = abs(x[place] - mean) / math.sqrt(variance[place] + scatter**2 + of_mean)
        if 2 * t.sf(distance, count - 2) < _OUTLIER_LEVEL / count:
            found.append(place)
    return found
