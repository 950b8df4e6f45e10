"""Whether the wear rate of a run changes once, rather than that its sensor wanders."""

from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.evaluation.wear.depth_problem import DepthProblem
from tribopipe.physics.depth_model.mixture import ways
from tribopipe.physics.depth_model.posterior import DepthReading, regressions_of

_PLACES = (0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8)
_RATIOS = (0.1, 0.2, 0.33, 0.5, 0.67, 1.5, 2.0, 3.0, 5.0, 10.0)
_CLEARLY = 3.0
"""ln of the odds against wander from which on a change is named."""


@dataclass(frozen=True)
class RateChange:
    """One k_D before and another one after."""

    distance: float
    """Sliding distance of the change, m."""
    ratio: float
    """k_D after over k_D before."""


def rate_change(problem: DepthProblem) -> RateChange | None:
    """Return where k_D changes, if a change once is a better account of a reading than wander; else none."""
    slid, found = problem.trace.slid, {}
    for place, ratio in product(_PLACES, _RATIOS):
        found[place, ratio] = _evidence(_changed(problem, place * slid, ratio), problem.posterior.reference)
    best = max(found, key=lambda key: found[key])
    together = float(np.logaddexp.reduce(list(found.values()))) - np.log(len(found))
    others = float(np.logaddexp.reduce(problem.posterior.ways.log_anchored))
    return RateChange(best[0] * slid, best[1]) if together > others + _CLEARLY else None


def _changed(problem: DepthProblem, change: float, ratio: float) -> DepthReading:
    values, slid = problem.values, problem.trace.slid
    at_change, whole = problem.effective_distance(values, np.asarray([change, slid]))

    def share(distance: Column) -> Column:
        effective = problem.effective_distance(values, distance)
        before, after = np.minimum(effective, at_change), np.maximum(effective - at_change, 0.0)
        return np.asarray((before + ratio * after) / (at_change + ratio * (whole - at_change)))

    pin, nodes = problem.pin(values), problem.samples.nodes
    volume_share = share(nodes.distance)
    return replace(
        problem.reading, course=lambda depth: nodes.averaged(pin.worn(pin.volume(depth) * volume_share).depth)
    )


def _evidence(reading: DepthReading, reference: float) -> float:
    """Return the log evidence for a depth reading that is the sum of wear, a straight line and noise."""
    plain = regressions_of(reading, reference)[0]
    plain = replace(plain, alternatives=plain.alternatives[:1])
    return float(np.logaddexp.reduce(ways([plain], []).log_anchored))
