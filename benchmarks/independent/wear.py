"""How pins and discs wear, by numerical integration; SI units throughout.

A pin loses the volume v = ∫k·F_N dS (Archard). Its depth follows from that by the growth of its contact, in the
incremental model of the paper with its elastic approach (dv = πa²·dh with cap(a) = c₀ + h + F_N/(2 E_c a)), tabulated
here over the contact radius a.
"""

from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
from scipy.integrate import cumulative_simpson
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq

from independent.noise import Column

_NODES = 4001
_TIP = 1e-5
"""Share of the tip's radius from which a contact grows where nothing elastic widens it."""
Shape = Literal["spherical", "flat", "truncated-sphere"]


class WornPin(NamedTuple):
    """Depth and contact radius of a pin, m."""

    depth: Column
    contact: Column


@dataclass(frozen=True)
class Tip:
    """A tip under load."""

    shape: Shape
    radius: float
    load: float
    modulus: float
    """Contact modulus E_c, Pa; infinite for rigid bodies."""
    flat: float = 0.0
    """Radius of the flat of a truncated sphere."""

    def worn(self, volume: Column) -> WornPin:
        """Return the pin after losing volumes, m³."""
        if self.shape == "flat":
            return WornPin(volume / (np.pi * self.radius**2), np.full_like(volume, self.radius))
        lost, depth, contact = self._table(float(np.max(volume)))
        return WornPin(np.interp(volume, lost, depth), np.interp(volume, lost, contact))

    def _table(self, most: float) -> tuple[Column, Column, Column]:
        """Tabulate volume, depth and contact radius, closest where wear begins."""
        start = self._unworn()
        end = (start**4 + 8 * self.radius * most / np.pi) ** 0.25 * 1.05
        stretch = np.linspace(0, 1, _NODES) ** 2 * np.log(end / start)
        a = start * np.exp(stretch)
        elastic = self.load / (2 * self.modulus)
        depth = self._cap(a) - self._cap(start) + elastic * (1 / start - 1 / a)
        per_stretch = np.pi * a**2 * (a**2 / np.sqrt(self.radius**2 - a**2) + elastic / a)
        share = np.linspace(0, 1, _NODES)
        lost = cumulative_simpson(per_stretch * 2 * share * np.log(end / start), x=share, initial=0)
        return np.asarray(lost), np.asarray(depth), np.asarray(a)

    def _unworn(self) -> float:
        """Return the contact radius before any wear."""
        elastic, missing = self.load / (2 * self.modulus), float(self._cap(self.flat))
        if elastic == 0:
            return max(self.flat, _TIP * self.radius)
        return float(brentq(lambda a: a * (float(self._cap(a)) - missing) - elastic, self.flat, 0.9 * self.radius))

    def _cap(self, a: Column | float) -> Column:
        return np.asarray(self.radius - np.sqrt(self.radius**2 - np.square(a)))

    def volume(self, depth: float) -> float:
        """Return the volume between tip and a plane at a depth."""
        if self.shape == "flat":
            return float(np.pi * self.radius**2 * depth)
        below = float(self._cap(self.flat))

        def cap(height: float) -> float:
            return float(np.pi * height**2 * (self.radius - height / 3))

        return cap(depth + below) - cap(below)

    def scar(self, depth: float) -> float:
        """Return the diameter of the scar at a depth."""
        height = depth + float(self._cap(self.flat))
        return float(2 * np.sqrt(height * (2 * self.radius - height)))


def disc_growth(contact: Column, distance: Column) -> Column:
    """Return the course of a disc's wear under a growing contact, ∫ds/a, from 0 to 1."""
    inverse = 1 / contact
    grown = np.concatenate([[0.0], np.cumsum((inverse[1:] + inverse[:-1]) * np.diff(distance))])
    return np.asarray(grown / grown[-1])


def beside_groove(tip: Tip, volume: Column, groove: Column) -> WornPin:
    """Return a pin that has lost volumes, m³, on a disc with a groove of these depths, m.

    Its scar x² + z² + q·|z|³/b = b²(1 + q), q = h_d/h_p, is the wider the deeper the groove, so that the pin is less
    deep for its volume than on a disc that does not wear.
    """
    worn = tip.worn(volume)
    if tip.shape == "flat" or not np.any(groove > 0):
        return worn
    t = (np.arange(400) + 0.5) / 400
    for _ in range(30):
        ratio, before = groove / np.maximum(worn.depth, 1e-12), worn.depth
        grown = 16 / np.pi * np.mean(t**2 * np.sqrt(1 - t**2 + ratio[:, None] * (1 - t**3)), axis=1)
        worn = tip.worn(volume / grown)
        if np.max(np.abs(worn.depth - before)) < 1e-14:
            break
    return worn


def less_deep(tip: Tip, volume: Column, groove: Column) -> Column:
    """Return the depth of a pin beside a groove over that on a disc that does not wear; 1 before either wears."""
    plane, beside = tip.worn(volume).depth, beside_groove(tip, volume, groove).depth
    return np.divide(beside, plane, out=np.ones_like(plane), where=plane > 0)


def scar_diameter(tip: Tip, depth: float, groove: float) -> float:
    """Return the mean of length and width of a scar, as ASTM G99 has a diameter measured."""
    length = tip.scar(depth)
    return 0.5 * length * (1 + float(np.sqrt(1 + groove / depth)))


class BothWorn(NamedTuple):
    """Depths of ball and groove at the middle of the contact, m."""

    ball: Column
    groove: Column


def both_worn(radius: float, ratio: float, path: float, ball_volume: Column) -> BothWorn:
    """Return the depths of a worn ball and of its groove, the ball a paraboloid.

    The scar's outline is x² + z² + (4/3)κ|z|³ = 2RD with κ = k_2/(k_1 L), ``ratio`` k_2/k_1 and the path L once around.
    """
    kappa = ratio / path
    most = (16 * radius * float(np.max(ball_volume))) ** 0.25
    b = np.linspace(0, 1, _NODES) * most
    t = (np.arange(200) + 0.5) / 200
    cubic = 4 / 3 * kappa * b[:, None] * (1 - t**3)
    lost = 4 * b**4 / radius * np.mean(t**2 * np.sqrt(1 - t**2 + cubic), axis=1)
    half = np.interp(ball_volume, lost, b)
    return BothWorn(half**2 / (2 * radius), 2 * kappa / (3 * radius) * half**3)


class Outline(NamedTuple):
    """Half length along the sliding and half width across it of a ball's scar, m."""

    length: float
    width: float


_SLICES = (np.arange(160) + 0.5) / 160


def scar_outline(radius: float, kappa: float, ball_volume: float) -> Outline:
    """Return the scar of a sphere that has lost a volume, m³, on a track that it wears by κ times its slices' areas.

    The approach D of both follows from the volume.
    """

    def lost(approach: float) -> float:
        return float(_lost(radius, kappa, np.array([approach]))[0])

    approach = float(brentq(lambda d: lost(d) - ball_volume, 1e-9, 0.5 * radius, xtol=1e-13))
    middle = float(_level(radius, np.zeros(1), kappa, np.array([approach]))[0])
    return Outline(*(float(np.sqrt(depth * (2 * radius - depth))) for depth in (middle, approach)))


class WornPair(NamedTuple):
    """Wear depths of a ball and of the groove under it, m."""

    ball: Column
    groove: Column


def worn_pair(radius: float, ball: Column, section: Column) -> WornPair:
    """Return both depths where a ball has lost volumes, m³, and its groove has these cross-sections, m², in proportion.

    A ball that loses nothing leaves a segment of its own circle.
    """
    if not ball[-1]:
        depths = radius * np.geomspace(1e-8, 0.3, 160)
        return WornPair(np.zeros_like(ball), np.interp(section, _segment(radius, depths), depths))
    # A groove only makes the approach deeper at which a ball has lost a volume.
    least = np.sqrt(np.min(ball[ball > 0]) / (np.pi * radius)) / (2 * radius)
    depths = radius * np.geomspace(least, 0.3, round(21 * np.log10(0.3 / least)) + 2)
    kappa = section[-1] / ball[-1]
    volumes = _lost(radius, kappa, depths)
    both = np.exp(CubicSpline(np.log(volumes), np.log(depths))(np.log(np.maximum(ball, volumes[0]))))
    of_ball = _level(radius, np.zeros_like(both), kappa, both)
    return WornPair(np.where(ball > 0, of_ball, 0.0), np.where(ball > 0, both - of_ball, 0.0))


def _level(rho: Column | float, lowest: Column, kappa: float, approach: Column) -> Column:
    """Return how deep slices are worn, circles of radius ρ: the level w with w + κ·A(w) = D, by bisection."""
    low, high = lowest.copy(), np.broadcast_to(approach, lowest.shape).copy()
    for _ in range(50):
        level = (low + high) / 2
        over = level + kappa * _segment(rho, level - lowest) > approach
        low, high = np.where(over, low, level), np.where(over, level, high)
    return level


def _lost(radius: float, kappa: float, approach: Column) -> Column:
    """Return the volumes that a ball has lost, m³: each slice at x is a circle of the radius ρ, ρ² = R² − x²."""
    width = np.sqrt(approach * (2 * radius - approach))
    rho = np.sqrt(radius**2 - np.outer(width, _SLICES) ** 2)
    lowest = radius - rho
    level = _level(rho, lowest, kappa, approach[:, None])
    return np.asarray(2 * np.sum(_segment(rho, level - lowest), axis=1) * width / len(_SLICES))


def _segment(radius: Column | float, height: Column | float) -> Column:
    """Return the area of a segment of a circle, m²."""
    h = np.maximum(height, 0.0)
    return np.asarray(
        radius**2 * np.arccos(1 - h / radius) - (radius - h) * np.sqrt(np.maximum(2 * radius * h - h**2, 0.0))
    )
