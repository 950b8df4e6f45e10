"""A wear law: fresh surfaces wear faster until they have run in."""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike

from tribopipe.base.arrays import Column, Numbers
from tribopipe.physics.friction_path import FrictionPath
from tribopipe.physics.laws import LawParameter, WearLaw


@dataclass(frozen=True)
class RunningIn(WearLaw):
    """Wear begins 1 + r times as fast as it goes on, and k_D is that of surfaces that have run in."""

    name = "running_in"
    title = "exponential running-in"
    rate = "k_D·p·(1 + r·exp(−s/l))"
    citation = "C. A. Queener, T. C. Smith, W. L. Mitchell, Wear 8 (1965) 391"

    excess: Annotated[Numbers, LawParameter("r: how much faster wear begins", "ratio", low=0.0, high=1e3)] = 1.0
    length: Annotated[Numbers, LawParameter("l: over which it runs in", "distance", low=1e-2, high=1e5)] = 10.0

    def rate_factor(self, distance: ArrayLike, friction: FrictionPath | None) -> Column:
        """Return 1 + r·exp(−s/l)."""
        return np.asarray(1 + self.excess * np.exp(-np.asarray(distance) / self.length))

    def effective_distance(self, distance: ArrayLike, friction: FrictionPath | None) -> Column:
        """Return s + r·l·(1 − exp(−s/l)), m: left out, it would be found by quadrature."""
        s = np.asarray(distance)
        return np.asarray(s - self.excess * self.length * np.expm1(-s / self.length))
