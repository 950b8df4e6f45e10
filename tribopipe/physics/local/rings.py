"""A round contact: the elastic half space under rings of uniform pressure, each pressed by an amount of its own.

A disc of radius a under uniform pressure p displaces the surface of a half space by

    u(r) = (4pa/πE_c)·E(r²/a²)  inside,    u(r) = (4pr/πE_c)·[E(a²/r²) − (1 − a²/r²)·K(a²/r²)]  outside

with the complete elliptic integrals K(m), E(m) (K. L. Johnson, Contact Mechanics, 1985, §3.4); a ring is the
difference of two discs. Rings grow in proportion to their radius, since the contact grows by orders of magnitude while
it wears and its edge may be anywhere.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.base.errors import ContactError
from tribopipe.physics.local.contact_solvers import Contact, Extent, solve_by_active_set
from tribopipe.physics.local.nodes import graded, roughness, vanishing

_FROM_EDGE = 3
_TO_START = 20
"""Rings in the radius of the contact before wear."""
_GROWTH = 0.025
"""Width of a ring further out, relative to its radius."""


def ring_edges(start: float, last: float) -> Column:
    """Return edges of rings out to ``last``, m, for a contact that begins with radius ``start`` and grows."""
    return graded(start / _TO_START, last, _GROWTH)


@dataclass(frozen=True)
class Rings:
    """The end of a pin, round about the axis of load, pressed on a flat disc."""

    normal_load: float
    modulus: float
    """E_c, Pa."""
    edges: Column
    """Radii between the rings, from 0 outwards, m."""
    gap: Column
    """Distance of each ring from the plane that touches the pin, m."""

    @cached_property
    def radius(self) -> Column:
        """Of the middle of each ring, m."""
        return (self.edges[1:] + self.edges[:-1]) / 2

    @property
    def places(self) -> tuple[Column, ...]:
        """Radius of each ring, m."""
        return (self.radius,)

    @cached_property
    def areas(self) -> Column:
        """Area of each ring, m²."""
        return np.pi * np.diff(self.edges**2)

    @cached_property
    def _compliance(self) -> Column:
        """Displacement of each ring's middle by unit pressure on each ring, m/Pa."""
        return np.diff(_disc_displacement(self.radius[:, None], self.edges), axis=1) / self.modulus

    def press(self, worn: Column, amount: float = 0.0, start: Contact | None = None) -> Contact:
        """Solve the contact. Raises ``ContactError``, also where a round tip touches to the last ring."""
        compliance = self._compliance + amount * np.eye(len(worn)) if amount else self._compliance
        touching = None if start is None else start.pressure > 0
        contact = solve_by_active_set(compliance, self.gap + worn, self.areas, self.normal_load, touching)
        if contact.pressure[-1] > 0 and self.gap[-1] > self.gap.min():
            raise ContactError(
                "local wear: found a contact area that reaches the last ring; expected a smaller contact area; "
                "simulate less wear, or use rings further out"
            )
        return contact

    def exposure(self, pressure: Column) -> Column:
        """Return the pressure: every point slides all the way."""
        return pressure

    def extent(self, contact: Contact) -> Extent:
        """Return the radius at which p², near the edge linear in r² as in Hertz's contact, is zero.

        The line goes through two rings a little further in, since the last ones are in contact in part; or, where a
        worn tip's pressure falls from nearly even to zero within a ring or two, through the last ones.
        """
        last = int(np.flatnonzero(contact.pressure)[-1])
        edge, width = self.edges[last + 1], self.edges[last + 1] - self.edges[last]
        for first in (last - _FROM_EDGE, last - 1):
            if first >= 0 and (zero := vanishing(self.radius, contact.pressure, first)) <= edge + width / 2:
                edge = min(max(zero, self.edges[last]), self.edges[-1])
                break
        return Extent(float(edge), float(edge))

    def volume(self, worn: Column) -> float:
        """Return the wear volume, m³."""
        return float(self.areas @ worn)

    def stable_amount(self, contact: Contact) -> float:
        """Return 4Δr/(πE_c) of the finest ring in contact, m³/N."""
        widths = np.diff(self.edges)[contact.pressure > 0]
        return float(4 * widths.min() / (np.pi * self.modulus))

    def roughness(self, contact: Contact) -> float:
        """Return the oscillation of pressure over the inner 80 % of the contact, relative to its mean."""
        return roughness(self.radius, contact.pressure, self.extent(contact).half_width)

    def refreshed(self, worn: Column) -> Self:  # noqa: ARG002
        """Return itself: a half space stays one."""
        return self


def _disc_displacement(radius: Column, disc: Column) -> Column:
    """Return E_c·u/p at each radius under discs of uniform pressure, m."""
    from scipy.special import ellipe, ellipk

    with np.errstate(divide="ignore", invalid="ignore"):
        inside = disc * ellipe(np.minimum((radius / disc) ** 2, 1.0))
        share = np.minimum((disc / radius) ** 2, 1.0)
        outside = radius * (ellipe(share) - (1 - share) * ellipk(np.minimum(share, 1 - 1e-16)))
    return np.where(disc > 0, np.where(radius < disc, inside, outside), 0.0) * 4 / np.pi
