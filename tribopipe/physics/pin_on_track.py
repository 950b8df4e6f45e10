"""A pin that stays in contact on a track that passes under it: scar and groove together, from the wear of both.

Archard's law holds at each point of both surfaces. In a slice at the distance x from the middle of the track, the pin
loses the area A, and the track, which meets the pin once per path L, loses the depth

    h_d(x) = κ·A(x),        κ = k_2/(k_1·L)

The total approach D = w(x) + κ·A(x, w(x)) is the same in all slices, where w is the level to which the pin is worn,
counted from its lowest unworn point. That defines w(x), hence the scar, the groove and both volumes, which is exact for
rigid bodies: the groove's cross-section is S = κ·V_1 and the volume of the track V_2 = L·S.

For small κ the groove follows the chord of the scar, and S is 3π/16 = 0.589 of depth times width; a hard ball leaves a
segment of its own shape, 0.667. On a worn track the scar is wider across than it is long along the sliding direction.

Everything is in SI, in arrays that are broadcast against each other. Cf. Kauzlarich and Williams, Proc. IMechE Part J
215 (2001) 387; Hegadekatte, Huber and Kraft, Tribol. Lett. 24 (2006) 51.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tribopipe.physics.geometry import scar_depth, scar_radius_at, segment_area, segment_height, worn_depth
from tribopipe.physics.interpolation import at_many

Array = NDArray[np.float64]
SHAPE_LEAST, SHAPE_MOST = 3 * np.pi / 16, 2 / 3
"""Cross-section of a shallow groove of a sphere over depth times width: little wear of the track; of the pin."""
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(24)
_MOST_ITERATIONS = 80
_FAR_OFF = 0.03
"""Share of its loss that the middle slice of a pin has at a first estimate, below which another one is taken."""
_EXACT = 1e-13
_CONVERGED = 1e-9
"""Relative step after which a root that converges faster than linearly is exact."""
_MANY = 1000
"""Contacts from which on a polynomial through fewer gives them sooner."""
_GROWTH_NODES = 129
_MOST_OF_THE_PIN = 0.9
"""Share of the greatest approach up to which the way of a pin in a groove is looked at."""


@dataclass(frozen=True)
class WornContact:
    """Shape of a worn pin and of the groove it has worn; lengths in m, areas in m², volumes in m³."""

    pin_depth: Array
    """Height lost by the lowest point of the unworn pin, at the center of the scar."""
    groove_depth: Array
    """Wear depth in the middle of the groove."""
    half_width: Array
    """Half-width of scar and groove, perpendicular to the sliding direction."""
    half_length: Array
    """Half-length of the scar, along the sliding direction."""
    pin_volume: Array
    groove_area: Array
    """Cross-section of the groove."""
    area: Array
    """Area of the contact, m²: the load over the mean pressure."""
    groove_slope: Array
    """d(cross-section)/dh_d as both go on wearing, m."""
    pin_slope: Array
    """dV_1/dh_p as both go on wearing, m²."""

    @property
    def approach(self) -> Array:
        """Total approach of both bodies, m: what a displacement sensor sees."""
        return self.pin_depth + self.groove_depth


class OnTrack(ABC):
    """A pin on a track, both rigid."""

    @property
    @abstractmethod
    def most(self) -> Array:
        """Approach, m, at which the pin is worn away."""

    @abstractmethod
    def approach_at(self, half_width: ArrayLike) -> Array:
        """Return the depth, m, at which the unworn pin has this half width, m; NaN where its width does not grow."""

    @abstractmethod
    def half_width_at(self, approach: ArrayLike) -> Array:
        """Return the half width, m, at a depth below the lowest unworn point of the pin, m."""

    @abstractmethod
    def middle_slice(self, pin_depth: ArrayLike) -> Array:
        """Return the area lost by the pin in its middle slice, m²."""

    @abstractmethod
    def at_depths(self, pin_depth: ArrayLike, groove_depth: ArrayLike) -> WornContact:
        """Return the contact worn to these depths in its middle, m."""

    @abstractmethod
    def worn(self, pin_volume: ArrayLike, groove_area: ArrayLike) -> WornContact:
        """Return the contact whose pin has lost V_1, m³, and whose groove has the cross-section V_2/L, m²."""

    def worn_to(self, depth: ArrayLike, track_ratio: ArrayLike) -> WornContact:
        """Return the contact whose pin is worn to a depth, m, or its track if κ is infinite; κ in 1/m."""
        ratio = _floats(track_ratio)
        both = np.isfinite(ratio)
        pin = np.where(both, depth, 0.0)
        return self.at_depths(pin, np.where(both, np.where(both, ratio, 0.0) * self.middle_slice(pin), depth))


@dataclass(frozen=True)
class SphereOnTrack(OnTrack):
    """A spherical pin, with or without a flat ground on it before the test."""

    radius: ArrayLike
    """Radius of the sphere, m."""
    flat_radius: ArrayLike = 0.0
    """Radius of the flat, m."""

    @property
    def most(self) -> Array:
        """Approach at which the scar would be as wide as the sphere, m."""
        return scar_depth(scar_radius=self.radius, sphere_radius=self.radius, flat_radius=self.flat_radius)

    def half_width_at(self, approach: ArrayLike) -> Array:
        """Return the half width, m, at a depth below the lowest unworn point of the pin, m."""
        return scar_radius_at(depth=approach, sphere_radius=self.radius, flat_radius=self.flat_radius)

    def approach_at(self, half_width: ArrayLike) -> Array:
        """Return the depth, m, at which the unworn pin has this half width, m."""
        return scar_depth(scar_radius=half_width, sphere_radius=self.radius, flat_radius=self.flat_radius)

    def middle_slice(self, pin_depth: ArrayLike) -> Array:
        """Return the area lost by the pin in its middle slice, m²."""
        b = self.half_width_at(pin_depth)
        lost = segment_area(half_chord=b, radius=self.radius)
        return np.asarray(lost - segment_area(half_chord=self.flat_radius, radius=self.radius))

    def at_depths(self, pin_depth: ArrayLike, groove_depth: ArrayLike) -> WornContact:
        """Return the contact worn to these depths in its middle, m.

        In each slice the half chord z solves w(x, z) + κ·A(x, z) = D by Newton's method; slices are added up by
        Gauss–Legendre quadrature over x = a·sin θ, in which everything is smooth.
        """
        r, f, h_p, h_d = np.broadcast_arrays(*map(_floats, (self.radius, self.flat_radius, pin_depth, groove_depth)))
        a = self.half_width_at(h_p + h_d)
        b = self.half_width_at(h_p)
        slices = _Slices(*(one[..., None] for one in (r, f, a, b, self.middle_slice(h_p), h_p, h_d)))
        beside = np.arcsin(np.divide(f, a, out=np.zeros_like(a), where=a > 0))
        sums = slices.integrals(beside[..., None], a[..., None])
        if np.any(f > 0):
            sums = sums + slices.integrals(np.zeros_like(f)[..., None], f[..., None])
        volume, section, area, slope = sums
        return WornContact(h_p, h_d, a, b, volume, section, area, slope, 2 * b * slope)

    def worn(self, pin_volume: ArrayLike, groove_area: ArrayLike) -> WornContact:
        """Return the contact whose pin has lost V_1, m³, and whose groove has the cross-section V_2/L, m².

        V_1 = k_1·F_N·S and V_2 = k_2·F_N·S by Archard's law, for the effective sliding distance S. Of many contacts,
        the shape is that of a master curve (tribopipe.physics.interpolation).
        """
        v, s = np.broadcast_arrays(_floats(pin_volume), _floats(groove_area))
        many = self._by_master_curve(v, s) if v.size > _MANY else None
        return self._solved(v, s) if many is None else many

    def _solved(self, v: Array, s: Array) -> WornContact:
        kappa = np.divide(s, v, out=np.zeros(v.shape), where=v > 0)
        h_p = power_root(
            lambda depth: self.at_depths(depth, kappa * self.middle_slice(depth)).pin_volume,
            v,
            self._about(v, s),
            self.most,
        )
        groove, alone = np.asarray(kappa * self.middle_slice(h_p)), v <= 0
        if np.any(alone & (s > 0)):
            groove = np.where(alone, self.groove_depth_at(np.where(alone, s, 0.0), h_p), groove)
        return self.at_depths(h_p, groove)

    def _by_master_curve(self, v: Array, s: Array) -> WornContact | None:
        """Return many contacts at once, or None where some are worn away.

        In units of the radius R, a sphere has one curve for each ln(V_1/R³) and ln(κR), and each flat on it.
        """
        r, f, v, s = np.broadcast_arrays(_floats(self.radius), _floats(self.flat_radius), v, s)
        both = (v > 0) & (s > 0)
        places = np.stack([np.log(v[both] / r[both] ** 3), np.log(s[both] * r[both] / v[both]), f[both] / r[both]])
        found = at_many(_unit_shape, places) if places.size else None
        if found is None:
            return None
        some = replace(self, radius=r[both], flat_radius=f[both])
        kappa, pin_depth = s[both] / v[both], r[both] * np.exp(found[0])
        groove = kappa * some.middle_slice(pin_depth)
        a, b = some.half_width_at(pin_depth + groove), some.half_width_at(pin_depth)
        area, slope = found[1] * a * b, found[2] * a
        shape = pin_depth, groove, a, b, v[both], s[both], area, slope, 2 * b * slope
        rest = replace(self, radius=r[~both], flat_radius=f[~both])._solved(v[~both], s[~both])  # noqa: SLF001 - its own
        whole = {}
        for field, column in zip(fields(WornContact), shape, strict=True):
            whole[field.name] = np.empty(v.shape)
            whole[field.name][both], whole[field.name][~both] = column, getattr(rest, field.name)
        return WornContact(**whole)

    def _about(self, pin_volume: Array, groove_area: Array) -> Array:
        """Return about how deep, m, a pin is worn: a cap beyond the flat that the groove alone would be wide.

        A cap on the tip itself would be far too deep next to a deep groove, next to which a shallow scar is wide.
        """
        groove = np.minimum(_plain(groove_area, _floats(self.radius)), self.most / 2)
        wide = np.maximum(self.half_width_at(groove), self.flat_radius)
        about, alone = (
            worn_depth(volume=pin_volume, sphere_radius=self.radius, flat_radius=flat)
            for flat in (wide, self.flat_radius)
        )
        # A pin that hardly wears loses in its middle slice what is in proportion to the depth of the groove.
        lost = np.divide(groove * pin_volume, groove_area, out=np.zeros_like(about), where=groove_area > 0)
        least = np.minimum(_plain(lost, _floats(self.radius)), alone)
        return np.where(self.middle_slice(about) < _FAR_OFF * self.middle_slice(least), least, about)

    def groove_depth_at(self, groove_area: ArrayLike, pin_depth: ArrayLike) -> Array:
        """Return the depth, m, of a groove with this cross-section, m², under a pin worn by a depth, m."""
        s, r = _floats(groove_area), _floats(self.radius)
        start = np.minimum(_plain(s, r), s / SHAPE_LEAST / 2 / np.maximum(self.half_width_at(pin_depth), 1e-300))
        return power_root(lambda h: self.at_depths(pin_depth, h).groove_area, s, start, self.most)


@dataclass(frozen=True)
class FlatOnTrack(OnTrack):
    """A flat pin of circular cross-section, which wears least along its middle line and ends crowned across."""

    radius: ArrayLike
    """m."""

    @property
    def most(self) -> Array:
        """Depth, m, deeper than which none is looked for: a thousand radii."""
        return np.asarray(1e3 * _floats(self.radius))

    def approach_at(self, half_width: ArrayLike) -> Array:
        """Return NaN: the contact is as wide at any depth."""
        return np.full(np.shape(half_width), np.nan)

    def half_width_at(self, approach: ArrayLike) -> Array:
        """Return the radius, m: that of the contact at any depth."""
        return np.broadcast_to(_floats(self.radius), np.broadcast_shapes(np.shape(self.radius), np.shape(approach)))

    def middle_slice(self, pin_depth: ArrayLike) -> Array:
        """Return the area lost by the pin in its middle slice, m²."""
        return np.asarray(2 * _floats(self.radius) * _floats(pin_depth))

    def at_depths(self, pin_depth: ArrayLike, groove_depth: ArrayLike) -> WornContact:
        """Return the contact worn to these depths in its middle, m: w(x) = D/(1 + 2κ·√(r² − x²))."""
        r, h_p, h_d = np.broadcast_arrays(*map(_floats, (self.radius, pin_depth, groove_depth)))
        angle, weight = _quarter(np.zeros_like(r)[..., None])
        chord = np.cos(angle)
        below = h_p[..., None] + h_d[..., None] * chord
        share = np.divide(h_p[..., None], below, out=np.ones_like(below), where=below > 0)
        groove = np.divide(h_d[..., None] * chord, below, out=np.zeros_like(below), where=below > 0)
        approach, step = (h_p + h_d)[..., None], 2 * weight * r[..., None] * chord
        half = r[..., None] * chord
        deepening = _deepening((2 * r * h_p)[..., None], h_d[..., None], half, chord)
        slope = np.sum(step * deepening, axis=-1)
        return WornContact(
            pin_depth=h_p,
            groove_depth=h_d,
            half_width=r,
            half_length=r,
            pin_volume=np.sum(step * approach * share * 2 * r[..., None] * chord, axis=-1),
            groove_area=np.sum(step * approach * groove, axis=-1),
            area=np.pi * r**2,
            groove_slope=slope,
            pin_slope=2 * r * slope,
        )

    def worn(self, pin_volume: ArrayLike, groove_area: ArrayLike) -> WornContact:
        """Return the contact whose pin has lost V_1, m³, and whose groove has the cross-section V_2/L, m²."""
        r, v, s = np.broadcast_arrays(_floats(self.radius), _floats(pin_volume), _floats(groove_area))
        kappa = np.divide(s, v, out=np.zeros(v.shape), where=v > 0)
        unit = self.at_depths(1.0, 2 * kappa * r)
        h_p = v / unit.pin_volume
        return self.at_depths(h_p, np.where(v > 0, 2 * kappa * r * h_p, s / (2 * r)))


@dataclass(frozen=True)
class BlockOnTrack(OnTrack):
    """A block on a ring, both of which wear evenly across the sliding direction."""

    radius: ArrayLike
    """Radius of the ring, m."""
    width: float
    """Width of the block, m."""

    @property
    def most(self) -> Array:
        """Approach at which the scar would be as long as the ring, m."""
        return _floats(self.radius)

    def approach_at(self, half_width: ArrayLike) -> Array:
        """Return NaN: the contact is as wide at any depth."""
        return np.full(np.shape(half_width), np.nan)

    def half_width_at(self, approach: ArrayLike) -> Array:
        """Return half the length of the scar along the sliding direction, m, at a depth, m."""
        return scar_radius_at(depth=approach, sphere_radius=self.radius)

    def middle_slice(self, pin_depth: ArrayLike) -> Array:
        """Return the area lost by the block in every slice, m²."""
        return segment_area(half_chord=self.half_width_at(pin_depth), radius=self.radius)

    def at_depths(self, pin_depth: ArrayLike, groove_depth: ArrayLike) -> WornContact:
        """Return the contact worn to these depths, m; the ring is so little smaller that its radius stays."""
        r, h_p, h_d = np.broadcast_arrays(*map(_floats, (self.radius, pin_depth, groove_depth)))
        half = self.half_width_at(h_p)
        return WornContact(
            pin_depth=h_p,
            groove_depth=h_d,
            half_width=np.full(h_p.shape, self.width / 2),
            half_length=half,
            pin_volume=np.asarray(self.width * segment_area(half_chord=half, radius=r)),
            groove_area=np.asarray(self.width * h_d),
            area=np.asarray(2 * self.width * half),
            groove_slope=np.full(h_p.shape, self.width),
            pin_slope=np.asarray(2 * half * self.width),
        )

    def worn(self, pin_volume: ArrayLike, groove_area: ArrayLike) -> WornContact:
        """Return the contact whose block has lost V_1, m³, and whose ring a layer of the cross-section V_2/L, m²."""
        depth = segment_height(area=_floats(pin_volume) / self.width, radius=self.radius)
        return self.at_depths(depth, _floats(groove_area) / self.width)


@dataclass(frozen=True)
class _Slices:
    """Slices along the sliding direction, of arrays that end in an axis for the slices."""

    radius: Array
    flat_radius: Array
    half_width: Array
    half_length: Array
    middle: Array
    """A in the middle slice."""
    pin_depth: Array
    groove_depth: Array

    def integrals(self, first: Array, reach: Array) -> Array:
        """Return integrals over the slices x = reach·sin θ on both sides, from θ = first.

        They are ∫A dx, ∫h_d dx, ∫2z dx, and that of how fast the groove deepens over its middle.
        """
        angle, weight = _quarter(first)
        x, step = reach * np.sin(angle), 2 * weight * reach * np.cos(angle)
        lost, groove, z = self._worn(x, (self.half_width - x) * (self.half_width + x))
        share = np.divide(z, self.half_length, out=np.zeros_like(z), where=self.half_length > 0)
        deepening = _deepening(self.middle, self.groove_depth, z, share)
        return np.stack([np.sum(step * one, axis=-1) for one in (lost, groove, 2 * z, deepening)])

    def _worn(self, x: Array, level: Array) -> tuple[Array, Array, Array]:
        """Return of each slice the area lost by the pin, the depth of the groove and half the chord.

        ``level`` is a² − x².
        """
        rho = np.sqrt(self.radius**2 - x**2)
        ground = np.sqrt(np.maximum(self.flat_radius**2 - x**2, 0.0))
        before = segment_area(half_chord=ground, radius=rho)
        at_edge = np.sqrt(np.maximum(rho**2 - level, 0.0))
        z = self._start(level, ground)
        for _ in range(_MOST_ITERATIONS):
            leg = np.sqrt(np.maximum(rho**2 - z**2, 0.0))
            excess = self.middle * (z**2 - level) / (at_edge + leg)
            excess = excess + self.groove_depth * (segment_area(half_chord=z, radius=rho) - before)
            slope = z * (self.middle + 2 * self.groove_depth * z)
            step = np.divide(excess * leg, slope, out=np.zeros_like(slope), where=slope > 0)
            z = np.clip(z - step, ground, np.sqrt(level))
            if np.all(np.abs(step) <= _CONVERGED * z):
                break
        lost = segment_area(half_chord=z, radius=rho) - before
        by_lost = np.divide(self.groove_depth * lost, self.middle, out=np.zeros_like(lost), where=self.middle > 0)
        by_level = (level - z**2) / (at_edge + np.sqrt(np.maximum(rho**2 - z**2, 0.0)))
        return lost, np.where(self.groove_depth > self.pin_depth, by_level, by_lost), z

    def _start(self, level: Array, ground: Array) -> Array:
        """Return the half chords of a shallow sphere where the pin alone wears, or the track, whichever is less."""
        worn = np.broadcast_to(self.groove_depth > 0, level.shape)
        cube = np.divide(0.75 * self.middle * level, self.groove_depth, out=np.full_like(level, np.inf), where=worn)
        return np.maximum(np.minimum(np.sqrt(level), np.cbrt(cube)), ground)


def _unit_shape(places: Array) -> Array:
    """Return the shape of a sphere of radius 1 at ln V_1, ln κ and the radius of its flat, in numbers of about one.

    They are ln h_p and, in units of a·b and a, the area and how fast the groove deepens; no number where the sphere is
    worn away.
    """
    log_volume, log_kappa, flat = places
    tip, volume = SphereOnTrack(1.0, flat), np.exp(log_volume)
    worn = tip._solved(volume, np.exp(log_kappa) * volume)  # noqa: SLF001 - of this module
    a, b = worn.half_width, worn.half_length
    found = [
        np.log(worn.pin_depth),
        worn.area / (a * b),
        worn.groove_slope / a,
    ]
    return np.where(worn.approach < tip.most, np.stack(found), np.nan)


def _deepening(middle: Array, groove_depth: Array, half_chord: Array, share: Array) -> Array:
    """Return how fast the groove deepens in a slice, over its middle: dh_d/dD = 2κz/(1 + 2κz), as dA/dw is the chord.

    κ is h_d/A in the middle slice, and ``share`` the chord over that of the middle. Under a pin that does not wear, all
    slices deepen alike.
    """
    groove = 2 * groove_depth * half_chord
    both = middle + groove
    return np.divide(middle * share + groove, both, out=np.ones_like(both), where=both > 0)


def _quarter(first: Array) -> tuple[Array, Array]:
    """Return angles from ``first`` to π/2 and their weights."""
    half = (np.pi / 2 - first) / 2
    return first + half * (1 + _NODES), half * _WEIGHTS


def power_root(function: Callable[[Array], Array], target: ArrayLike, start: ArrayLike, most: ArrayLike) -> Array:
    """Return x from 0 to ``most`` where a function that rises from zero about as a power of x meets its target.

    By the secant method in ln x and ln f, which is exact for a power. Where the target is zero or less, x is 0;
    where it is more than the function reaches, x is ``most``.
    """
    wanted, limit = _floats(target), np.log(_floats(most))
    there = wanted > 0
    with np.errstate(divide="ignore", invalid="ignore"):
        goal = np.log(wanted)
        x = np.minimum(np.log(np.where(there, start, 1.0)), limit)
        miss = np.log(function(np.exp(x))) - goal
        step = np.asarray(-miss / 2)
        for _ in range(_MOST_ITERATIONS):
            last, before, x = x, miss, np.minimum(x + step, limit)
            miss = np.log(function(np.exp(x))) - goal
            step = np.where(miss == before, 0.0, -miss * (x - last) / (miss - before))
            if np.all((np.abs(step) <= _CONVERGED) | (np.abs(miss) <= _EXACT) | ~there | ((x == limit) & (step > 0))):
                break
    return np.where(there, np.exp(np.minimum(x + step, limit)), 0.0)


def _plain(groove_area: Array, radius: Array) -> Array:
    """Return the depth, m, of a groove that an unworn sphere ploughs, as a parabola: S = 4/3·h·√(2Rh)."""
    return np.asarray(np.cbrt(9 * groove_area**2 / (32 * radius)))


def _floats(values: ArrayLike) -> Array:
    return np.asarray(values, dtype=np.float64)


def volume_growth(depth_ratio: ArrayLike) -> NDArray[np.float64]:
    """Return the volume that a sphere has lost on a wearing track over that of the cap of the same depth.

    The scar is the wider the deeper the groove. For a paraboloid, with q = h_d/h_p (Archard's law at each point),

        V_1/V_cap = (16/π)·∫₀¹ t²·√(1 − t² + q·(1 − t³)) dt,

    which is 1 on a track that does not wear. A sphere differs from it by about a thousandth.

    Parameters
    ----------
    depth_ratio
        Depth of the groove over wear depth of the pin, both at the center of the contact; any shape.

    Returns
    -------
    ndarray
        The ratio of the volumes, of the same shape.
    """
    ratio = np.asarray(depth_ratio, dtype=float)
    # In t = 1 − x², by which the root at the end of the chord is smooth.
    x = 0.5 * (1 + _NODES)
    t = 1 - x**2
    under = np.sqrt(1 - t**2 + ratio[..., None] * (1 - t**3))
    return np.asarray(16 / np.pi * np.sum(_WEIGHTS * x * t**2 * under, axis=-1))


def flat_volume_growth(depth_ratio: ArrayLike) -> NDArray[np.float64]:
    """Return the volume that a flat pin has lost on a wearing track over that of the cylinder of the same depth.

    The pin wears least along its middle line, where it has the longest chord and the groove is deepest
    (``FlatOnTrack``).

    Parameters
    ----------
    depth_ratio
        Depth of the groove over wear depth of the pin, both at the center of the contact; any shape.

    Returns
    -------
    ndarray
        The ratio of the volumes, of the same shape: 1 on a track that does not wear, and at most 4/π.
    """
    return np.asarray(FlatOnTrack(1.0).at_depths(1.0, depth_ratio).pin_volume / np.pi)


def depth_growth(tip: OnTrack, share: ArrayLike, pin_depth: float, groove_depth: float) -> NDArray[np.float64]:
    """Return by what factor a pin has worn deeper on its way than on a track that does not wear.

    Where the pin was worn to a depth, the groove was as deep as its middle slice had lost area, which gives the volume
    that had been lost by then. On a track that does not wear the same share of the volume is lost at another depth.

    Parameters
    ----------
    tip
        The pin on its track.
    share
        Share of the volume at the end that the pin has lost, from 0 to 1; any shape.
    pin_depth, groove_depth
        Depths in the middle at the end, m, both above zero.

    Returns
    -------
    ndarray
        1 at the end, and more on the way; of the same shape.
    """
    root, factor = _growth(tip, pin_depth, groove_depth)
    return np.asarray(np.interp(np.sqrt(_floats(share)), root, factor))


@lru_cache(maxsize=16)
def _growth(tip: OnTrack, pin_depth: float, groove_depth: float) -> tuple[Array, Array]:
    """Return that factor against the root of the share, where a run asks for it again and again."""
    deepest = min(pin_depth, _MOST_OF_THE_PIN * float(tip.most) - groove_depth)
    if deepest <= 0:
        return np.zeros(1), np.ones(1)
    depth = deepest * np.linspace(0.0, 1.0, _GROWTH_NODES)[1:] ** 2
    groove = groove_depth * tip.middle_slice(depth) / tip.middle_slice(deepest)
    # Depths are about proportional to the root of the volume: of that, interpolation is next to exact.
    worn, on_plane = (np.sqrt(tip.at_depths(depth, beside).pin_volume) for beside in (groove, 0.0))
    root = worn / worn[-1]
    plane = np.interp(root, on_plane / on_plane[-1], depth)
    return root, np.asarray(depth / plane)
