"""Nodes under the pressure of the unworn contact, as an example of what drives a subroutine."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tribopipe.base.arrays import Column

_STEPS = 10
_REACH = 1.2
"""How far nodes reach, over the contact's radius."""


@dataclass(frozen=True)
class UnwornContact:
    """The contact that wear starts from: Hertz's, or that of a flat end under uniform pressure."""

    half_width: float
    """m; across the direction of rolling."""
    half_length: float
    """m; along it."""
    peak_pressure: float
    """Pa."""
    even: bool = False

    def pressure(self, across: Column, along: Column) -> Column:
        """Return the pressure at places from the middle, m, in Pa."""
        inside = 1 - (across / self.half_width) ** 2 - (along / self.half_length) ** 2
        profile = np.sign(np.maximum(inside, 0.0)) if self.even else np.sqrt(np.maximum(inside, 0.0))
        return np.asarray(self.peak_pressure * profile)


@dataclass(frozen=True)
class Example:
    """Nodes 1, 2, … of a contact surface; the first is in the middle, or on the streamline through it."""

    pressure: Column
    """Pa."""
    streamline: NDArray[np.int64]
    """Of each node: 1, 2, …; each a streamline of its own under a pin."""
    length: Column
    """Of the streamline that each node stands for, m."""


def _across(start: UnwornContact) -> Column:
    return np.linspace(0.0, _REACH, 2 * _STEPS + 1) * start.half_width


def along_a_radius(start: UnwornContact) -> Example:
    """Return nodes along a radius of a round contact."""
    radius = _across(start)
    numbers = np.arange(1, radius.size + 1)
    return Example(start.pressure(radius, np.zeros_like(radius)), numbers, np.zeros_like(radius))


def on_streamlines(start: UnwornContact) -> Example:
    """Return nodes on streamlines across half of the contact of two discs."""
    across = _across(start)[::4]
    along = np.linspace(-_REACH, _REACH, 2 * _STEPS + 1) * start.half_length
    x, z = np.meshgrid(across, along, indexing="ij")
    numbers = np.repeat(np.arange(1, across.size + 1), along.size)
    return Example(start.pressure(x, z).ravel(), numbers, np.full(x.size, along[1] - along[0]))
