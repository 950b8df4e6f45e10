"""Nodes under the pressure of the unworn contact, as an example of what drives a subroutine."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tribopipe.base.arrays import Column
from tribopipe.extras.abaqus.case import UnwornContact, WearCase

_STEPS = 10
_REACH = 1.2
"""How far nodes reach, over the contact's radius."""


@dataclass(frozen=True)
class Example:
    """Nodes 1, 2, … of a contact surface; the first is in the middle, or on the streamline through it."""

    pressure: Column
    """Pa."""
    streamline: NDArray[np.int64]
    """Of each node: 1, 2, …; each a streamline of its own under a pin."""
    length: Column
    """Of the streamline that each node stands for, m."""

    def dose(self, case: WearCase) -> float:
        """Return what the first node wears per time over k_D: p·v, or n·∫p dl, Pa m/s."""
        if not case.rolls:
            return float(self.pressure[0]) * case.speed
        first = self.streamline == 1
        return float(self.pressure[first] @ self.length[first]) * case.turns


def example(case: WearCase) -> Example:
    """Return nodes along a radius of a pin's contact, or on streamlines across half of two discs'."""
    across = np.linspace(0.0, _REACH, 2 * _STEPS + 1) * case.start.half_width
    return _streamlines(case.start, across[::4]) if case.rolls else _radius(case.start, across)


def _radius(start: UnwornContact, radius: Column) -> Example:
    numbers = np.arange(1, radius.size + 1)
    return Example(start.pressure(radius, np.zeros_like(radius)), numbers, np.zeros_like(radius))


def _streamlines(start: UnwornContact, across: Column) -> Example:
    along = np.linspace(-_REACH, _REACH, 2 * _STEPS + 1) * start.half_length
    x, z = np.meshgrid(across, along, indexing="ij")
    numbers = np.repeat(np.arange(1, across.size + 1), along.size)
    return Example(start.pressure(x, z).ravel(), numbers, np.full(x.size, along[1] - along[0]))
