"""A pin on a track of an elastic half space, both of which wear at every point.

A point of the pin stays in contact, and a point of the track meets the pin once per path L. With the amount of wear
q = k_1·S of the pin, m²/N, and κ = k_2/(k_1·L), Archard's law removes at each point

    d(h_1 + h_2)/dq = p + κ·∫p dz,

from the pin and from the track, z along the sliding direction. The contact sees the sum of both, which divides into
the two of them: the track has lost κ·∫h_1 dz on each of its lines. This is the reference for the rigid bodies of
``tribopipe.physics.pin_on_track``.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.base.errors import ContactError
from tribopipe.base.units import show
from tribopipe.physics.geometry import cap_height
from tribopipe.physics.hertz import hertz_ellipse
from tribopipe.physics.local.contact_solvers import Contact
from tribopipe.physics.local.course import STEPS_PER_DECADE, wear
from tribopipe.physics.local.grids import DiscTrack, oscillation
from tribopipe.physics.local.half_space import MirroredHalfSpace
from tribopipe.physics.local.nodes import vanishing
from tribopipe.physics.pin_on_track import SphereOnTrack

CELLS = (64, 64)
"""Points from the middle of the contact to its side, and to its end."""
_MARGIN = 1.15
"""Half of the grid over that of the largest contact."""
_ROUNDING = 1e-9
"""Share of the pin's wear depth below which a difference of depths is none."""
_INNER = 0.8
"""Share of the contact's extent within which the pressure should be smooth."""


@dataclass(frozen=True)
class WornPinAndTrack:
    """A worn pin and the groove it has worn, from the middle of both; half widths are those of the pin's scar."""

    pin: Column
    """Wear depth of the pin at each point, m; the axes are ``places``."""
    groove: Column
    """Wear depth of the track across the sliding direction, m."""
    places: tuple[Column, Column]
    """Positions across and along, m."""
    cell: float
    """Area that a point and its three images stand for, m²."""

    @property
    def pin_depth(self) -> float:
        """Wear depth of the pin in the middle, m."""
        return float(self.pin[0, 0])

    @property
    def groove_depth(self) -> float:
        """Wear depth of the track in the middle, m."""
        return float(self.groove[0])

    @property
    def half_width(self) -> float:
        """Half width of the scar, across the sliding direction, m: what both have lost falls with the square of x."""
        return _end(self.places[0], self.pin[:, 0], self.groove)

    @property
    def half_length(self) -> float:
        """Half length of the scar, along the sliding direction, m."""
        return _end(self.places[1], self.pin[0])

    @property
    def pin_volume(self) -> float:
        """Wear volume of the pin, m³."""
        return float(self.cell * self.pin.sum())

    @property
    def groove_area(self) -> float:
        """Cross-section of the groove, m²: its volume over the path L."""
        return float(4 * self.places[0][0] * self.groove.sum())


@dataclass(frozen=True)
class PinOnTrack(DiscTrack):
    """A quarter of the contact of a pin with a track that wears as well, x across the sliding direction."""

    track_ratio: float
    """κ = k_2/(k_1·L), 1/m."""

    def exposure(self, pressure: Column) -> Column:
        """Return p + κ·∫p dz, Pa: what the pin loses and what the track loses."""
        return np.asarray(pressure + self.track_ratio * super().exposure(pressure))

    def volume(self, worn: Column) -> float:
        """Return the wear volume of the pin, m³."""
        return self.bodies(worn).pin_volume

    def bodies(self, worn: Column) -> WornPinAndTrack:
        """Return the wear of each body, m, from that of both."""
        along_line = 2 * self.half_space.spacing[1]
        both = along_line * worn.sum(axis=1)
        groove = self.track_ratio * both / (1 + self.track_ratio * along_line * worn.shape[1])
        pin = worn - groove[:, None]
        pin = np.where(pin > _ROUNDING * pin.max(), pin, 0.0)
        return WornPinAndTrack(pin, groove, self.half_space.places, self.half_space.cell)

    def stable_amount(self, contact: Contact) -> float:
        """Return that of a checkerboard, which the pin evens out, or of stripes, which both do, m²/N."""
        checkerboard, stripes = 2 * self.half_space.compliance[-1, [-1, 0]]
        length = 2 * self.extent(contact).half_length
        return float(min(checkerboard, stripes / (1 + self.track_ratio * length)))

    def roughness(self, contact: Contact) -> float:
        """Return the oscillation of pressure in the inner part of the contact, relative to its mean."""
        extent, (across, along) = self.extent(contact), self.places
        inner = np.hypot(across[:, None] / extent.half_width, along / extent.half_length) < _INNER
        return max(oscillation(contact.pressure, inner), oscillation(contact.pressure.T, inner.T))

    @property
    def _exposed(self) -> Column:
        return 1 + self.track_ratio * self.half_space.streamlines


def pin_on_track(
    *,
    normal_load: float,
    modulus: float,
    radius: float,
    track_ratio: float,
    amount: float,
    cells: tuple[int, int] = CELLS,
) -> PinOnTrack:
    """Build a spherical pin on a track, on a grid for wear up to an amount k_1·S.

    The grid reaches beyond the scar of rigid bodies and beyond Hertz's contact.

    Parameters
    ----------
    normal_load, modulus, radius
        F_N, N; E_c, Pa; radius of the sphere, m.
    track_ratio
        κ = k_2/(k_1·L), 1/m, with the path L between two passes.
    amount
        k_1·S, m²/N.
    cells
        Points of a quarter of the contact, across and along.

    Returns
    -------
    PinOnTrack

    Raises
    ------
    ContactError
        If a value is negative, or the scar is as wide as the sphere.
    """
    first = hertz_ellipse(normal_load=normal_load, radius_x=radius, radius_z=radius, modulus=modulus)
    if not (track_ratio >= 0 and amount > 0):
        raise ContactError(
            f"local wear: found k_2/(k_1·L) of {track_ratio:g} /m and k_1·S of {amount:g} m²/N; expected the first "
            "to be zero or more and the second to be positive; check the wear coefficients and the sliding distance"
        )
    volume = amount * normal_load
    rigid = SphereOnTrack(radius).worn(volume, track_ratio * volume)
    reach = contact_reach(float(first.half_width), float(rigid.half_width), float(rigid.half_length))
    if not rigid.approach < radius:
        raise _as_wide_as(radius)
    return tip_on_track(
        normal_load=normal_load,
        modulus=modulus,
        tip=lambda place: cap_height(scar_radius=place, sphere_radius=radius),
        radius=radius,
        track_ratio=track_ratio,
        reach=reach,
        cells=cells,
    )


def contact_reach(start: float, half_width: float, half_length: float) -> tuple[float, float]:
    """Return half of the grid across and along, m, for a Hertzian radius and half of the scar of rigid bodies, m."""
    across, along = (_MARGIN * (start**4 + reach**4) ** 0.25 for reach in (half_width, half_length))
    return across, along


def tip_on_track(
    *,
    normal_load: float,
    modulus: float,
    tip: Callable[[Column], Column],
    radius: float,
    track_ratio: float,
    reach: tuple[float, float],
    cells: tuple[int, int] = CELLS,
) -> PinOnTrack:
    """Build a pin of any round shape on a track; N, Pa, m.

    Parameters
    ----------
    normal_load, modulus
        F_N, N; E_c, Pa.
    tip
        Returns how far the pin is behind its end at each radius, m; infinite outside the pin.
    radius
        Radius of a sphere, which is wider than its scar; infinite for other tips.
    track_ratio
        κ = k_2/(k_1·L), 1/m.
    reach
        Half of the grid across and along the sliding direction, m.
    cells
        Points of a quarter of the contact, across and along.

    Raises
    ------
    ContactError
        If the grid is as wide as the sphere.
    """
    if not max(reach) < radius:
        raise _as_wide_as(radius)
    half_space = MirroredHalfSpace(modulus, (reach[0] / (cells[0] - 1), reach[1] / (cells[1] - 1)), cells)
    across, along = half_space.places
    return PinOnTrack(normal_load, half_space, tip(np.hypot(across[:, None], along)), track_ratio)


def _as_wide_as(radius: float) -> ContactError:
    return ContactError(
        "local wear: found so much wear that the scar is as wide as the sphere of radius "
        f"{show(radius, None, 'm', 'mm')}; expected a narrower scar; use a shorter distance, or check load, wear "
        "coefficients and radius"
    )


def wear_pin_and_track(
    surface: PinOnTrack, amount: float, *, steps_per_decade: int = STEPS_PER_DECADE
) -> WornPinAndTrack:
    """Return both bodies after an amount of wear k_1·S, m²/N. Raises ``ContactError``."""
    return surface.bodies(wear(surface, [amount], steps_per_decade=steps_per_decade).worn[-1])


def _end(places: Column, pin: Column, groove: Column | float = 0.0) -> float:
    """Return where the scar ends, m: within a spacing beyond its last point.

    What the contact has lost, which the pin follows along the sliding direction and both bodies across it, falls there
    linearly with the square of the place, as the gap of the unworn sphere rises. The last point may have lost less.
    """
    if not pin.any():
        return 0.0
    last = int(np.flatnonzero(pin)[-1])
    end = vanishing(places, np.sqrt(pin + groove), last - 2) if last > 1 else np.inf
    return float(np.clip(end, places[last], places[last] + 2 * places[0]))
