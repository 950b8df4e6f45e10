"""Wear of pin and counterbody together, fitted to a depth signal whose drift is more than a sensor has.

    g·reading(t) = z + ρ·(t − t₀) + h_p(V, κ·V) + h_d(V, κ·V) + noise,  V = k_D·F_N·S(s)

κ·V is the cross-section of the groove. Its wear is nearly linear in the distance, so that a free drift takes up much of
it; here the drift has the prior of a sensor, and κ is free instead.
"""

import math
from dataclasses import dataclass

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.extras.live.problem import LiveProblem
from tribopipe.physics.pin_on_track import OnTrack

_FIRST_RATIOS = (0.3, 3.0)
"""Depth of the groove over that of the pin from which the search starts."""
_LEAST_DEPTH = 1e-9
"""m, from which the search starts at least."""


@dataclass(frozen=True)
class BothWorn:
    """k_D of a pin whose counterbody wears as well."""

    problem: LiveProblem
    log_coefficient: float
    log_ratio: float
    """ln κ, κ in 1/m."""
    spread: float
    """Standard uncertainty of ln k_D by noise and drift."""

    @property
    def coefficient(self) -> float:
        """Return k_D, m²/N."""
        return math.exp(self.log_coefficient)

    def depths(self, distance: float) -> tuple[float, float]:
        """Return the wear depths of pin and counterbody, m, at a sliding distance, m."""
        unit = self.problem.unit_volume(self.problem.values, np.asarray([distance]))
        pin, groove = _depths(_tip(self.problem), unit, self.log_coefficient, self.log_ratio)
        return float(pin[0]), float(groove[0])


def both_worn(problem: LiveProblem) -> BothWorn:
    """Fit the wear of both bodies to the samples so far, by least squares."""
    from scipy.optimize import least_squares

    count = len(problem.distance) + len(problem.anchors)
    distance = np.concatenate([problem.distance, [anchor.distance for anchor in problem.anchors]])
    tip, unit = _tip(problem), problem.unit_volume(problem.values, distance)
    of_sensor = np.arange(count) < len(problem.distance)
    linear, known = _linear(problem, count)
    free = np.linalg.qr(linear)[0]
    measured, root = problem.rows(problem.values)[:count], problem.root_weights[:count]

    def residuals(place: Column) -> Column:
        pin, groove = _depths(tip, unit, *place)
        left = np.append((measured - pin - groove * of_sensor) * root, known)
        return np.asarray(left - free @ (left @ free))

    starts = [_start(problem, tip, float(unit[len(problem.distance) - 1]), ratio) for ratio in _FIRST_RATIOS]
    best = min((least_squares(residuals, start) for start in starts), key=lambda found: float(found.cost))
    covariance = np.linalg.pinv(best.jac.T @ best.jac)
    log_coefficient, log_ratio = best.x.tolist()
    return BothWorn(problem, log_coefficient, log_ratio, math.sqrt(float(covariance[0, 0])))


def _tip(problem: LiveProblem) -> OnTrack:
    return problem.end.tip.on_track(problem.values["pin_radius"])


def _depths(tip: OnTrack, unit: Column, log_coefficient: float, log_ratio: float) -> tuple[Column, Column]:
    volume = math.exp(log_coefficient) * unit
    worn = tip.worn(volume, math.exp(log_ratio) * volume)
    return worn.pin_depth, worn.groove_depth


def _linear(problem: LiveProblem, count: int) -> tuple[Column, float]:
    """Return the weighted columns of zero offsets and drift, with a last row for its prior, and that prior's value."""
    columns = problem.linear[:count, : problem.drift_column + 1]
    expected, spread = problem.plausible_drift
    prior = np.zeros((1, columns.shape[1]))
    prior[0, -1] = 1 / spread
    return np.vstack([columns, prior]), expected / spread


def _start(problem: LiveProblem, tip: OnTrack, unit: float, ratio: float) -> list[float]:
    """Return ln k_D and ln κ of a pin and a groove that together are as deep as the sensor has read."""
    read = float(np.ptp(problem.rows(problem.values)[: len(problem.distance)]))
    pin = max(read / (1 + ratio), _LEAST_DEPTH)
    worn = tip.at_depths(pin, ratio * pin)
    volume = float(worn.pin_volume)
    return [math.log(volume / unit), math.log(float(worn.groove_area) / volume)]
