"""Depth of a pin against worn volume by each engine: uniform pressure, its shape alone, or local wear.

Local wear of a sphere is the GIWM's and an excess that is one curve for all spheres:

h(v) = h_GIWM(v) + δ₀·ψ(v/(π·a₀²·δ₀)), a₀ = Hertz's radius, δ₀ = a₀²/R

so that thousands of draws of load, radius and moduli cost little more than by the GIWM. h is the depth of the middle,
the deepest point. A flat pin follows the GIWM by either engine: its pressure is uneven only while it first wears, by
about as much as its elastic approach, which leaves its middle 0.10·F_N/(E_c·a) short of the GIWM's depth, and no more.

In lengths of Hertz's contact, a₀ along the surface and δ₀ = a₀²/R into it, local wear of a paraboloid depends on
nothing but the worn volume V = v/(π·a₀²·δ₀), and so does the GIWM's. So does the excess of depth

ψ(V) = (h_local − h_GIWM)/δ₀

which matters while wear is shallow against the elastic approach, where a sphere is a paraboloid. It begins with the
pressures of the two in the middle, dψ/dV = 3/2 − (3/4)^⅔. Late, the pressure of both is even, and the worn shape is
flat under the displacement by uniform pressure: F_N/(E_c·a) times 2/π in the middle, 4/π² at the edge, 16/(3π²) on
average (K. L. Johnson, Contact Mechanics, 1985, §3.4), where the GIWM takes ½ all over. With the volume between the
worn shape and the unworn one, and α = (4V)^¼ ≈ a/a₀,

ψ → (4/3)·(1 − 2/π + 16/(3π²))/α − (4/3)^⅓/α², that is, h_local − h_GIWM → 0.904·F_N/(E_c·a).

Between the two it is computed once, by rings.
"""

import math
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from tribopipe.base.arrays import Column
from tribopipe.physics.hertz import hertz_radius
from tribopipe.physics.local.course import wear
from tribopipe.physics.local.rings import Rings, ring_edges
from tribopipe.physics.pin_on_disc import SphericalPin, WornState, no_published_scheme

_FIRST, _LATE, _END = 1e-3, 10**1.5, 1e4
"""V below which ψ is in proportion to V; from which on it is the late one; beyond which there is no table of it."""
_PER_DECADE = 4
_FINER = 0.5
"""Width of the first rings over what a single course needs."""
_STEPS_PER_DECADE = 16
_REACH = 3.8
"""Outer radius of the rings over a₀: what is in contact at V = _LATE, and some more."""
_START_RATIO = 0.75 ** (1 / 3)
"""a₀ over the GIWM's radius before any wear."""
_RAISED = 4 / 3 * (1 - 2 / math.pi + 16 / (3 * math.pi**2))
_WIDENED = 16 / (9 * math.pi**2)


class Excess(NamedTuple):
    """Local wear held against the GIWM's at the same worn volume."""

    depth: Column
    """ψ."""
    rate: Column
    """dψ/dV."""
    radius_ratio: Column
    """Contact radius over the GIWM's."""


def excess(volume: Column) -> Excess:
    """Return what local wear adds to the GIWM at a volume V = v/(π·a₀²·δ₀)."""
    held = np.clip(volume, _FIRST, _END)
    table, place = _table(), np.log(held)
    log_depth, ratio = np.moveaxis(table(place), -1, 0)
    depth = np.exp(log_depth)
    rate, late = depth * table(place, 1)[..., 0] / held, _late(np.maximum(volume, _END))
    cases = [volume < _FIRST, volume > _END]
    return Excess(
        depth=np.select(cases, [depth * volume / _FIRST, late.depth], depth),
        rate=np.select(cases, [depth / _FIRST, late.rate], rate),
        radius_ratio=np.select(cases, [ratio, late.radius_ratio], ratio),
    )


def _late(volume: Column) -> Excess:
    """Return the excess once the pressure is even.

    The worn volume is V = α_l⁴/4 − 16/(9π²)·α_l by local wear and V = α_g⁴/4 + (2/3)·α_g − (4/3)^⅓ by the GIWM, with
    their radii over a₀; either is solved to the first powers of 1/α.
    """
    alpha, start = (4 * volume) ** 0.25, 1 / _START_RATIO
    local, even = 1 + _WIDENED / alpha**3, 1 - 2 / 3 / alpha**3 + start / alpha**4
    raised, lost = _RAISED / alpha, start / alpha**2
    return Excess(raised - lost, (lost / 2 - raised / 4) / volume, local / even)


@cache
def _table() -> Any:
    """Return ln ψ and the ratio of radii as a spline over ln V."""
    from scipy.interpolate import CubicSpline

    early, late = _nodes(_FIRST, _LATE), _nodes(_LATE, _END)[1:]
    ended = _late(late)
    nodes = np.concatenate([_by_rings(early), np.column_stack([np.log(ended.depth), ended.radius_ratio])])
    return CubicSpline(np.log([*early, *late]), nodes)


def _nodes(first: float, last: float) -> Column:
    return np.geomspace(first, last, round(_PER_DECADE * math.log10(last / first)) + 1)


def _by_rings(volumes: Column) -> Column:
    """Compute ln ψ and the ratio of radii, a row for each volume, on a sphere so large that it is a paraboloid.

    The error of implicit steps begins with the first two powers of their length: three lengths show what the depth is
    at length zero (L. F. Richardson, 1911).
    """
    hertz, radius = 1e-4, 1.0
    load = 4 / 3 * hertz**3 / radius
    sphere = SphericalPin(normal_load=load, radius=radius, modulus=1.0)
    worn = volumes * np.pi * hertz**4 / radius
    even = sphere.worn(worn)
    edges = ring_edges(_FINER * hertz, _REACH * hertz)
    middle = (edges[1:] + edges[:-1]) / 2
    surface = Rings(load, 1.0, edges, middle**2 / (2 * radius))
    long, half, short = (wear(surface, worn / load, steps_per_decade=n * _STEPS_PER_DECADE) for n in (1, 2, 4))
    depth = ((8 * short.depth - 6 * half.depth + long.depth) / 3)[1:]
    scars = [_scar(surface.radius, *state) for state in zip(short.worn[1:], short.half_width[1:], strict=True)]
    return np.column_stack([np.log((depth - even.depth) * radius / hertz**2), scars / even.radius])


def _scar(radius: Column, worn: Column, contact: float) -> float:
    """Return where what is lost by wear ends, as a straight line through its last rings has it, if inside the contact.

    Which of the rings is the last in contact leaves the radius uncertain by as much as a ring.
    """
    last = int(np.flatnonzero(worn)[-1]) - 2
    run = radius[last] - radius[last - 2]
    return float(min(contact, radius[last] + worn[last] * run / (worn[last - 2] - worn[last])))


_MOST_ITERATIONS = 60
_CONVERGED = 1e-9
"""Relative Newton step after which the next one, by quadratic convergence, is below the last digit."""
_SHALLOW = 1e-9
"""Depth over δ₀ that stands in for none, where a logarithm is taken."""


@dataclass(frozen=True)
class LocalSphere:
    """A full sphere, worn against the disc by the pressure at each of its points."""

    even: SphericalPin
    """The same sphere with the GIWM."""

    @cached_property
    def _hertz(self) -> tuple[Column, Column]:
        """δ₀, m, and π·a₀², m²."""
        pin = self.even
        radius = hertz_radius(normal_load=pin.normal_load, pin_radius=pin.radius, modulus=pin.modulus)
        return radius**2 / np.asarray(pin.radius), np.pi * radius**2

    @property
    def most_volume(self) -> Column:
        """Volume, m³, at which the contact reaches the full radius of the sphere."""
        return self.even.most_volume

    def worn(self, volume: ArrayLike) -> WornState:
        """Return the pin after wearing off a volume, m³. Raises ``ContactError`` where it holds no such volume."""
        v, (depth, area) = np.asarray(volume, dtype=float), self._hertz
        even, more = self.even.worn(v), excess(v / (area * depth))
        return WornState(
            depth=even.depth + depth * more.depth,
            radius=even.radius * more.radius_ratio,
            area=1 / (1 / even.area + more.rate / area),
        )

    def volume(self, depth: ArrayLike) -> Column:
        """Return the volume, m³, lost by wear at a depth, m, by Newton on ln h against ln v, from the GIWM's.

        Raises ``ContactError`` for a depth below zero or past the tip.
        """
        unworn = np.asarray(depth) == 0
        wanted = np.where(unworn, _SHALLOW * self._hertz[0], depth)
        v = most = self.even.volume(wanted)
        for _ in range(_MOST_ITERATIONS):
            state = self.worn(v)
            step = np.log(state.depth / wanted) * state.depth * state.area / v
            v = np.minimum(v * np.exp(-step), most)
            if np.all(np.abs(step) <= _CONVERGED):
                break
        return np.where(unworn, 0.0, v)

    def published_depth(self, volume_steps: ArrayLike) -> Column:
        """Refuse: the paper's Euler steps are the GIWM's."""
        raise no_published_scheme(volume_steps, "local wear")
