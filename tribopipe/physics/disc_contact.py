"""Two discs under load: what the wear model is given, and the elastic contact it starts from.

Without wear the flat that the model takes the contact for has the height c* with c* = u(a*), where c is the height of
the crown cut off at half width a, and u falls as a^(-1/4) (tribopipe.physics.twin_disc has the equations).
"""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from tribopipe.base.arrays import Column
from tribopipe.base.errors import ContactError
from tribopipe.base.units import show
from tribopipe.physics.calculation_methods import DistanceConvention

_MOST_ITERATIONS = 60
_CONVERGED = 1e-13
_INPUTS = (
    ("load", "N", 0.0),
    ("crown radius", "m", 0.0),
    ("crowned disc's radius", "m", 0.0),
    ("cylindrical disc's radius", "m", 0.0),
    ("modulus", "Pa", 0.0),
    ("slip", "1", -1.0),
)
"""Name, unit and bound of each argument."""


@dataclass(frozen=True)
class Discs:
    """Two discs under load. Arguments in SI; arrays broadcast against each other and against what methods are given.

    Raises ``ContactError`` where the discs do not touch, or their elastic contact is as large as the crown.
    """

    normal_load: ArrayLike
    crown_radius: ArrayLike
    """r₁ₓ."""
    curved_radius: ArrayLike
    """r₁z."""
    flat_radius: ArrayLike
    """r₂z."""
    modulus: ArrayLike
    """E_c."""
    slip: ArrayLike
    """(v₂ − v₁)/v₁ of the unworn discs."""
    distance: DistanceConvention

    def __post_init__(self) -> None:
        for (name, unit, least), value in zip(_INPUTS, self.inputs, strict=True):
            if not np.all((value > least) & np.isfinite(value)):
                raise ContactError(
                    f"contact: found a {name} of {show(float(np.min(value)), None, unit)}; expected more than "
                    f"{least:g}, for discs in rolling contact; check load, radii, moduli and slip"
                )
        load, crown, *_ = self.inputs
        if not np.all(self.start_height < self.largest_height):
            raise ContactError(
                f"contact: found a load of {show(float(np.max(load)), None, 'N')} on a crown of radius "
                f"{show(float(np.min(crown)), None, 'm', 'mm')}, with an elastic contact as large as the crown; "
                "expected a contact much smaller than the crown; check load, crown radius and moduli"
            )

    @cached_property
    def inputs(self) -> tuple[Column, Column, Column, Column, Column, Column]:
        """Everything but the convention, as arrays."""
        given = (self.normal_load, self.crown_radius, self.curved_radius, self.flat_radius, self.modulus, self.slip)
        load, crown, curved, flat, modulus, slip = (np.asarray(value, dtype=float) for value in given)
        return load, crown, curved, flat, modulus, slip

    @property
    def largest_height(self) -> Column:
        """Height c beyond which nothing is left of the crown, or of a disc, m."""
        _, crown, curved, flat, _, _ = self.inputs
        return np.minimum(crown, np.minimum(curved, flat))

    @property
    def slip_counts(self) -> bool:
        """Whether wear grows with the slip, rather than with the length of the contact whatever the slip."""
        return self.distance not in ("contact-width", "line-load")

    @property
    def kappa(self) -> float:
        """κ of Eq. 12 and 15: π/4 as printed, 1 in *line-load*."""
        return 1.0 if self.distance == "line-load" else math.pi / 4

    @cached_property
    def rotation_ratio(self) -> Column:
        """ν = n₂/n₁."""
        _, _, curved, flat, _, slip = self.inputs
        return np.asarray((1 + slip) * curved / flat)

    @cached_property
    def start_equivalent(self) -> Column:
        """r_eq of the unworn discs."""
        _, _, curved, flat, _, _ = self.inputs
        return np.asarray(curved * flat / (curved + flat))

    @cached_property
    def start_height(self) -> Column:
        """c* = u(a*) without wear, by Newton's method on its logarithm; u falls as a^(-1/4)."""
        load, crown, _, _, modulus, _ = self.inputs
        line = 2 * load * self.start_equivalent / (np.pi * modulus)
        target = np.log(load / (2 * modulus * np.sqrt(self.kappa) * line**0.25))
        log_c = np.asarray((target - np.log(2 * crown) / 8) * 8 / 9)
        for _ in range(_MOST_ITERATIONS):
            c = np.minimum(np.exp(log_c), crown)
            step = (np.log(c) + np.log(c * (2 * crown - c)) / 8 - target) / (1 + (crown - c) / (2 * crown - c) / 4)
            log_c = np.log(c) - step
            if np.all((np.abs(step) <= _CONVERGED) | (log_c >= np.log(crown))):
                break
        return np.asarray(np.exp(log_c))

    def with_axis(self) -> "Discs":
        """Return the same discs with an axis more, for the nodes of an integral."""
        names = ("normal_load", "crown_radius", "curved_radius", "flat_radius", "modulus", "slip")
        same = object.__new__(Discs)  # nothing is to be checked, nor the elastic contact to be found, once more
        same.__dict__.update(zip(names, (value[..., None] for value in self.inputs), strict=True))
        same.__dict__.update(distance=self.distance, start_height=self.start_height[..., None])
        return same
