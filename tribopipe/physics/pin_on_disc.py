"""Global Incremental Wear Model for a pin on a disc (paper, Section 2): exact and as published.

All wear laws read dh/ds = k_D·p·f with p = F_N/(πa²), so depth depends on load, coefficient and distance only through
the worn volume v = k_D·F_N·S, where S is the law's effective distance. Each pin shape is therefore one monotone
master curve h(v), in closed form one way and inverted by Newton's method the other.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from tribopipe.base.arrays import Column
from tribopipe.base.errors import ContactError
from tribopipe.base.units import show
from tribopipe.physics.geometry import (
    cap_height,
    cap_radius,
    scar_radius_at,
    segment_area,
    segment_height,
    worn_depth,
    worn_volume,
)
from tribopipe.physics.hertz import elastic_approach, hertz_radius

_MOST_ITERATIONS = 60
_CONVERGED = 1e-9
"""Relative Newton step after which the next one, by quadratic convergence, is below the last digit."""
_BLOCK = 16_384
"""Places solved at a time, so that they stay in the processor's cache."""
_POINT = 1e-9
"""Contact radius of an unworn rigid sphere over its own: none would make its pressure infinite."""
_CUBICALLY_CONVERGED = 1e-5
"""Relative step of Halley's method after which the next one is."""


@dataclass(frozen=True)
class WornState:
    """Wear depth and contact radius of the pin, m."""

    depth: Column
    radius: Column
    area: Column
    """dv/dh, m², the load over the pressure where the pin wears deepest: πa² where pressure is even."""
    width: float = 0.0
    """Length of a line contact across the sliding, m, of which the radius is half the length along it; 0 of others."""

    @property
    def half_width(self) -> Column:
        """Half the width across the sliding direction, m."""
        return np.full_like(self.radius, self.width / 2) if self.width else self.radius

    @property
    def even_area(self) -> Column:
        """Area of the contact, m²."""
        return np.asarray(2 * self.width * self.radius if self.width else np.pi * self.radius**2)


class PinContact(Protocol):
    """A pin of some shape under load: depth against worn volume, both ways."""

    @property
    def most_volume(self) -> Column:
        """Volume, m³, at which the shape is worn away and the model ends."""
        ...

    def worn(self, volume: ArrayLike) -> WornState:
        """Return the pin after wearing off a volume, m³. Raises ``ContactError`` where it holds no such volume."""
        ...

    def volume(self, depth: ArrayLike) -> Column:
        """Return the volume, m³, lost by wear at a depth, m."""
        ...

    def published_depth(self, volume_steps: ArrayLike) -> Column:
        """Return the depths that the paper's explicit Euler steps reach, m; the first is 0."""
        ...


def _evenly_worn(depth: Column, radius: Column) -> WornState:
    return WornState(depth=depth, radius=radius, area=np.pi * radius**2)


@dataclass(frozen=True)
class FlatPin:
    """A pin of constant contact area: h = v/(πa²)."""

    radius: ArrayLike
    """Radius a of the flat end, m."""

    @property
    def most_volume(self) -> Column:
        """No bound: the shape stays as it is."""
        return np.asarray(np.inf)

    def worn(self, volume: ArrayLike) -> WornState:
        """Return depth and contact radius after wearing off a volume, m³."""
        radius = np.asarray(self.radius, dtype=float)
        depth = np.asarray(volume, dtype=float) / (np.pi * radius**2)
        return _evenly_worn(depth, np.broadcast_to(radius, depth.shape))

    def volume(self, depth: ArrayLike) -> Column:
        """Return the volume, m³, lost by wear at a depth, m."""
        return np.asarray(np.asarray(depth, dtype=float) * np.pi * np.square(self.radius))

    def published_depth(self, volume_steps: ArrayLike) -> Column:
        """Return the depths of explicit Euler steps, which are exact at constant area."""
        return self.worn(np.concatenate([[0.0], np.cumsum(volume_steps)])).depth


@dataclass(frozen=True)
class SphericalPin:
    """A sphere worn flat against the disc.

    The contact radius a follows from the sum of wear and elastic approach, cap(a) = h + F_N/(2 E_c a) with
    cap(a) = R − √(R² − a²) (Fig. 2b, Eq. 5). In the limit Δs → 0 of Eq. 6, dv = πa²·dh integrates to

        v = V_cap(a) − V_cap(a*) + (π F_N / 2 E_c)·(a − a*),

    where V_cap(a) is the cap's volume and a* the radius without wear, cap(a*) = F_N/(2 E_c a*). The unknown solved
    for is the growth d = cap(a) − cap(a*), in which nothing cancels however small the wear.

    A truncated sphere, with a flat of radius a₀ before the test, is as if the sphere had worn so far: by the cap's
    height c₀ = cap(a₀). So it goes on along the curve of the full sphere, h_s(v), from there:

        h(v) = h_s(v₀ + v) − h_s(v₀)    with    h_s(v₀) = c₀

    Its contact begins at a* with cap(a*) = c₀ + F_N/(2 E_c a*): larger than the flat and than the contact of the whole
    sphere, and next to the larger one of the two where they differ much. Nothing but that start is other than above.

    Arguments in SI; arrays broadcast against each other and against what the methods are given. Raises
    ``ContactError`` where the elastic contact alone is as large as the tip.
    """

    normal_load: ArrayLike
    radius: ArrayLike
    modulus: ArrayLike
    flat_radius: ArrayLike = 0.0
    """a₀ of a truncated sphere, m; 0 for a whole one."""

    def __post_init__(self) -> None:
        load, radius, modulus = self._inputs
        if np.any(load / (2 * modulus) >= radius * (radius - self._missing_height)):
            raise ContactError(
                f"contact: found a load of {show(np.max(load), None, 'N')} on a tip of radius "
                f"{show(np.min(radius), None, 'm', 'mm')}, with an elastic contact as large as the tip; expected a "
                "contact much smaller than the tip; check load, radius and moduli"
            )

    @cached_property
    def _inputs(self) -> tuple[Column, Column, Column]:
        load, radius, modulus = (np.asarray(x, dtype=float) for x in (self.normal_load, self.radius, self.modulus))
        return load, radius, modulus

    @cached_property
    def _missing_height(self) -> Column:
        """Height c₀ of the cap that a truncated sphere has lost before the test, m."""
        return cap_height(scar_radius=self.flat_radius, sphere_radius=self.radius)

    @cached_property
    def _start_approach(self) -> Column:
        """Elastic approach e without wear, e²(c₀ + e)(2R − c₀ − e) = (F_N/2E_c)², by Newton on its logarithm."""
        load, radius, modulus = self._inputs
        target, missing = (load / (2 * modulus * radius**2)) ** 2, self._missing_height / radius
        e = np.cbrt(target / 2)
        for _ in range(_MOST_ITERATIONS):
            c = missing + e
            excess = np.log(e**2 * c * (2 - c) / target)
            step = excess / (2 + e / c - e / (2 - c))
            e = e * np.exp(-step)
            if np.all(np.abs(step) <= _CONVERGED):
                break
        return np.asarray(e * radius)

    @property
    def most_volume(self) -> Column:
        """Volume, m³, at which the contact reaches the full radius of the sphere."""
        _, _, centre = self._start
        return self._volume_of_growth(centre)

    def worn(self, volume: ArrayLike) -> WornState:
        """Return depth and contact radius after wearing off a volume, m³.

        Raises ``ContactError`` where more than half a sphere would be gone.
        """
        v = np.asarray(volume, dtype=float)
        if np.any(v > self.most_volume):
            raise worn_away(v, self.most_volume)
        if v.ndim != 1 or v.size <= _BLOCK:
            return self._worn_by(self._growth_of_volume(v))
        blocks = [self.worn(v[first : first + _BLOCK]) for first in range(0, v.size, _BLOCK)]
        depth, radius, area = (
            np.concatenate([getattr(one, name) for one in blocks]) for name in ("depth", "radius", "area")
        )
        return WornState(depth, radius, area)

    def volume(self, depth: ArrayLike) -> Column:
        """Return the volume, m³, lost by wear at a depth, m."""
        return self._volume_of_growth(self._growth_of_depth(np.asarray(depth, dtype=float)))

    @cached_property
    def _start(self) -> tuple[Column, Column, Column]:
        """Contact radius a* without wear, elastic approach e, and height R − cap(a*) of the sphere's center, m."""
        _, radius, _ = self._inputs
        height = self._missing_height + self._start_approach
        return cap_radius(height=height, sphere_radius=radius), self._start_approach, radius - height

    def _widening(self, growth: Column) -> tuple[Column, Column]:
        """Return (a/a*)² − 1, in which nothing cancels, and a/a*."""
        start, _, centre = self._start
        widening = growth * (2 * centre - growth) / start**2
        return widening, np.sqrt(1 + widening)

    def _worn_by(self, growth: Column) -> WornState:
        """Return the pin at a growth, with h = d + (elastic approach at a*) − (elastic approach at a)."""
        start, approach, _ = self._start
        widening, ratio = self._widening(growth)
        return _evenly_worn(growth + approach * widening / (ratio * (1 + ratio)), start * ratio)

    def _volume_of_growth(self, growth: Column) -> Column:
        return np.asarray(np.pi * self._volume(growth, *self._widening(growth)))

    def _volume(self, growth: Column, widening: Column, ratio: Column) -> Column:
        """Return v/π: that of the cap, and of what the elastic approach gives back as the contact widens."""
        start, approach, centre = self._start
        cap = growth * (start**2 + growth * (centre - growth / 3))
        return np.asarray(cap + approach * start**2 * widening / (1 + ratio))

    def _growth_of_volume(self, volume: Column) -> Column:
        """Invert v(d) by Halley's method, from the root of a quadratic that is a few percent off at most.

        dv/dd = π(a² + e·(R − c)/(a/a*)) with the cap's height c, and the second derivative follows from a² = c(2R − c).
        """
        (start, approach, centre), (_, radius, _) = self._start, self._inputs
        area = start**2
        target = np.where(volume > 0, volume, 0.0) / np.pi
        linear = area + approach * centre
        growth = np.minimum(2 * target / (linear + np.sqrt(linear**2 + 4 * radius * target)), centre)
        for _ in range(_MOST_ITERATIONS):
            widening, ratio = self._widening(growth)
            above, elastic = centre - growth, approach / ratio
            excess = self._volume(growth, widening, ratio) - target
            slope = area * (1 + widening) + elastic * above
            bend = 2 * above - elastic * (1 + above**2 / (area * (1 + widening)))
            step = 2 * excess * slope / (2 * slope**2 - excess * bend)
            growth = np.minimum(growth - step, centre)
            if np.all(np.abs(step) <= _CUBICALLY_CONVERGED * growth):
                break
        return growth

    def _growth_of_depth(self, depth: Column) -> Column:
        """Invert h(d), which is concave, by Newton from below."""
        (start, approach, centre), (_, radius, _) = self._start, self._inputs
        if np.any(depth < 0) or np.any(depth > self._worn_by(centre).depth):
            raise no_such_depth(depth, radius - self._missing_height)
        growth = np.asarray(depth / (1 + approach * centre / start**2))
        for _ in range(_MOST_ITERATIONS):
            state = self._worn_by(growth)
            step = (depth - state.depth) / (1 + approach * (centre - growth) * start / state.radius**3)
            growth = np.minimum(growth + step, centre)
            if np.all(np.abs(step) <= _CONVERGED * growth):
                break
        return np.asarray(growth)

    def published_depth(self, volume_steps: ArrayLike) -> Column:
        """Return the depths of the paper's flow chart (Fig. 2, Eq. 4–6), m, one more than there are steps.

        Each step wears Δh = Δv/(πa²) with Δv = k_D·F_N·f·Δs and then widens the contact to a = √(2R·h_t − h_t²), where
        the total displacement h_t takes the elastic part of the step before, and the cap missing from a truncated
        sphere. Starts from Hertz's radius (Eq. 4), or from the flat of a truncated sphere where that is larger.
        """
        load, radius, modulus = (float(x) for x in self._inputs)
        a = max(
            float(hertz_radius(normal_load=load, pin_radius=radius, modulus=modulus)),
            float(np.asarray(self.flat_radius)),
        )
        missing = float(self._missing_height)
        elastic = float(elastic_approach(normal_load=load, modulus=modulus, contact_radius=a))
        depths = [0.0]
        for volume in np.asarray(volume_steps, dtype=float).tolist():
            depths.append(depths[-1] + volume / (np.pi * a * a))
            total = missing + depths[-1] + elastic
            if total >= radius:
                raise ContactError(
                    "published scheme: found a step in which the pin wears beyond its radius; expected smaller steps; "
                    "use more steps with --steps, or the exact scheme"
                )
            a = (2 * radius * total - total * total) ** 0.5
            elastic = load / (2 * modulus * a)
        return np.array(depths)


@dataclass(frozen=True)
class RigidSphere:
    """A sphere, truncated or not, that has lost exactly the volume missing from its shape.

    Elastic approach widens the contact of the GIWM, which thus overestimates the volume that a pin has lost:
    by as much
    as the approach is of its depth, times about four. Local wear keeps to the volume of the shape within 0.3 % once the
    pin has worn by more than its Hertzian approach.
    """

    radius: ArrayLike
    flat_radius: ArrayLike = 0.0
    """a₀ of a truncated sphere, m; 0 for a whole one."""

    @property
    def most_volume(self) -> Column:
        """Volume, m³, of half a sphere beyond the flat it began with."""
        height = np.sqrt(np.square(self.radius) - np.square(self.flat_radius))
        return worn_volume(depth=height, sphere_radius=self.radius, flat_radius=self.flat_radius)

    def worn(self, volume: ArrayLike) -> WornState:
        """Return depth and contact radius after wearing off a volume, m³.

        Raises ``ContactError`` where more than half a sphere would be gone.
        """
        v = np.asarray(volume, dtype=float)
        if np.any(v > self.most_volume):
            raise worn_away(v, self.most_volume)
        depth = worn_depth(volume=v, sphere_radius=self.radius, flat_radius=self.flat_radius)
        scar = scar_radius_at(depth=depth, sphere_radius=self.radius, flat_radius=self.flat_radius)
        return _evenly_worn(depth, np.maximum(scar, _POINT * np.asarray(self.radius)))

    def volume(self, depth: ArrayLike) -> Column:
        """Return the volume, m³, lost by wear at a depth, m. Raises ``ContactError`` where the tip is not as high."""
        height = np.sqrt(np.square(self.radius) - np.square(self.flat_radius))
        if np.any(np.less(depth, 0)) or np.any(np.greater(depth, height)):
            raise no_such_depth(depth, height)
        return worn_volume(depth=depth, sphere_radius=self.radius, flat_radius=self.flat_radius)

    def published_depth(self, volume_steps: ArrayLike) -> Column:
        """Refuse: the paper's Euler steps are the GIWM's."""
        raise no_published_scheme(volume_steps, "wear volumes from geometry only")


@dataclass(frozen=True)
class BlockOnCylinder:
    """A block that wears to a part of the cylinder on which it lies: V = width·(segment of its circle)."""

    radius: ArrayLike
    """Radius of the cylinder, m."""
    width: float
    """Width of the block, perpendicular to the sliding direction, m."""

    @property
    def most_volume(self) -> Column:
        """Volume, m³, of half a cylinder."""
        return np.asarray(self.width * np.pi * np.square(self.radius) / 2)

    def worn(self, volume: ArrayLike) -> WornState:
        """Return depth, and half the length along the sliding, after wearing off a volume, m³.

        Raises ``ContactError`` where more than half a cylinder would be gone.
        """
        v = np.asarray(volume, dtype=float)
        if np.any(v > self.most_volume):
            raise worn_away(v, self.most_volume)
        depth = segment_height(area=v / self.width, radius=self.radius)
        half = np.maximum(cap_radius(height=depth, sphere_radius=self.radius), _POINT * np.asarray(self.radius))
        return WornState(depth=depth, radius=half, area=2 * half * self.width, width=self.width)

    def volume(self, depth: ArrayLike) -> Column:
        """Return the volume, m³, lost by wear at a depth, m. Raises ``ContactError`` beyond the cylinder's radius."""
        if np.any(np.less(depth, 0)) or np.any(np.greater(depth, self.radius)):
            raise no_such_depth(depth, self.radius)
        half = cap_radius(height=depth, sphere_radius=self.radius)
        return np.asarray(self.width * segment_area(half_chord=half, radius=self.radius))

    def published_depth(self, volume_steps: ArrayLike) -> Column:
        """Refuse: the paper's Euler steps are the GIWM's."""
        raise no_published_scheme(volume_steps, "a block on a ring")


def worn_away(volume: Column, most: Column) -> ContactError:
    """Return the refusal of a volume that a tip does not hold."""
    return ContactError(
        f"contact: found a wear volume of {show(np.max(volume), None, 'm^3', 'mm^3')}, more than the volume of the tip "
        f"({show(np.min(most), None, 'm^3', 'mm^3')}); expected wear within the tip; check wear coefficient, load and "
        "sliding distance"
    )


def no_such_depth(depth: ArrayLike, height: ArrayLike) -> ContactError:
    """Return the error for a wear depth that the pin tip cannot have."""
    return ContactError(
        f"contact: found a wear depth of {show(np.max(np.abs(depth)), None, 'm', 'um')}; expected a wear depth between "
        f"0 and the tip height of {show(np.min(height), None, 'm', 'um')}; check the depth and its unit"
    )


def no_published_scheme(volume_steps: ArrayLike, engine: str) -> ContactError:
    """Return the refusal of the paper's scheme under another engine than the paper's."""
    return ContactError(
        f"published scheme: found {np.size(volume_steps)} steps for {engine}; expected the GIWM, which this scheme "
        "implements (flow chart, Fig. 2); use the exact scheme, or a k_D fitted with --engine giwm"
    )
