"""Global Incremental Wear Model of two discs that roll and slip (paper, Sections 3.1 and A), exact and published.

A disc with a crown (1) rolls on a flat one (2). Worn by h₁ and h₂, they touch over a flat of half width a across and
half-length a_z along the direction of rolling (Eqs. 10, 12 and 15):

    cap(a) = h₁ + h₂ + u,   cap(a) = r₁ₓ − √(r₁ₓ² − a²),   u = F_N / (2 E_c √(a·a_z)),   a_z = κ·√(4 F' r_eq / (π E_c)),
    F' = F_N/(2a),   1/r_eq = 1/(r₁ − h₁) + 1/(r₂ − h₂),   κ = π/4 as printed

and the mean pressure is p = (π/4)·√(F' E_c/(π r_eq)) (Eq. 13, 16). A rotation of the crowned disc wears off, with ν =
n₂/n₁ rotations of the cylindrical disc and the slip distance s = 2π·|ν(r₂ − h₂) − (r₁ − h₁)| in it,

    contact-width (Eq. 11)       dh₁/dN = k₁·p·2a_z = (π/4)·k₁·F'         dh₂/dN = (π/4)·k₂·F'·ν
    line-load (κ = 1)            dh₁/dN = k₁·p·2a_z = k₁·F'         dh₂/dN = k₂·F'·ν
    full-slip (Eq. 14)           dh₁/dN = k₁·p·s                          dh₂/dN = k₂·p·s·ν
    volume-conserving            dh₁/dN = k₁·F'·s / (2π(r₁ − h₁))         dh₂/dN = k₂·F'·s / (2π(r₂ − h₂))

*contact-width* counts the length of the contact as sliding distance in each rotation, whatever the slip: the paper's
picture of a
disc turning at the slip velocity on a fixed one (Fig. 7b). *line-load* is the same with κ = 1, by which p·2a_z is
all of the load: what the local model tends to (tribopipe.physics.local). *full-slip* counts all of s for every point,
although it is in contact for a small part of a turn only. *volume-conserving* counts what a point slides while it is
in contact, so that each disc loses V = k·F_N·s as Archard's law has it, and k compares with that of a pin on a disc.

In all of them h₁ : h₂ follows from the sum h₁ + h₂ in closed form, and everything else from the height c = cap(a), so
that the number of rotations is one integral over ln c, taken by Gauss and Legendre's rule to the last digits. It is
inverted by Newton's method. The number of rotations itself has no cost.

What the paper leaves open, and is taken so: the motors hold n₁ and n₂, so that speeds and slip change with the radii;
n counts revolutions; slip is that over the crowned disc's speed, positive where the cylindrical disc is faster; the
crown radius r₁ₓ stays next to the flat; a starts where the elastic contact alone has it (h = 0 above), not quite
Hertz's ellipse, since the equations above are not Hertz's; the volume lost is that of a flat of width 2a receding by
dh, dV₁ = 2π(r₁ − h₁)·2a·dh₁, and likewise on the cylindrical disc.

The explicit steps, as printed (Fig. 8, Eq. 10–13; Fig. A, Eq. 14–16), a rotation at a time:

They start from Hertz's ellipse, with p₀ = F_N/(π·a_x·a_z) and u₀ by Eq. 10. Each step first lets both discs recede by
k·p times the distance they slide (counted in one of the ways above), and then takes

a_x = √(2r₁ₓ·h − h²) with h = h₁ + h₂ + u, r₁ = r₁z − h₁, r₂ = r₂z − h₂, a_z and p by Eq. 15 and 16

and the speeds v = 2πnr of radii so changed. Wear on one disc only is k₂ = 0. What the paper leaves open: u is renewed
by Eq. 10 in every step, with a_x and a_z of that step, and enters the next one.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from tribopipe.base.arrays import Column
from tribopipe.base.errors import ContactError
from tribopipe.physics.calculation_methods import DistanceConvention
from tribopipe.physics.disc_contact import Discs
from tribopipe.physics.disc_course import Course, beyond
from tribopipe.physics.geometry import cap_height
from tribopipe.physics.hertz import hertz_ellipse


@dataclass(frozen=True)
class DiscWear:
    """State of two discs after a number of rotations of the crowned one, SI."""

    curved_depth: Column
    """h₁, m."""
    flat_depth: Column
    """h₂, m."""
    curved_volume: Column
    """V₁, m³."""
    flat_volume: Column
    """V₂, m³."""
    half_width: Column
    """a_x, m: half of the worn track's width."""
    half_length: Column
    """a_z, m."""
    pressure: Column
    """Mean contact pressure p, Pa."""
    slip: Column
    """(v₂ − v₁)/v₁."""
    sliding_distance: Column
    """Slip distance so far, m."""
    curved_rate: Column
    """dh₁/dN, m."""
    flat_rate: Column
    """dh₂/dN, m."""


class Cut(NamedTuple):
    """Two discs where the crown is cut off at some height, SI; names are those of ``DiscWear``."""

    rotations: Column
    """N by which they are so."""
    slope: Column
    """d ln(growth)/d ln N."""
    half_width: Column
    curved_depth: Column
    flat_depth: Column
    curved_volume: Column
    flat_volume: Column
    curved_rate: Column
    flat_rate: Column


@dataclass(frozen=True)
class DiscPair(Discs):
    """Two discs that wear. Raises ``ContactError`` where they do not touch, or touch over all of the crown."""

    def worn(self, rotations: ArrayLike, curved_coefficient: ArrayLike, flat_coefficient: ArrayLike = 0.0) -> DiscWear:
        """Return the discs after rotations of the crowned one, for k₁ and k₂ in m²/N.

        Raises ``ContactError`` where the crown would be worn away before that.
        """
        turns = np.asarray(rotations, dtype=float)
        total, course = self._course(curved_coefficient, flat_coefficient)
        if not np.all(turns >= 0):
            raise ContactError(
                f"contact: found {float(np.min(turns)):.4g} rotations; expected zero or a positive number; check the "
                "number of rotations"
            )
        growth = course.growth_of_turns(turns * total * (np.asarray(self.slip) != 0))
        contact, sums = course.contact(growth), course.sums(growth)
        slip, part = course.slip_distance(contact), course.curved_part(contact)
        rate = total * course.rate(contact) * (np.asarray(self.slip) != 0)
        unworn = np.array(np.abs(slip) * turns + 0 * sums.turns)
        slid = np.divide(sums.slid, total, out=unworn, where=(total > 0) & (sums.turns > 0))
        curved = np.asarray(self.curved_radius, dtype=float)
        return DiscWear(
            curved_depth=contact.curved_depth,
            flat_depth=contact.flat_depth,
            curved_volume=sums.curved_volume,
            flat_volume=sums.flat_volume,
            half_width=contact.half_width,
            half_length=course.half_length(contact),
            pressure=course.pressure(contact),
            slip=slip / (2 * np.pi * (curved - contact.curved_depth)),
            sliding_distance=slid,
            curved_rate=rate * part,
            flat_rate=rate * (1 - part),
        )

    def cut(self, growth: ArrayLike, curved_coefficient: ArrayLike, flat_coefficient: ArrayLike = 0.0) -> Cut:
        """Return the discs where the crown is cut off by a height more than at the start, to nine digits.

        Nothing is inverted, so that it costs a fraction of ``worn``. Growth, m, and k₁, k₂, m²/N, broadcast. Where the
        crown is worn away, or slip ends before, there is no number, or no true one: growth is to lie within both.
        """
        total, course = self._course(curved_coefficient, flat_coefficient)
        growth = np.asarray(growth, dtype=float)
        contact = course.contact(growth)
        part, rate = course.curved_part(contact), course.rate(contact)
        turns, curved_volume, flat_volume = course.turns_and_volumes(growth)
        # dh/d ln N = rate·N, and dh/d ln c is the recession.
        slope = rate * turns / course.recession(contact, part) * contact.height / growth
        return Cut(
            rotations=turns / total,
            slope=slope,
            half_width=contact.half_width,
            curved_depth=contact.curved_depth,
            flat_depth=contact.flat_depth,
            curved_volume=curved_volume,
            flat_volume=flat_volume,
            curved_rate=total * rate * part,
            flat_rate=total * rate * (1 - part),
        )

    def growth(self, rotations: ArrayLike, curved_coefficient: ArrayLike, flat_coefficient: ArrayLike = 0.0) -> Column:
        """Return by how much more the crown is cut off after rotations than at the start, m: the inverse of ``cut``.

        Raises ``ContactError`` where the crown would be worn away before that.
        """
        total, course = self._course(curved_coefficient, flat_coefficient)
        return course.growth_of_turns(np.asarray(rotations, dtype=float) * total * (np.asarray(self.slip) != 0))

    def rotations(
        self, curved_depth: ArrayLike, curved_coefficient: ArrayLike, flat_coefficient: ArrayLike = 0.0
    ) -> Column:
        """Return the rotations of the crowned disc after which it has worn by a depth, m; infinite where it never has.

        Raises ``ContactError`` where the crown would be worn away before that.
        """
        total, course = self._course(curved_coefficient, flat_coefficient)
        wears = (np.asarray(curved_coefficient) > 0) & (np.asarray(self.slip) != 0)
        depth = np.asarray(curved_depth, dtype=float)
        reached = wears & (depth < course.contact(course.end_growth).curved_depth)
        if np.any(wears & ~reached & ~course.slip_ends):
            raise beyond(self.largest_height)
        turns = course.sums(course.growth_of_curved_depth(np.where(reached, depth, 0.0))).turns
        return np.where(reached, np.divide(turns, total, out=np.zeros(np.shape(turns)), where=total > 0), np.inf)

    def depth_of_area(self, area: ArrayLike) -> Column:
        """Return h₁ + h₂, m, where the discs have lost a cross-section A₁ + A₂ = ∫2a·dh, m²."""
        course = self._geometry()
        return _depth(course, course.growth_of_area(np.asarray(area, dtype=float)))

    def depth_of_width(self, width: ArrayLike) -> Column:
        """Return h₁ + h₂, m, where the worn track is 2a wide, m; 0 where the elastic contact alone is wider."""
        half, crown = np.asarray(width, dtype=float) / 2, np.asarray(self.crown_radius, dtype=float)
        growth = cap_height(scar_radius=half, sphere_radius=crown) - self.start_height
        return _depth(self._geometry(), np.maximum(growth, 0.0))

    def _geometry(self) -> Course:
        """Return a course along which wear never ends with the slip: how wear is shared hardly changes the shape."""
        return Course(replace(self, distance="contact-width"), np.asarray(1.0), np.asarray(0.0))

    def _course(self, curved_coefficient: ArrayLike, flat_coefficient: ArrayLike) -> tuple[Column, Course]:
        """Return k₁ + k₂ and the course of wear for their shares; all of it the first's where nothing wears."""
        first, second = np.broadcast_arrays(
            np.asarray(curved_coefficient, dtype=float), np.asarray(flat_coefficient, dtype=float)
        )
        total = first + second
        if not np.all((first >= 0) & (second >= 0) & np.isfinite(total)):
            raise ContactError(
                f"contact: found a wear coefficient of {float(np.min([first, second])):.4g} m²/N; expected zero or a "
                "positive value; check both wear coefficients"
            )
        mine = np.divide(first, total, out=np.ones(np.shape(total)), where=total > 0)
        other = np.divide(second, total, out=np.zeros(np.shape(total)), where=total > 0)
        return total, Course(self, mine, other)


def _depth(course: Course, growth: Column) -> Column:
    contact = course.contact(growth)
    return np.asarray(contact.curved_depth + contact.flat_depth)


def published_wear(
    discs: DiscPair, rotation_steps: ArrayLike, curved_coefficient: float, flat_coefficient: float = 0.0
) -> DiscWear:
    """Return the discs before the first and after each step, for numbers of rotations a step and k₁, k₂ in m²/N.

    Arguments of ``discs`` must be single numbers. Raises ``ContactError`` where a step wears the crown past its radius.
    """
    steps = np.asarray(rotation_steps, dtype=float).tolist()
    states = np.array(list(_states(discs, steps, curved_coefficient, flat_coefficient)))
    return DiscWear(*states.T)


def _states(
    discs: DiscPair, steps: list[float], curved_coefficient: float, flat_coefficient: float
) -> Iterator[tuple[float, ...]]:
    """Yield the fields of ``DiscWear`` in their order."""
    load, crown, curved, flat, modulus, _ = (float(value.item()) for value in discs.inputs)
    ratio = float(discs.rotation_ratio.item())
    start = hertz_ellipse(normal_load=load, radius_x=crown, radius_z=curved * flat / (curved + flat), modulus=modulus)
    a_x, a_z, p = start.half_width, start.half_length, start.mean_pressure
    r_1, r_2 = curved, flat
    h_1 = h_2 = volume_1 = volume_2 = slid = 0.0
    for turns in (*steps, 0.0):
        u = load / (2 * modulus * math.sqrt(a_x * a_z))
        slip = 2 * math.pi * (ratio * r_2 - r_1)
        rate_1, rate_2 = _work(discs.distance, load, a_x, a_z, p, slip, r_1, r_2, ratio)
        rate_1, rate_2 = curved_coefficient * rate_1, flat_coefficient * rate_2
        yield (h_1, h_2, volume_1, volume_2, a_x, a_z, p, slip / (2 * math.pi * r_1), slid, rate_1, rate_2)
        h_1, h_2 = h_1 + rate_1 * turns, h_2 + rate_2 * turns
        volume_1 += 4 * math.pi * r_1 * a_x * rate_1 * turns
        volume_2 += 4 * math.pi * r_2 * a_x * rate_2 * turns
        slid += abs(slip) * turns
        total = h_1 + h_2 + u
        if total >= min(crown, curved, flat):
            raise ContactError(
                "published scheme: found a step in which the crown or a disc is completely worn away; expected smaller "
                "steps; use more steps with --steps, or the exact scheme"
            )
        a_x = math.sqrt(2 * crown * total - total * total)
        r_1, r_2 = curved - h_1, flat - h_2
        line_load, equivalent = load / (2 * a_x), r_1 * r_2 / (r_1 + r_2)
        a_z = discs.kappa * math.sqrt(4 * line_load * equivalent / (math.pi * modulus))
        p = math.pi / 4 * math.sqrt(line_load * modulus / (math.pi * equivalent))


def _work(
    distance: DistanceConvention,
    load: float,
    a_x: float,
    a_z: float,
    p: float,
    slip: float,
    r_1: float,
    r_2: float,
    ratio: float,
) -> tuple[float, float]:
    """Return pressure times the sliding distance in one rotation of the crowned disc, for both discs, N/m."""
    if distance == "volume-conserving":
        through = load / (2 * a_x) * abs(slip) / (2 * math.pi)
        return through / r_1, through / r_2
    per_turn = 2 * a_z * (slip != 0) if distance in ("contact-width", "line-load") else abs(slip)
    return p * per_turn, p * per_turn * ratio
