"""Depth of a pin against worn volume by each wear engine: the GIWM's uniform pressure, its shape alone, or local wear.

Local wear of a sphere is the GIWM's and an excess that is one curve for all spheres (tribopipe.physics.local.excess):

    h(v) = h_GIWM(v) + δ₀·ψ(v/(π·a₀²·δ₀)),    a₀ = Hertz's radius,    δ₀ = a₀²/R

so that thousands of draws of load, radius and moduli cost little more than by the GIWM. h is the depth of the middle,
the deepest point. A flat pin follows the GIWM by either engine: its pressure is uneven only while it first wears, by
about as much as its elastic approach, which leaves its middle 0.10·F_N/(E_c·a) short of the GIWM's depth, and no more.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from tribopipe.base.arrays import Column
from tribopipe.physics.hertz import hertz_radius
from tribopipe.physics.local.excess import excess
from tribopipe.physics.pin_on_disc import SphericalPin, WornState, no_published_scheme

_MOST_ITERATIONS = 60
_CONVERGED = 1e-9
"""Relative Newton step after which the next one, by quadratic convergence, is below the last digit."""
_SHALLOW = 1e-9
"""Depth over δ₀ that stands in for none, where a logarithm is taken."""


@dataclass(frozen=True)
class LocalSphere:
    """A whole sphere, worn against the disc by the pressure at each of its points."""

    even: SphericalPin
    """The same sphere by the GIWM."""

    @cached_property
    def _hertz(self) -> tuple[Column, Column]:
        """δ₀, m, and π·a₀², m²."""
        pin = self.even
        radius = hertz_radius(normal_load=pin.normal_load, pin_radius=pin.radius, modulus=pin.modulus)
        return radius**2 / np.asarray(pin.radius), np.pi * radius**2

    @property
    def most_volume(self) -> Column:
        """Volume, m³, at which the contact reaches the full radius of the sphere."""
        return self.even.most_volume

    def worn(self, volume: ArrayLike) -> WornState:
        """Return the pin after wearing off a volume, m³. Raises ``ContactError`` where it holds no such volume."""
        v, (depth, area) = np.asarray(volume, dtype=float), self._hertz
        even, more = self.even.worn(v), excess(v / (area * depth))
        return WornState(
            depth=even.depth + depth * more.depth,
            radius=even.radius * more.radius_ratio,
            area=1 / (1 / even.area + more.rate / area),
        )

    def volume(self, depth: ArrayLike) -> Column:
        """Return the volume, m³, lost by wear at a depth, m, by Newton on ln h against ln v, from the GIWM's.

        Raises ``ContactError`` for a depth below zero or past the tip.
        """
        unworn = np.asarray(depth) == 0
        wanted = np.where(unworn, _SHALLOW * self._hertz[0], depth)
        v = most = self.even.volume(wanted)
        for _ in range(_MOST_ITERATIONS):
            state = self.worn(v)
            step = np.log(state.depth / wanted) * state.depth * state.area / v
            v = np.minimum(v * np.exp(-step), most)
            if np.all(np.abs(step) <= _CONVERGED):
                break
        return np.where(unworn, 0.0, v)

    def published_depth(self, volume_steps: ArrayLike) -> Column:
        """Refuse: the paper's Euler steps are the GIWM's."""
        raise no_published_scheme(volume_steps, "local wear")
