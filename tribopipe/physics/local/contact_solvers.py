"""What local wear asks of a contact solver, and the solvers: an active set, and conjugate gradients.

The active set is for elasticity that is a dense matrix, and exact up to rounding. Conjugate gradients are for
elasticity that is known as an operator on a grid.

Within the contact, the pressure that evens out the gap and carries the load minimises ½·Σp·u(p) + Σp·gap among all
that carry it. Conjugate gradients of the gap less its mean lead there (I. A. Polonsky and L. M. Keer, Wear 231, 1999).
Points that come to pull leave the contact at once. Points that overlap join it as soon as the gap within is more even
than they overlap. Each time the search restarts from there, so that no direction of another contact is followed.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol, Self

import numpy as np
from numpy.typing import NDArray

from tribopipe.base.arrays import Column
from tribopipe.base.errors import ContactError


@dataclass(frozen=True)
class Contact:
    """Two surfaces pressed on each other."""

    pressure: Column
    """Pressure at each point of the wearing surface, Pa; 0 outside the contact."""
    approach: float
    """Approach of remote points of the bodies, m."""


@dataclass(frozen=True)
class Extent:
    """Half-widths of a contact, m: both equal to the radius a of a round contact."""

    half_width: float
    """a, or a_x across the direction of rolling."""
    half_length: float
    """a, or a_z along it."""


class Surface(Protocol):
    """Wearing surface, pressed on a surface that does not wear.

    At each of its points p ≥ 0, g ≥ 0 and p·g = 0, where the gap is

        g = gap + worn + u(p) + amount·m(p) − approach,    Σ areas·p = F_N,

    with the elastic displacement u. m(p) is what a unit amount of wear removes: the pressure itself under a pin,
    where the amount is k_D·S in m³/N; its integral along the direction of rolling under a disc (Eq. 8), where the
    amount is k_D·N in m²/N. The term with m(p) makes wear implicit: what is worn in a step is worn by the
    pressure at its end.
    """

    @property
    def gap(self) -> Column:
        """Distance of each point, unworn and unloaded, from the plane that touches the surface, m."""
        ...

    @property
    def areas(self) -> Column:
        """What the pressure at each point counts for in the normal load, m²; symmetric parts counted in."""
        ...

    @property
    def places(self) -> tuple[Column, ...]:
        """Axes of the points, m: (radius,), or (across, along) of a grid."""
        ...

    def press(self, worn: Column, amount: float = 0.0, start: Contact | None = None) -> Contact:
        """Solve the contact, from the pressure of a similar one where given. Raises ``ContactError``."""
        ...

    def exposure(self, pressure: Column) -> Column:
        """Return m(p), shaped as the points."""
        ...

    def extent(self, contact: Contact) -> Extent:
        """Return how far the contact reaches."""
        ...

    def volume(self, worn: Column) -> float:
        """Return what is lost by wear: a pin's volume, m³, or the cross-section of a disc's track, m²."""
        ...

    def stable_amount(self, contact: Contact) -> float:
        """Return the amount of wear beyond which an explicit step makes a checkerboard of the pressure."""
        ...

    def roughness(self, contact: Contact) -> float:
        """Return how much the pressure alternates from point to point well inside the contact, over its mean."""
        ...

    def refreshed(self, worn: Column) -> Self:
        """Return the surface with the elasticity of the worn shape; itself where that is the same."""
        ...


_MOST_ROUNDS = 200
_TOUCHING = 1e-12
"""Share of the largest gap closed by the load, below which a gap counts as none."""


def solve_by_active_set(
    compliance: Column, gap: Column, areas: Column, load: float, touching: NDArray[np.bool_] | None = None
) -> Contact:
    """Return p ≥ 0 with gap + compliance·p − approach ≥ 0, zero where p > 0, and Σ areas·p = load.

    Points that pull leave the contact and points that overlap join it, until there are neither. ``touching`` is where
    the search begins; near the answer it takes two or three rounds. Raises ``ContactError`` where it does not end.
    """
    inside = gap <= gap.min() if touching is None else touching.copy()
    for _ in range(_MOST_ROUNDS):
        at = np.flatnonzero(inside)
        pressure, approach = touching_at(at, compliance, gap, areas, load)
        if np.any(pressure < 0):
            inside[at[pressure < 0]] = False
            continue
        left = gap + compliance[:, at] @ pressure - approach
        overlapping = ~inside & (left < -_TOUCHING * abs(approach))
        if not overlapping.any():
            found = np.zeros_like(gap)
            found[at] = pressure
            return Contact(found, approach)
        inside |= overlapping
    raise ContactError(
        f"local wear: found a contact area that still changes after {_MOST_ROUNDS} iterations; expected it to "
        "converge; check the profile, or use a coarser grid"
    )


def touching_at(
    at: NDArray[np.intp], compliance: Column, gap: Column, areas: Column, load: float
) -> tuple[Column, float]:
    """Return the pressure at these points, which may pull, were they all to touch and bear the load, and the approach.

    It is approach·x − y, where compliance·x = 1 and compliance·y = gap.
    """
    x, y = np.linalg.solve(compliance[np.ix_(at, at)], np.column_stack([np.ones(at.size), gap[at]])).T
    approach = (load + areas[at] @ y) / (areas[at] @ x)
    return approach * x - y, float(approach)


_MOST_STEPS = 3000
_CONVERGED = 1e-8
"""Unevenness of the gap in contact, and overlap next to it, in shares of the approach."""


def solve_by_conjugate_gradients(
    displacement: Callable[[Column], Column], gap: Column, cell: float, load: float, start: Column | None = None
) -> Contact:
    """Return p ≥ 0 with gap + displacement(p) − approach ≥ 0, zero where p > 0, and cell·Σp = load.

    ``displacement`` is linear, symmetric and positive definite; a gap may be infinite where there is nothing to touch.
    ``start`` is a pressure to begin from. Raises ``ContactError`` where the search does not end.
    """
    # Counted from the lowest point, a load that closes far less than the gap is not lost in rounding.
    lowest = float(gap.min())
    gap = gap - lowest
    pressure = _carrying(load / cell, np.isfinite(gap).astype(float) if start is None else start)
    inside, distance = pressure > 0, gap + displacement(pressure)
    direction, last = np.zeros_like(gap), np.inf
    for _ in range(_MOST_STEPS):
        approach = float(distance[inside].mean())
        apart = distance - approach
        uneven, overlap = float(np.abs(apart[inside]).max()), -float(apart.min(where=~inside, initial=0.0))
        if max(uneven, overlap) <= _CONVERGED * approach:
            return Contact(_carrying(load / cell, pressure), approach + lowest)
        if uneven < overlap:
            inside, last = inside | (apart < 0), np.inf
            continue
        residual = np.where(inside, apart, 0.0)
        square = float(np.vdot(residual, residual))
        direction, last = square / last * direction - residual, square
        displaced = displacement(direction)
        step = square / float(np.vdot(direction, displaced))
        pressure, distance = pressure + step * direction, distance + step * displaced
        if pressure.min() < 0:
            pressure = _carrying(load / cell, np.maximum(pressure, 0.0))
            inside, distance, last = pressure > 0, gap + displacement(pressure), np.inf
    raise ContactError(
        f"local wear: found a contact area that still changes after {_MOST_STEPS} iterations; expected it to "
        "converge; check the profile, or use a coarser grid"
    )


def _carrying(total: float, pressure: Column) -> Column:
    """Return pressure in proportion that adds up to a total."""
    return np.asarray(pressure * (total / pressure.sum()))
