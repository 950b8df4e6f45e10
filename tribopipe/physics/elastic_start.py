"""How much too deep rigid bodies wear while the scar of a sphere is small: an estimate of what elasticity changes.

The elastic contact of a sphere is wider and longer than the scar of rigid bodies that have lost the same volumes, so
that scar and groove are shallower. With Hertz's radius a₀, the scar of half width a and half length b becomes

    a'⁴ = a⁴ + 1.2·a₀⁴,        b'⁴ = b⁴ + β⁴,        (a₀/β)¹² = (1/1.2)³ + (a²/(3.2·a₀²))³

where β is about a₀ at first, and along a wide groove as long as a line contact, in proportion to a₀^(3/2)/a^(1/2).
Volume is conserved: the depth of the pin is a·b/(a'·b') and that of the groove a/a' times that of rigid bodies. From a
wear depth of both bodies equal to the elastic approach a₀²/R on, this is within 2 % of local wear
(tribopipe.physics.local.track, benchmarks/contact_local_wear.py), which the two constants are from.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

_SPREAD, _LINE = 1.2, 3.2


class TooDeep(NamedTuple):
    """Wear depth by rigid bodies over that of elastic ones, less 1."""

    pin: NDArray[np.float64]
    groove: NDArray[np.float64]


def too_deep(*, half_width: ArrayLike, half_length: ArrayLike, hertz_radius: ArrayLike) -> TooDeep:
    """Return by what share the depths of rigid bodies are too large.

    Parameters
    ----------
    half_width, half_length
        Of the scar of rigid bodies, m, across and along the sliding direction.
    hertz_radius
        Contact radius of the unworn sphere, m.

    Returns
    -------
    TooDeep
        Shares of the depth of the pin and of that of the groove; infinite where there is no scar.
    """
    first = np.asarray(hertz_radius, dtype=float)
    a, b = np.asarray(half_width, dtype=float) / first, np.asarray(half_length, dtype=float) / first
    longer = np.cbrt(_SPREAD**-3 + (a**2 / _LINE) ** 3) ** -1
    with np.errstate(divide="ignore"):
        across, along = ((1 + spread / size**4) ** 0.25 for spread, size in ((_SPREAD, a), (longer, b)))
    return TooDeep(pin=np.asarray(across * along - 1), groove=np.asarray(across - 1))
