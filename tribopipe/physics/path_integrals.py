"""Integrals along the way: ∫₀ˢ f ds' of a wear law that knows no closed form."""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tribopipe.base.arrays import Column
from tribopipe.physics.friction_path import FrictionPath, MeasuredFriction

_PANELS = 1000


def integral(factor: Callable[[Column], Column], distance: ArrayLike, friction: FrictionPath | None) -> Column:
    """Return ∫₀ˢ f ds' at sliding distances in m, by Simpson's rule and a cubic between knots.

    Knots are evenly spaced in √s, since wear begins fast, and at every sample of a measured friction. Before the start
    f keeps the value that it starts from. Draws of f, one a row, give as many rows.
    """
    s = np.asarray(distance, dtype=float)
    knots = _knots(float(np.max(s, initial=0.0)), friction)
    width = np.diff(knots)
    if not len(width):
        return np.asarray(s * factor(s))
    f, middle = factor(knots), factor((knots[1:] + knots[:-1]) / 2)
    panels = width * (f[..., :-1] + 4 * middle + f[..., 1:]) / 6
    up_to = np.concatenate([np.zeros((*panels.shape[:-1], 1)), np.cumsum(panels, axis=-1)], axis=-1)
    at = np.clip(np.searchsorted(knots, s, side="right") - 1, 0, len(width) - 1)
    share, rise = np.maximum(s - knots[at], 0.0) / width[at], _of(panels, at)
    # Hermite's cubic, whose slopes are f, is a straight line and what it has beyond that.
    left, right = _of(f, at) * width[at] - rise, _of(f, at + 1) * width[at] - rise
    beyond = share * (1 - share) * ((1 - share) * left - share * right)
    before_start = np.minimum(s, 0.0) * _of(f, np.zeros_like(at))
    return np.asarray(_of(up_to, at) + share * rise + beyond + before_start)


def _knots(end: float, friction: FrictionPath | None) -> Column:
    even = end * np.linspace(0.0, 1.0, _PANELS + 1) ** 2
    if isinstance(friction, MeasuredFriction):
        return np.unique(np.concatenate([even, np.clip(friction.distance, 0.0, end)]))
    return np.unique(even)


def _of(values: Column, places: NDArray[np.intp]) -> Column:
    """Return the values at places: of each row at its own, where there are several rows."""
    if values.ndim == 1:
        return np.asarray(values[places])
    wide = np.broadcast_to(places, (len(values), np.shape(places)[-1] if np.ndim(places) else 1))
    return np.take_along_axis(values, wide, axis=1)
