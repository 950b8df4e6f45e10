"""Gaps between the heights of a profile across a wear track, and the heights that may be missing in them."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.evaluation.measurements.profile_levelling import Fit, Mask, Worn

_GAP = 3.0
"""Median distances between points beyond which a gap may be wide."""
_WIDE = 0.05
"""Share of the width of a groove up to which a gap hides next to nothing: of a parabola's area the third power."""
_FEWEST, _REACH = 5, 0.25
"""Points, and share of a gap's width, on either side of it from which the surface is continued into it."""


@dataclass(frozen=True)
class Filled:
    """A profile with points in its gaps."""

    x: Column
    z: Column
    """m."""
    off: Column
    """By how much the heights in gaps may be wrong, m; 0 where measured."""
    measured: Mask
    gaps: Column
    """Positions of both ends of each gap, m; two columns."""

    @property
    def widest(self) -> float:
        """Width of the widest gap, m."""
        return float(np.max(np.diff(self.gaps)))

    def within(self, place: float) -> float:
        """Return the standard deviation of a place that may be anywhere in the gap it is in, m; 0 if in none."""
        first, last = self.gaps.T
        return float(np.sum((last - first)[(first <= place) & (place <= last)])) / math.sqrt(12)

    def spread(self, mask: Mask) -> Mask:
        """Return a mask of the measured points as one of all points, in which the others are masked as well."""
        spread = ~self.measured
        spread[self.measured] = mask
        return spread


def has_gaps(x: Column) -> bool:
    """Return whether some positions are much farther apart than most."""
    steps = np.diff(x)
    return bool(np.max(steps) > _GAP * np.median(steps))


def filled(x: Column, z: Column, fit: Fit, worn: Worn) -> Filled | None:
    """Fill the wide gaps in a track by cubic parabolas through both sides; None where there is no such gap."""
    steps = np.diff(x)
    median, width = float(np.median(steps)), float(x[worn.groove.stop - 1] - x[worn.groove.start])
    wide = np.flatnonzero(steps > max(_GAP * median, _WIDE * width))
    before = wide[(wide >= worn.left.start) & (wide < worn.right.stop - 1)]
    if not len(before):
        return None
    step = max(median, width / len(x))
    gaps = [_Gap.after(x, fit.unworn.height(x) - z, place, step) for place in before]
    at = np.repeat(before + 1, [len(gap.x) for gap in gaps])
    added, lost, off = (np.concatenate(parts) for parts in zip(*gaps, strict=True))
    return Filled(
        np.insert(x, at, added),
        np.insert(z, at, fit.unworn.height(added) - lost),
        np.insert(np.zeros(len(x)), at, off),
        np.insert(np.ones(len(x), bool), at, False),
        np.column_stack([x[before], x[before + 1]]),
    )


class _Gap(NamedTuple):
    """Points in one gap."""

    x: Column
    lost: Column
    """Height lost by a smooth continuation of both sides, m."""
    off: Column

    @classmethod
    def after(cls, x: Column, lost: Column, place: int, step: float) -> "_Gap":
        """Fill the gap after a point.

        A surface that rises or falls throughout the gap is within 2 standard uncertainties of the straight line.
        """
        ends = slice(place, place + 2)
        width = float(x[place + 1] - x[place])
        points = np.linspace(x[place], x[place + 1], math.ceil(width / step) + 1)[1:-1]
        continued = _continued(x, lost, place, width, points)
        across = np.interp(points, x[ends], lost[ends])
        nearer = np.where(points - x[place] < width / 2, *lost[ends])
        return cls(points, continued, np.abs(continued - across) + np.abs(across - nearer))


def _continued(x: Column, lost: Column, place: int, width: float, points: Column) -> Column:
    """Return heights in the gap after a point, by least squares through the points on either side of it."""
    near = (x >= x[place] - _REACH * width) & (x <= x[place + 1] + _REACH * width)
    near[max(place + 1 - _FEWEST, 0) : place + 1 + _FEWEST] = True
    return np.asarray(np.polynomial.Polynomial.fit(x[near], lost[near], 3)(points))
