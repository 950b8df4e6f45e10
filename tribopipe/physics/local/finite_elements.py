"""Contact by finite elements, whose mesh moves as the surface wears (paper, Section 3.2).

A pin's end, round about the axis of load, and a quarter of a crowned disc (paper, Fig. 7b) are one deformable body
each, on a rigid flat.

Young's modulus E_c(1 − ν²) is such that the surface is as compliant as those of both bodies together. Far from where
the contact may reach, a pin goes on as a half space does, flat. The disc's curvature is that of both discs relative to
each other, and planes of symmetry cut it across and along the direction of rolling. As it turns, a streamline, all
along which wear is the same, wears by m = ∫p dz for each unit of k_D·N (Eq. 8 and 9).
"""

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Self

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.base.errors import ContactError
from tribopipe.physics.geometry import cap_height
from tribopipe.physics.hertz import hertz_ellipse
from tribopipe.physics.local.contact_solvers import Contact, Extent, solve_by_active_set
from tribopipe.physics.local.elastic_body import Block, block
from tribopipe.physics.local.nodes import continued, edge, graded, roughness, tributary

_PIN_REACH = 100.0
"""Size of the body in that of the surface that may touch."""
_PIN_GROWTH = 1.4
"""Of spacings beyond that surface."""
_PIN_DEPTH_SHARE = 0.15
"""Thickness of the layers far from the surface over their depth."""


@dataclass(frozen=True)
class PinBody:
    """A pin's end by finite elements; a ``Surface`` whose points are the nodes that may touch."""

    normal_load: float
    radius: Column
    """Radius of each node, increasing from 0, m."""
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
        contact = solve_by_active_set(compliance, self.gap + worn, self.areas, self.normal_load, touching)
        if contact.pressure[-1] > 0 and self.gap[-1] > 0:
            raise ContactError(
                "local wear: found a contact area that reaches the last contact node; expected a smaller contact area; "
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
        """Return the oscillation of pressure over the inner 80 % of the contact, relative to its mean."""
        return roughness(self.radius, contact.pressure, self.extent(contact).half_width)

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
    nodes = continued(radius, _PIN_REACH * radius[-1], _PIN_GROWTH)
    height = np.append(gap, np.full(nodes.size - gap.size, gap[-1]))
    depth = graded(radius[1], nodes[-1], _PIN_DEPTH_SHARE)
    body = block([nodes], depth, height, modulus * (1 - poisson_ratio**2), poisson_ratio)
    return PinBody(normal_load, radius, gap, body, body)


CELLS = (12, 6)
"""Cells from the middle of a disc's track to its edge, and from the middle of the contact to its end.

With these, depths are within 0.2 % for the paper's discs, whose compliance takes some seconds to compute.
"""
_MARGIN = 1.14
"""Half of the surface that may touch over that of the largest contact."""
_NEAR, _FAR = 10.0, 100.0
"""How far the body reaches in finer and in coarser cells, in half widths of the surface that may touch."""
_GROWTH, _FAR_GROWTH = 1.5, 2.5
"""Of spacings beyond that surface."""
_DEPTH_SHARE = 0.35
"""Thickness of the finer layers over their depth."""


@dataclass(frozen=True)
class QuarterDisc:
    """A quarter of a crowned disc by finite elements; a ``Surface`` whose points are a grid across and along."""

    normal_load: float
    """On the whole disc, N."""
    across: Column
    """Places of nodes that may touch, across the direction of rolling, from 0 outwards, m."""
    along: Column
    """And along it."""
    gap: Column
    """Of each node of the unworn disc, across and along, m."""
    unworn: Block
    body: Block
    """With its mesh moved as the surface has worn."""

    @property
    def places(self) -> tuple[Column, ...]:
        """Places across and along, m."""
        return (self.across, self.along)

    @cached_property
    def areas(self) -> Column:
        """What a node's pressure counts for in all four quarters, m²."""
        return 4 * np.outer(self._widths, self._lengths)

    @cached_property
    def compliance(self) -> Column:
        """Displacement of each node by unit pressure at each node, of the grid's rows in sequence, m/Pa."""
        nodes = self.body.surface[: self.across.size, : self.along.size]
        return self.body.compliance(nodes) * (self.areas.ravel() / 4)

    def press(self, worn: Column, amount: float = 0.0, start: Contact | None = None) -> Contact:
        """Solve the contact. Raises ``ContactError``, also where it reaches the last nodes that may touch."""
        touching = None if start is None else start.pressure.ravel() > 0
        streamline = np.tile(2 * self._lengths, (self.along.size, 1))
        compliance = self.compliance + amount * np.kron(np.eye(self.across.size), streamline)
        found = solve_by_active_set(
            compliance, (self.gap + worn).ravel(), self.areas.ravel(), self.normal_load, touching
        )
        pressure = found.pressure.reshape(self.gap.shape)
        if np.any(pressure[-1] > 0) or np.any(pressure[:, -1] > 0):
            raise ContactError(
                "local wear: found a contact area that reaches the last contact nodes; expected a smaller contact "
                "area; simulate less wear, or use a wider surface"
            )
        return Contact(pressure, found.approach)

    def exposure(self, pressure: Column) -> Column:
        """Return ∫p dz over both halves of each streamline, N/m."""
        return np.broadcast_to(2 * (pressure @ self._lengths)[:, None], pressure.shape)

    def extent(self, contact: Contact) -> Extent:
        """Return where the pressure ends on the planes of symmetry."""
        return Extent(edge(self.across, contact.pressure[:, 0]), edge(self.along, contact.pressure[0]))

    def volume(self, worn: Column) -> float:
        """Return the cross-section of the track, m²."""
        return float(2 * self._widths @ worn[:, 0])

    def stable_amount(self, contact: Contact) -> float:
        """Return 2/λ, m²/N, of the fastest wave of wear: explicit steps δq multiply it by 1 − δq·λ.

        Wear w of the streamlines in contact changes a quarter's forces by −C⁻¹·S·w, C the nodes' compliance to forces
        and S what spreads streamlines over nodes, and so m by −(2/widths)·Sᵀ·C⁻¹·S·w, whose largest eigenvalue is λ.
        """
        at = np.flatnonzero(contact.pressure)
        wearing = contact.pressure.any(axis=1)
        spread = np.repeat(np.eye(self.across.size), self.along.size, axis=0)[np.ix_(at, wearing)]
        spread /= np.sqrt(self._widths[wearing] / 2)
        to_forces = self.compliance[np.ix_(at, at)] / (self.areas.ravel()[at] / 4)
        rates = spread.T @ np.linalg.solve(to_forces, spread)
        return 2 / float(np.linalg.eigvalsh((rates + rates.T) / 2)[-1])

    def roughness(self, contact: Contact) -> float:
        """Return the oscillation of ∫p dz over the inner 80 % of the track, relative to its mean."""
        line_load = self.exposure(contact.pressure)[:, 0]
        return roughness(self.across, line_load, edge(self.across, line_load))

    def refreshed(self, worn: Column) -> Self:
        """Return the disc with its mesh moved as the surface has worn. Raises ``ContactError``."""
        by = np.zeros(self.body.surface.shape)
        by[: self.across.size] = worn[:, :1]
        return replace(self, body=self.unworn.moved(by))

    @cached_property
    def _widths(self) -> Column:
        return tributary(self.across)

    @cached_property
    def _lengths(self) -> Column:
        return tributary(self.along)


def quarter_disc(
    *,
    normal_load: float,
    modulus: float,
    poisson_ratio: float,
    crown_radius: float,
    curved_radius: float,
    flat_radius: float,
    amount: float,
    cells: tuple[int, int] = CELLS,
) -> QuarterDisc:
    """Build two discs for wear up to an amount k_D·N, m²/N; N, Pa, m. ``modulus`` is E_c.

    As ``grids.disc_track`` does: across the rolling, a parabolic crown that has lost q·F_N of its section touches over
    a half width of a_x³ = 3/2·r₁ₓ·q·F_N. Raises ``ContactError``, also where the package scikit-fem is missing.
    """
    equivalent = curved_radius * flat_radius / (curved_radius + flat_radius)
    first = hertz_ellipse(normal_load=normal_load, radius_x=crown_radius, radius_z=equivalent, modulus=modulus)
    widest = math.cbrt(first.half_width**3 + 1.5 * crown_radius * amount * normal_load)
    across = np.linspace(0.0, _MARGIN * widest, cells[0] + 1)
    along = np.linspace(0.0, _MARGIN * first.half_length, cells[1] + 1)
    crown = cap_height(scar_radius=across, sphere_radius=crown_radius)
    curved, flat = (cap_height(scar_radius=along, sphere_radius=radius) for radius in (curved_radius, flat_radius))
    gap = crown[:, None] + curved + flat
    body = _body(across, along, gap, modulus * (1 - poisson_ratio**2), poisson_ratio)
    return QuarterDisc(normal_load, across, along, gap, body, body)


def _body(across: Column, along: Column, gap: Column, modulus: float, poisson_ratio: float) -> Block:
    """Return the body under the nodes that may touch and flat ones beyond, of Young's modulus, Pa."""
    near, far = _NEAR * across[-1], _FAR * across[-1]
    layers = graded(min(across[1], along[1]), near, _DEPTH_SHARE)
    axes = [continued(continued(nodes, near, _GROWTH), far, _FAR_GROWTH) for nodes in (across, along)]
    beyond = [(0, nodes.size - some) for nodes, some in zip(axes, gap.shape, strict=True)]
    height = np.pad(gap, beyond, mode="edge")
    return block(axes, continued(layers, far, _FAR_GROWTH), height, modulus, poisson_ratio)
