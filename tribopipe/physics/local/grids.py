"""Surfaces on a regular grid of a half space: pins of any shape, and the track of a disc that rolls and slips.

Under a disc, what passes along a streamline is worn by all the pressure on it, and by the same anywhere on it (Eq. 8,
9): a slip rotation takes k_D·∫p dz off at each place across the track.
"""

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from tribopipe.base.arrays import Column
from tribopipe.base.errors import ContactError
from tribopipe.base.units import show
from tribopipe.physics.geometry import cap_height
from tribopipe.physics.hertz import hertz_ellipse
from tribopipe.physics.local.contact_solvers import Contact, Extent, solve_by_conjugate_gradients
from tribopipe.physics.local.half_space import HalfSpace, MirroredHalfSpace

PIN_CELLS = 128
"""Points across a pin's grid, and along it."""
DISC_CELLS = (64, 32)
"""Points from the middle of a disc's track to its edge, and from the middle of the contact to its end."""
_MARGIN_ACROSS, _MARGIN_ALONG = 1.1, 1.05
"""Half of the grid, within its rim, over that of the largest contact."""
_INNER = 0.8
"""Share of the contact's extent within which the pressure should be smooth."""


@dataclass(frozen=True)
class _Grid(ABC):
    """What wears at the points of a regular grid."""

    normal_load: float
    half_space: HalfSpace
    gap: Column
    """Distance of each point from the plane that touches the surface, m; infinite where there is nothing to touch."""

    @property
    def places(self) -> tuple[Column, ...]:
        """Positions across and along, m."""
        return self.half_space.places

    @property
    def areas(self) -> Column:
        """The same everywhere, m²."""
        return np.full(self.half_space.shape, self.half_space.cell)

    def press(self, worn: Column, amount: float = 0.0, start: Contact | None = None) -> Contact:
        """Solve the contact. Raises ``ContactError``, also where it reaches the end of the grid."""
        spectrum = self.half_space.compliance + amount * self._exposed
        contact = solve_by_conjugate_gradients(
            lambda pressure: self.half_space.convolved(pressure, spectrum),
            self.gap + worn,
            self.half_space.cell,
            self.normal_load,
            None if start is None else start.pressure,
        )
        if np.any(contact.pressure[self.half_space.rim] > 0):
            raise ContactError(
                "local wear: found a contact area that reaches the edge of the grid; expected a smaller contact area; "
                "simulate less wear, or use a wider grid"
            )
        return contact

    def refreshed(self, worn: Column) -> Self:  # noqa: ARG002
        """Return itself: a half space stays one."""
        return self

    @property
    @abstractmethod
    def _exposed(self) -> Column | float:
        """Spectrum of m(p)."""

    def _ends(self, pressure: Column) -> list[tuple[float, float]]:
        """Return where the contact begins and ends across, and where along, m."""
        peaks = pressure.max(axis=1), pressure.max(axis=0)
        along_axes = zip(self.places, self.half_space.spacing, peaks, strict=True)
        return [(-_end(-places[::-1], step, peak[::-1]), _end(places, step, peak)) for places, step, peak in along_axes]


@dataclass(frozen=True)
class PinGrid(_Grid):
    """The end of a pin, of whatever shape, pressed on a flat disc."""

    def exposure(self, pressure: Column) -> Column:
        """Return the pressure: every point slides all the way."""
        return pressure

    def extent(self, contact: Contact) -> Extent:
        """Return half of how far the contact reaches across and along."""
        (left, right), (back, front) = self._ends(contact.pressure)
        return Extent((right - left) / 2, (front - back) / 2)

    def volume(self, worn: Column) -> float:
        """Return the wear volume, m³."""
        return float(self.half_space.cell * worn.sum())

    def stable_amount(self, contact: Contact) -> float:  # noqa: ARG002
        """Return twice the compliance under a checkerboard of pressure, m²/N.

        On squares that is 1.29 times the 2√2·Δx/(πE_c) of a wave of that length, since pressure is even on each.
        """
        return float(2 * self.half_space.compliance[-1, -1])

    def roughness(self, contact: Contact) -> float:
        """Return the oscillation of pressure in the inner part of the contact, relative to its mean."""
        across, along = (
            (2 * places - begin - end) / (end - begin)
            for places, (begin, end) in zip(self.places, self._ends(contact.pressure), strict=True)
        )
        inner = np.hypot(across[:, None], along) < _INNER
        return max(oscillation(contact.pressure, inner), oscillation(contact.pressure.T, inner.T))

    @property
    def _exposed(self) -> float:
        return 1.0


@dataclass(frozen=True)
class DiscTrack(_Grid):
    """A quarter of the contact of a crowned disc that wears with a flat one that does not, x across the rolling."""

    half_space: MirroredHalfSpace

    def exposure(self, pressure: Column) -> Column:
        """Return ∫p dz along the streamline of each point, N/m."""
        return np.broadcast_to(self._line_load(pressure)[:, None], pressure.shape)

    def extent(self, contact: Contact) -> Extent:
        """Return a_x and a_z, each through the middle of the contact."""
        across, along = self.places
        width, length = self.half_space.spacing
        return Extent(_end(across, width, contact.pressure[:, 0]), _end(along, length, contact.pressure[0]))

    def volume(self, worn: Column) -> float:
        """Return the cross-section of the track, m²."""
        return float(2 * self.half_space.spacing[0] * worn[:, 0].sum())

    def stable_amount(self, contact: Contact) -> float:
        """Return twice the compliance, over the contact's length, under pressure in stripes, m²/N.

        Stripes alternate from streamline to streamline. It is 1.16 times the 4Δx/(πE_c·2a_z) of a wave of that length,
        since pressure is even on each, and times the metre in the amount of wear.
        """
        return float(self.half_space.compliance[-1, 0] / self.extent(contact).half_length)

    def roughness(self, contact: Contact) -> float:
        """Return the oscillation of ∫p dz in the inner part of the track, relative to its mean."""
        across, _ = self.places
        return oscillation(self._line_load(contact.pressure), across < _INNER * self.extent(contact).half_width)

    @property
    def _exposed(self) -> Column:
        return self.half_space.streamlines

    def _line_load(self, pressure: Column) -> Column:
        return np.asarray(2 * self.half_space.spacing[1] * pressure.sum(axis=1))


def disc_track(
    *,
    normal_load: float,
    modulus: float,
    crown_radius: float,
    curved_radius: float,
    flat_radius: float,
    amount: float,
    cells: tuple[int, int] = DISC_CELLS,
) -> DiscTrack:
    """Build two discs on a grid for wear up to an amount k_D·N, m²/N; N, Pa, m. Raises ``ContactError``.

    Across the rolling, the contact grows from Hertz's a_x to the width of a crown that has lost q·F_N of its section,
    which for a parabola is a_x³ = 3/2·r₁ₓ·q·F_N. Along it, the contact is longest at first.
    """
    equivalent = curved_radius * flat_radius / (curved_radius + flat_radius)
    first = hertz_ellipse(normal_load=normal_load, radius_x=crown_radius, radius_z=equivalent, modulus=modulus)
    widest = _MARGIN_ACROSS * math.cbrt(first.half_width**3 + 1.5 * crown_radius * amount * normal_load)
    if widest >= crown_radius:
        raise ContactError(
            f"local wear: found a final track width of {show(2 * widest, None, 'm', 'mm')} on a crown of radius "
            f"{show(crown_radius, None, 'm', 'mm')}; expected a narrower track; use fewer rotations, or check load, "
            "wear coefficient and radii"
        )
    spacing = (widest / (cells[0] - 1), _MARGIN_ALONG * first.half_length / (cells[1] - 1))
    half_space = MirroredHalfSpace(modulus, spacing, cells)
    across, along = half_space.places
    crown = cap_height(scar_radius=across, sphere_radius=crown_radius)
    curved, flat = (cap_height(scar_radius=along, sphere_radius=radius) for radius in (curved_radius, flat_radius))
    return DiscTrack(normal_load, half_space, crown[:, None] + curved + flat)


def round_pin(
    *,
    normal_load: float,
    modulus: float,
    tip: Callable[[Column], Column],
    reach: float,
    cells: int = PIN_CELLS,
) -> PinGrid:
    """Build a pin on a square grid whose contact may reach so far from its axis; N, Pa, m.

    ``tip`` returns how far the pin is behind its end at each radius, m; infinite outside the pin.
    """
    spacing = 2 * reach / (cells - 2)
    half_space = HalfSpace(modulus, (spacing, spacing), (cells, cells))
    across, along = half_space.places
    return PinGrid(normal_load, half_space, tip(np.hypot(across[:, None], along)))


def _end(places: Column, step: float, pressure: Column) -> float:
    """Return where p² is zero, which falls linearly towards the end of a contact of smooth surfaces.

    Where it does not fall to zero within a rectangle, as at the edge of a flat pin, that is the last one's end.
    """
    last = int(np.flatnonzero(pressure)[-1])
    before, at = pressure[last - 1] ** 2 if last else 0.0, pressure[last] ** 2
    beyond = at / (before - at) if before > 2 * at else 0.5
    return float(places[last] + beyond * step)


def oscillation(pressure: Column, inner: NDArray[np.bool_]) -> float:
    """Return the amplitude of a checkerboard in the pressure inside, relative to its mean.

    That is half of the root mean square by which it departs from the mean of its neighbors along the first axis.
    """
    whole = inner[2:] & inner[:-2]
    if not whole.any():
        return 0.0
    departure = (pressure[1:-1] - (pressure[2:] + pressure[:-2]) / 2)[whole]
    return float(np.sqrt(np.mean(departure**2)) / 2 / np.mean(pressure[1:-1][whole]))
