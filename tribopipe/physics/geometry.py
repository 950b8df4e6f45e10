"""Geometry of a worn spherical tip and of the groove it leaves, in forms that lose no digits.

A sphere of radius R worn flat over a radius b has lost a cap of the height c = R − √(R² − b²). Where it began with a
flat of radius a₀, it has lost what lies between the two flats. The groove that such a tip leaves is as deep across its
middle as the tip's flat a, and from there on follows the sphere up to the half width b.

The short formulas of ASTM G99 take the sphere for a paraboloid; their error is given with them.
"""

import numpy as np
from numpy.typing import ArrayLike

from tribopipe.base.arrays import Column

_MOST_ITERATIONS = 60
_CONVERGED = 1e-14
_SMALL_ANGLE = 1.0
"""Angle below which θ − sin θ is summed as a series, since its two parts cancel."""


def cap_height(*, scar_radius: ArrayLike, sphere_radius: ArrayLike) -> Column:
    """Return the height of the cap under a flat scar: R − √(R² − a²), m.

    Written a²/(R + √(R² − a²)), which keeps all digits of shallow caps. a and R in m, a ≤ R.
    """
    a, r = np.asarray(scar_radius, dtype=float), np.asarray(sphere_radius, dtype=float)
    # A draw of a scar as wide as the tip may be wider: half a sphere is gone then.
    return np.asarray(a**2 / (r + np.sqrt(np.maximum(r**2 - a**2, 0.0))))


def cap_radius(*, height: ArrayLike, sphere_radius: ArrayLike) -> Column:
    """Return the scar radius of a cap: a = √(c(2R − c)), m. c and R in m, c ≤ R."""
    c, r = np.asarray(height, dtype=float), np.asarray(sphere_radius, dtype=float)
    return np.asarray(np.sqrt(c * (2 * r - c)))


def scar_depth(*, scar_radius: ArrayLike, sphere_radius: ArrayLike, flat_radius: ArrayLike = 0.0) -> Column:
    """Return the height between a scar of radius b and the flat a₀ the sphere began with, m; below zero if b < a₀.

    h = √(R² − a₀²) − √(R² − b²), written (b² − a₀²)/(√(R² − a₀²) + √(R² − b²)). All in m.
    """
    b, r, a = (np.asarray(x, dtype=float) for x in (scar_radius, sphere_radius, flat_radius))
    return np.asarray((b - a) * (b + a) / (_leg(r, a) + _leg(r, b)))


def scar_radius_at(*, depth: ArrayLike, sphere_radius: ArrayLike, flat_radius: ArrayLike = 0.0) -> Column:
    """Return the scar radius b of a sphere worn by a depth h beyond its flat a₀: b² = a₀² + h(2√(R² − a₀²) − h), m."""
    h, r, a = (np.asarray(x, dtype=float) for x in (depth, sphere_radius, flat_radius))
    return np.asarray(np.sqrt(np.maximum(a**2 + h * (2 * _leg(r, a) - h), 0.0)))


def worn_volume(*, depth: ArrayLike, sphere_radius: ArrayLike, flat_radius: ArrayLike = 0.0) -> Column:
    """Return the wear volume of a sphere by a depth h beyond the flat a₀ it began with, m³.

    V = π·h·(a₀² + h·√(R² − a₀²) − h²/3), which without a flat is the cap's πh²(3R − h)/3. All in m.
    """
    h, r, a = (np.asarray(x, dtype=float) for x in (depth, sphere_radius, flat_radius))
    return np.asarray(np.pi * h * (a**2 + h * _leg(r, a) - h**2 / 3))


def worn_depth(*, volume: ArrayLike, sphere_radius: ArrayLike, flat_radius: ArrayLike = 0.0) -> Column:
    """Return the depth, m, at which a sphere has lost a volume, m³, beyond the flat it began with.

    The cubic of ``worn_volume`` by Newton's method; it is solved at most for what is left of half a sphere. A volume
    below zero, as a draw may be, gives as much of a depth below zero.
    """
    lost, r, a = np.broadcast_arrays(*(np.asarray(x, dtype=float) for x in (volume, sphere_radius, flat_radius)))
    most = _leg(r, a)
    wanted = np.minimum(np.abs(lost) / np.pi, most * (a**2 + 2 * most**2 / 3))
    root = a**2 + np.sqrt(a**4 + 4 * most * wanted)
    depth = np.divide(2 * wanted, root, out=np.zeros_like(root), where=root > 0)
    for _ in range(_MOST_ITERATIONS):
        slope = a**2 + depth * (2 * most - depth)
        excess = depth * (a**2 + depth * (most - depth / 3)) - wanted
        step = np.divide(excess, slope, out=np.zeros_like(slope), where=slope > 0)
        depth = np.minimum(depth - step, most)
        if np.all(np.abs(step) <= _CONVERGED * depth):
            break
    return np.asarray(np.copysign(depth, lost))


def segment_area(*, half_chord: ArrayLike, radius: ArrayLike) -> Column:
    """Return the area between a circle and a chord of half length b: R²·(θ − sin θ·cos θ), θ = arcsin(b/R), m².

    It is the r²·arcsin(d/2r) − (d/4)·√(4r² − d²) of ASTM G99, with d = 2b: the groove of a ball that has not worn. Both
    in m, b ≤ R.
    """
    b, r = np.asarray(half_chord, dtype=float), np.asarray(radius, dtype=float)
    share = np.divide(b, r, out=np.zeros(np.broadcast(b, r).shape), where=r > 0)
    return np.asarray(r**2 / 2 * _angle_less_sine(2 * np.arcsin(np.minimum(share, 1.0))))


def segment_height(*, area: ArrayLike, radius: ArrayLike) -> Column:
    """Return the height of the segment of a circle that has an area, at most half of it, by Newton's method, m.

    An area below zero, as a draw may be, gives as much of a height below zero.
    """
    wanted, r = np.broadcast_arrays(np.asarray(area, dtype=float), np.asarray(radius, dtype=float))
    target = np.minimum(np.abs(wanted), np.pi * r**2 / 2)
    # A parabola, 4/3·h·√(2Rh), is too deep by a fifth at most.
    height = np.minimum(np.cbrt(9 * target**2 / (32 * r)), r)
    for _ in range(_MOST_ITERATIONS):
        half_chord = cap_radius(height=height, sphere_radius=r)
        excess = segment_area(half_chord=half_chord, radius=r) - target
        step = np.divide(excess, 2 * half_chord, out=np.zeros_like(excess), where=half_chord > 0)
        height = np.clip(height - step, 0.0, r)
        if np.all(np.abs(step) <= _CONVERGED * height):
            break
    return np.asarray(np.copysign(height, wanted))


def circle_volume(*, area: ArrayLike, track_radius: ArrayLike) -> Column:
    """Return the volume of a track around a circle, 2πR·A, m³: exact for a groove symmetric about R (Pappus)."""
    return np.asarray(2 * np.pi * np.asarray(track_radius, dtype=float) * np.asarray(area, dtype=float))


def _leg(hypotenuse: Column, other: Column) -> Column:
    """Return √(R² − a²); 0 for what a draw may make wider than the sphere."""
    return np.asarray(np.sqrt(np.maximum((hypotenuse - other) * (hypotenuse + other), 0.0)))


def _angle_less_sine(angle: Column) -> Column:
    """Return θ − sin θ of an angle from 0 to π: θ³/6·(1 − θ²/20·(1 − θ²/42·(…))) where it is small."""
    square = angle * angle
    series = np.ones_like(angle)
    for n in range(21, 3, -2):
        series = 1 - square * series / (n * (n - 1))
    return np.asarray(np.where(angle < _SMALL_ANGLE, angle * square / 6 * series, angle - np.sin(angle)))
