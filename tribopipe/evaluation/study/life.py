"""Where along a test the first body reaches a wear depth, with its interval."""

from collections.abc import Callable

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.documents.quantity import Quantity
from tribopipe.physics.uncertainty import TAILS
from tribopipe.results.agreement import EndOfLife

_ITERATIONS = 40


def end_of_life(depth: float, wanted: Column, effective: Callable[[Column], Column], unit: str) -> EndOfLife | None:
    """Return where a run reaches a depth, m, for draws of k_D; none where k_D is rather zero.

    ``wanted`` is the progress at which Archard's law would, not finite where it never would; ``effective`` gives the
    progress S(s) after which that law would have worn as much. S(s) = S* is solved by s ← s·S*/S(s): S(s)/s changes
    slowly.
    """
    reached = np.where(np.isfinite(wanted), wanted, np.nan)
    for _ in range(_ITERATIONS):
        reached = reached * wanted / effective(reached)
    ever = np.where(np.isfinite(reached), reached, np.inf)
    low, middle, high = np.quantile(ever, [TAILS[0], 0.5, TAILS[1]], method="inverted_cdf").tolist()
    if not np.isfinite(middle):
        return None
    return EndOfLife(
        wear_depth=Quantity(value=depth, unit="m"),
        place=Quantity(value=middle, unit=unit),
        interval=(Quantity(value=low, unit=unit), Quantity(value=high, unit=unit) if np.isfinite(high) else None),
    )
