"""Local wear along a run, with the Global Incremental Wear Model."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

from tribopipe.base.arrays import Column
from tribopipe.physics.local.course import LocalWear
from tribopipe.results.local_wear import LocalWearResult


class GlobalWear(NamedTuple):
    """The Global Incremental Wear Model along the same course."""

    depth: Column
    """m."""
    pressure: Column
    """Mean pressure, Pa."""
    half_width: Column
    """a or a_x, m."""
    half_length: Column
    """a or a_z, m."""


@dataclass(frozen=True)
class LocalCurves:
    """Local wear along sliding distance or rotations, and the GIWM next to it."""

    result: LocalWearResult
    along: Column
    """Sliding distance, m, or rotations of the crowned disc; the first is 0."""
    course: LocalWear
    gap: Column
    """Distance of each point of the unworn surface from the plane that touches it, m."""
    mean_pressure: Column
    """Normal load over the area in contact, Pa."""
    giwm: Mapping[str, GlobalWear]
    """As ``giwm``; of discs that conserves volume, and stands next to it ``giwm_as_printed``."""

    @property
    def discs(self) -> bool:
        """Whether two discs wear, rather than a pin."""
        return self.result.flat_disc_wear_coefficient is not None

    @property
    def middle_pressure(self) -> Column:
        """Contact pressure in the middle, Pa."""
        return self.course.middle_pressure
