"""Archard's law: the wear volume is proportional to load and sliding distance."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from tribopipe.base.arrays import Column
from tribopipe.physics.friction_path import FrictionPath
from tribopipe.physics.laws import WearLaw


@dataclass(frozen=True)
class Archard(WearLaw):
    """V/s = k·F_N/H (Eq. 1): friction plays no part."""

    name = "archard"
    title = "Archard's law"
    rate = "k_D·p"
    citation = "J. F. Archard, J. Appl. Phys. 24 (1953) 981"

    def rate_factor(self, distance: ArrayLike, friction: FrictionPath | None) -> Column:  # noqa: ARG002
        """Return ones."""
        return np.ones_like(np.asarray(distance, dtype=float))

    def effective_distance(self, distance: ArrayLike, friction: FrictionPath | None) -> Column:  # noqa: ARG002
        """Return the sliding distance itself."""
        return np.asarray(distance, dtype=float)
