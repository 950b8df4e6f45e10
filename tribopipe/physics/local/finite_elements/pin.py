"""A pin's end as one deformable body, round about the axis of load, on a rigid flat.

Its Young's modulus E_c(1 − ν²) is such that its surface is as compliant as both bodies' together. Far from where the
contact may reach it goes on as a half space does, flat.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Self

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.base.errors import ContactError
from tribopipe.physics.local.active_set import pressed
from tribopipe.physics.local.finite_elements.along import edge, roughness
from tribopipe.physics.local.finite_elements.block import Block, block
from tribopipe.physics.local.finite_elements.grading import continued, tributary
from tribopipe.physics.local.grading import graded
from tribopipe.physics.local.surface import Contact, Extent

_REACH = 100.0
"""Size of the body in that of the surface that may touch."""
_GROWTH = 1.4
"""Of spacings beyond that surface."""
_DEPTH_SHARE = 0.15
"""Thickness of the layers far from the surface over their depth."""


@dataclass(frozen=True)
class PinBody:
    """A pin's end by finite elements; a ``Surface`` whose points are the nodes that may touch."""

    normal_load: float
    radius: Column
    """Of each node, from 0 outwards, m."""
    gap: Column
    """Of each node of the unworn pin, m."""
    unworn: Block
    body: Block
    """With its mesh moved as the surface has worn."""

    @property
    def places(self) -> tuple[Column, ...]:
        """Radius of each node, m."""
        return (self.radius,)

    @cached_property
    def areas(self) -> Column:
        """What a node's pressure counts for: the integral of its shape function, m²."""
        return tributary(self.radius, radial=True)

    @cached_property
    def compliance(self) -> Column:
        """Displacement of each node by unit pressure at each node, m/Pa."""
        return self.body.compliance(self.body.surface[: self.radius.size]) * self.areas

    def press(self, worn: Column, amount: float = 0.0, start: Contact | None = None) -> Contact:
        """Solve the contact. Raises ``ContactError``, also where it reaches the last node and the end is not flat."""
        touching = None if start is None else start.pressure > 0
        compliance = self.compliance + amount * np.eye(worn.size)
        contact = pressed(compliance, self.gap + worn, self.areas, self.normal_load, touching)
        if contact.pressure[-1] > 0 and self.gap[-1] > 0:
            raise ContactError(
                "local wear: found a contact that reaches the last node that may touch; expected it to end before; "
                "simulate less wear, or use nodes further out"
            )
        return contact

    def exposure(self, pressure: Column) -> Column:
        """Return the pressure: every point slides all the way."""
        return pressure

    def extent(self, contact: Contact) -> Extent:
        """Return the radius where the pressure ends."""
        radius = edge(self.radius, contact.pressure)
        return Extent(radius, radius)

    def volume(self, worn: Column) -> float:
        """Return the wear volume, m³."""
        return float(self.areas @ worn)

    def stable_amount(self, contact: Contact) -> float:
        """Return twice the smallest eigenvalue of the compliance in contact, m/Pa.

        Explicit steps δq multiply a wave of wear by 1 − δq/λ, with λ its eigenvalue.
        """
        at = np.flatnonzero(contact.pressure)
        root = np.sqrt(self.areas[at])
        symmetric = self.compliance[np.ix_(at, at)] / root * root[:, None]
        return 2 * float(np.linalg.eigvalsh((symmetric + symmetric.T) / 2)[0])

    def roughness(self, contact: Contact) -> float:
        """Return the alternation of pressure over the inner 80 % of the contact, relative to its mean."""
        return roughness(self.radius, contact.pressure)

    def refreshed(self, worn: Column) -> Self:
        """Return the pin with its mesh moved as the surface has worn. Raises ``ContactError``."""
        by = np.zeros(self.unworn.surface.size)
        by[: worn.size] = worn
        return replace(self, body=self.unworn.moved(by))


def pin_body(*, normal_load: float, modulus: float, poisson_ratio: float, radius: Column, gap: Column) -> PinBody:
    """Return a pin whose nodes at these radii, m, 0 first, may touch; gap is their distance from the flat, m.

    ``modulus`` is E_c, Pa. Nodes should be 20 or more to the contact's radius wherever its edge may be, as those of
    ``grading.graded(a₀/20, last, 0.04)`` are. Raises ``ContactError`` where the package scikit-fem is missing.
    """
    nodes = continued(radius, _REACH * radius[-1], _GROWTH)
    height = np.append(gap, np.full(nodes.size - gap.size, gap[-1]))
    depth = graded(radius[1], nodes[-1], _DEPTH_SHARE)
    body = block([nodes], depth, height, modulus * (1 - poisson_ratio**2), poisson_ratio)
    return PinBody(normal_load, radius, gap, body, body)
