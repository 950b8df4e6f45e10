"""Functions of measured quantities with their combined standard uncertainty (JCGM 100:2008)."""

import math
from collections.abc import Callable, Sequence

from tribopipe.documents.quantity import Quantity

_NODE = math.sqrt(3)


def combined(function: Callable[..., float], given: Sequence[Quantity], unit: str) -> Quantity:
    """Return a function of independent quantities with its combined standard uncertainty (JCGM 100:2008, 5.1).

    What each contributes is the root mean square of f − f(best) over a normal distribution, by Gauss–Hermite quadrature
    with the nodes −√3u, 0 and √3u: u·|df/dx| where f is linear. Terms of second order are exact as well, so that a
    derivative that vanishes, as that of a cap's volume at no wear, does not make the result certain (5.1.2, note). Of
    a rectangular distribution the nodes are its ends and its middle, and the rule is Simpson's.
    """
    best = [float(one.value) for one in given]
    value = float(function(*best))
    shares = []
    for place, one in enumerate(given):
        spread = one.standard_uncertainty or 0.0
        moved = ([*best[:place], best[place] + step * spread, *best[place + 1 :]] for step in (-_NODE, _NODE))
        shares += [(function(*there) - value) / math.sqrt(6) for there in moved] if spread else []
    return Quantity(value=value, unit=unit, standard_uncertainty=math.hypot(*shares))
