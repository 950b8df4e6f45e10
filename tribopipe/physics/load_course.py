"""The normal load along the sliding distance, as a wear law needs it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tribopipe.base.arrays import Column
from tribopipe.physics.friction_path import FrictionPath
from tribopipe.physics.laws import WearLaw


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
        beyond = law.effective_distance(slid, friction) - _of(knots, place)
        return np.asarray(_of(reached, place) + share[place] * beyond)


def effective_distance(
    law: WearLaw, distance: ArrayLike, friction: FrictionPath | None, load: LoadCourse | None
) -> Column:
    """Return the distance over which Archard's law wears as much under the mean load, m; a load of None is constant."""
    if load is None:
        return law.effective_distance(distance, friction)
    return load.effective_distance(law, distance, friction)


def _of(values: Column, places: NDArray[np.intp]) -> Column:
    """Return the values at places: of each draw, a row, at its own, where there are several of both."""
    if values.ndim < 2 or places.ndim < 2:
        return np.asarray(values[..., places])
    wide = np.broadcast_to(places, (*values.shape[:-1], places.shape[-1]))
    return np.take_along_axis(values, wide, axis=-1)
