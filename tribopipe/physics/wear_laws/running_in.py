"""Exponential running-in: fresh surfaces wear faster at first."""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike

from tribopipe.base.arrays import Column, Numbers
from tribopipe.physics.friction_path import FrictionPath
from tribopipe.physics.laws import LawParameter, WearLaw


@dataclass(frozen=True)
class RunningIn(WearLaw):
    """The wear rate is initially 1 + r times the steady rate; k_D is that after running-in."""

    name = "running_in"
    title = "exponential running-in"
    rate = "k_D·p·(1 + r·exp(−s/l))"
    citation = "C. A. Queener, T. C. Smith, W. L. Mitchell, Wear 8 (1965) 391"

    excess: Annotated[
        Numbers, LawParameter("r: relative increase of the initial wear rate", "ratio", low=0.0, high=1e3)
    ] = 1.0
    length: Annotated[Numbers, LawParameter("l: running-in distance", "distance", low=1e-2, high=1e5)] = 10.0

    def rate_factor(self, distance: ArrayLike, friction: FrictionPath | None) -> Column:  # noqa: ARG002
        """Return 1 + r·exp(−s/l)."""
        return np.asarray(1 + self.excess * np.exp(-np.asarray(distance) / self.length))

    def effective_distance(self, distance: ArrayLike, friction: FrictionPath | None) -> Column:  # noqa: ARG002
        """Return s + r·l·(1 − exp(−s/l)), m."""
        s = np.asarray(distance)
        return np.asarray(s - self.excess * self.length * np.expm1(-s / self.length))
