"""The normal load along the sliding distance, as a wear law needs it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from tribopipe.base.arrays import Column
from tribopipe.physics.friction_path import FrictionPath
from tribopipe.physics.laws import WearLaw, values_at


@dataclass(frozen=True)
class LoadCourse:
    """A normal load that changes along a test, by its mean."""

    distance: Column
    """Sliding distances between which it counts as constant, m, from 0 on."""
    path: Column
    """∫₀ˢ F_N/F̄ ds' until each of them, m."""

    def effective_distance(self, law: WearLaw, distance: ArrayLike, friction: FrictionPath | None) -> Column:
        """Return ∫₀ˢ f·F_N/F̄ ds' at sliding distances, m, by the law's own S(s) = ∫₀ˢ f ds'."""
        slid, share = np.asarray(distance, dtype=float), np.diff(self.path) / np.diff(self.distance)
        place = np.clip(np.searchsorted(self.distance, slid, side="right") - 1, 0, len(share) - 1)
        knots = law.effective_distance(self.distance, friction)
        worn = share * np.diff(knots, axis=-1)
        reached = np.concatenate([np.zeros((*worn.shape[:-1], 1)), np.cumsum(worn, axis=-1)], axis=-1)
        beyond = law.effective_distance(slid, friction) - values_at(knots, place)
        return np.asarray(values_at(reached, place) + share[place] * beyond)


def effective_distance(
    law: WearLaw, distance: ArrayLike, friction: FrictionPath | None, load: LoadCourse | None
) -> Column:
    """Return the distance over which Archard's law wears as much under the mean load, m; a load of None is constant."""
    if load is None:
        return law.effective_distance(distance, friction)
    return load.effective_distance(law, distance, friction)
