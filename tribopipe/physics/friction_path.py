"""The friction coefficient along the sliding distance, as a wear law needs it."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from tribopipe.base.arrays import Column, Numbers


def junction_factor(coefficient: ArrayLike) -> Column:
    """Return Sarkar's √(1 + 3μ²) (Eq. 2)."""
    return np.asarray(np.sqrt(1 + 3 * np.square(coefficient)))


class FrictionPath(Protocol):
    """Friction coefficient along the sliding distance."""

    def coefficient(self, distance: ArrayLike) -> Column:
        """Return μ at sliding distances in m."""
        ...

    def sarkar_distance(self, distance: ArrayLike) -> Column:
        """Return S(s) = ∫₀ˢ √(1 + 3μ²) ds', m."""
        ...

    def work_per_load(self, distance: ArrayLike) -> Column:
        """Return the friction work over the normal load, ∫₀ˢ μ ds', m."""
        ...


@dataclass(frozen=True)
class ExponentialFriction:
    """μ(s) = A·exp(−s/c) + b (Eq. 7). A and b are ratios, c in m; A = 0 is a constant μ."""

    amplitude: Numbers
    steady_state: Numbers
    running_in_distance: Numbers = 1.0
    divided_by_load: bool = False
    """Whether it was derived from a friction force, so that it depends on the load that it was divided by."""

    def coefficient(self, distance: ArrayLike) -> Column:
        """Return μ at sliding distances in m."""
        decay = np.exp(-np.asarray(distance, dtype=float) / self.running_in_distance)
        return np.asarray(self.amplitude * decay + self.steady_state)

    def sarkar_distance(self, distance: ArrayLike) -> Column:
        """Return S(s) in closed form, m.

        With r(μ) = √(1 + 3μ²) and q = r(b), substituting μ for s turns the integral into
        S = q·s + c·[r + √3·b·asinh(√3 μ) − q·ln(1 + 3bμ + q·r)] between μ(s) and μ(0). Each difference is written with
        μ(0) − μ(s) as a factor, so that short distances lose no digits.
        """
        s, c = np.asarray(distance, dtype=float), self.running_in_distance
        start, now = self.amplitude + self.steady_state, self.coefficient(s)
        drop = -self.amplitude * np.expm1(-s / c)
        r_start, r_now, q = junction_factor(start), junction_factor(now), junction_factor(self.steady_state)
        root_drop = 3 * (start + now) * drop / (r_start + r_now)
        asinh_drop = np.arcsinh(
            3 * (start + now) * drop / (np.sqrt(3) * (start * r_now + now * r_start) + (start + now == 0))
        )
        shift = (3 * self.steady_state * drop + q * root_drop) / (1 + 3 * self.steady_state * now + q * r_now)
        bracket = root_drop + np.sqrt(3) * self.steady_state * asinh_drop - q * np.log1p(shift)
        return np.asarray(q * s + c * bracket)

    def work_per_load(self, distance: ArrayLike) -> Column:
        """Return ∫₀ˢ μ ds' = b·s + A·c·(1 − exp(−s/c)), m."""
        s, c = np.asarray(distance, dtype=float), self.running_in_distance
        return np.asarray(self.steady_state * s - self.amplitude * c * np.expm1(-s / c))


@dataclass(frozen=True)
class MeasuredFriction:
    """μ as recorded: samples at increasing sliding distances (m), constant before the first and after the last."""

    distance: Column
    samples: Column

    def coefficient(self, distance: ArrayLike) -> Column:
        """Return μ at sliding distances in m."""
        return np.asarray(np.interp(np.asarray(distance, dtype=float), self.distance, self.samples))

    def sarkar_distance(self, distance: ArrayLike) -> Column:
        """Return S(s) by the trapezoidal rule over the samples, m."""
        return self._integral(junction_factor(self.samples), distance)

    def work_per_load(self, distance: ArrayLike) -> Column:
        """Return ∫₀ˢ μ ds' by the trapezoidal rule over the samples, m."""
        return self._integral(self.samples, distance)

    def _integral(self, factor: Column, distance: ArrayLike) -> Column:
        inner = np.diff(self.distance) * (factor[1:] + factor[:-1]) / 2
        at_samples = self.distance[0] * factor[0] + np.concatenate([[0.0], np.cumsum(inner)])
        s = np.asarray(distance, dtype=float)
        inside = np.interp(s, np.concatenate([[0.0], self.distance]), np.concatenate([[0.0], at_samples]))
        return np.asarray(inside + np.maximum(s - self.distance[-1], 0) * factor[-1])
