"""The sliding distance at which a pin reaches a wear depth, with its interval."""

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.documents.quantity import Quantity
from tribopipe.evaluation.study.member import RunDraws
from tribopipe.physics.uncertainty import TAILS
from tribopipe.results.agreement import EndOfLife

_ITERATIONS = 40


def end_of_life(draws: RunDraws, coefficients: Column, depth: float) -> EndOfLife | None:
    """Return where a run reaches a depth, m, for draws of k_D; none where k_D is rather zero.

    Raises ``ContactError`` for a depth past the tip.

    S(s) = V(h)/(k_D·F_N) is solved by s ← s·S/S(s): S(s)/s changes slowly.
    """
    problem, values = draws.run.problem, draws.values
    volume = problem.pin(values).volume(depth) / values["normal_load"]
    wearing = coefficients > 0
    wanted = np.where(wearing[:, None], volume / np.where(wearing, coefficients, 1.0)[:, None], np.nan)
    distance = wanted
    for _ in range(_ITERATIONS):
        distance = distance * wanted / problem.effective_distance(values, distance)
    reached = np.where(wearing, distance[:, 0], np.inf)
    low, middle, high = np.quantile(reached, [TAILS[0], 0.5, TAILS[1]], method="inverted_cdf")
    if not np.isfinite(middle):
        return None
    return EndOfLife(
        wear_depth=Quantity(value=depth, unit="m"),
        place=_metres(float(middle)),
        interval=(_metres(float(low)), _metres(float(high)) if np.isfinite(high) else None),
    )


def _metres(value: float) -> Quantity:
    return Quantity(value=value, unit="m")
