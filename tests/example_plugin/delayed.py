"""A wear law with a delay: wear begins slowly, for example under a film that wears through."""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike

from tribopipe.base.arrays import Column, Numbers
from tribopipe.physics.friction_path import FrictionPath
from tribopipe.physics.laws import LawParameter, WearLaw


@dataclass(frozen=True)
class Delayed(WearLaw):
    """The wear rate rises from 0 to its steady value."""

    name = "delayed"
    title = "delayed wear"
    rate = "k_D·p·(1 − exp(−s/l))"
    citation = "an example, from no publication"

    length: Annotated[Numbers, LawParameter("l: length of the delay", "distance", low=1e-2, high=1e5)] = 10.0

    def rate_factor(self, distance: ArrayLike, friction: FrictionPath | None) -> Column:
        """Return 1 − exp(−s/l)."""
        return np.asarray(-np.expm1(-np.asarray(distance) / self.length))

    def effective_distance(self, distance: ArrayLike, friction: FrictionPath | None) -> Column:
        """Return s − l·(1 − exp(−s/l)), m; optional, the default is a quadrature."""
        s = np.asarray(distance)
        return np.asarray(s + self.length * np.expm1(-s / self.length))
