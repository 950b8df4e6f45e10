"""Global Incremental Wear Model for two discs that roll and slip (paper, Sections 3.1 and A): the limit of its steps.

A disc with a crown (1) rolls on a flat one (2). Worn by h₁ and h₂, they touch over a flat of half width a across and
half length a_z along the direction of rolling (Eq. 10, 12, 15):

    cap(a) = h₁ + h₂ + u,   cap(a) = r₁ₓ − √(r₁ₓ² − a²),   u = F_N / (2 E_c √(a·a_z)),   a_z = κ·√(4 F' r_eq / (π E_c)),
    F' = F_N/(2a),   1/r_eq = 1/(r₁ − h₁) + 1/(r₂ − h₂),   κ = π/4

and the mean pressure is p = (π/4)·√(F' E_c/(π r_eq)) (Eq. 13, 16). A rotation of the curved disc wears off, with
ν = n₂/n₁ rotations of the flat disc and the slip distance s = 2π·|ν(r₂ − h₂) − (r₁ − h₁)| in it,

    contact-width (Eq. 11)       dh₁/dN = k₁·p·2a_z = (π/4)·k₁·F'         dh₂/dN = (π/4)·k₂·F'·ν
    full-slip (Eq. 14)           dh₁/dN = k₁·p·s                          dh₂/dN = k₂·p·s·ν
    volume-conserving            dh₁/dN = k₁·F'·s / (2π(r₁ − h₁))         dh₂/dN = k₂·F'·s / (2π(r₂ − h₂))

*contact-width* counts the length of the contact as slid in each rotation, whatever the slip: the paper's picture of a
disc turning at the slip velocity on a fixed one (Fig. 7b). *full-slip* counts all of s for every point, although it
is in contact for a small part of a turn only. *volume-conserving* counts what a point slides while it is in contact,
so that each disc loses V = k·F_N·s as Archard's law has it, and k compares with that of a pin on a disc.

In all three h₁ : h₂ follows from the sum h₁ + h₂ in closed form, and everything else from the height c = cap(a), so
that the number of rotations is one integral over ln c, taken by Gauss and Legendre's rule to the last digits. It is
inverted by Newton's method. The number of rotations itself costs nothing.

What the paper leaves open, and is taken so: the motors hold n₁ and n₂, so that speeds and slip change with the radii;
n counts revolutions; slip is that over the curved disc's speed, positive where the flat disc is faster; the crown
radius r₁ₓ stays beside the flat; a starts where the elastic contact alone has it (h = 0 above), which is not quite
Hertz's ellipse, since the equations above are not Hertz's; the volume lost is that of a flat of width 2a receding by
dh, dV₁ = 2π(r₁ − h₁)·2a·dh₁, and likewise on the flat disc.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from tribopipe.errors import ContactError
from tribopipe.records.recipe import DistanceConvention
from tribopipe.run import Column
from tribopipe.units import show

KAPPA = np.pi / 4
"""κ of Eq. 12 and 15."""
_MOST_ITERATIONS = 60
_CONVERGED = 1e-13
_FEWEST_NODES, _NODES_PER_E_FOLD = 8, 2
"""Enough that more of them change nothing in the last digits (tests/test_twin_disc.py)."""


@dataclass(frozen=True)
class DiscWear:
    """State of two discs after a number of rotations of the curved one, SI."""

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


class _Contact(NamedTuple):
    """The contact where the crown is cut off at some height."""

    height: Column
    """c = cap(a), m."""
    half_width: Column
    curved_depth: Column
    flat_depth: Column
    elastic: Column
    """u, m."""
    equivalent: Column
    """r_eq, m."""


class _Sums(NamedTuple):
    """What has come together since the start: integrals over ln c."""

    turns: Column
    """(k₁ + k₂)·N, m²/N."""
    curved_volume: Column
    flat_volume: Column
    slid: Column
    """(k₁ + k₂)·s, m³/N."""


@dataclass(frozen=True)
class DiscPair:
    """Two discs under load. Arguments in SI; arrays broadcast against each other and against what methods are given.

    Raises ``ContactError`` where the discs do not touch, or their elastic contact is as large as the crown.
    """

    normal_load: ArrayLike
    crown_radius: ArrayLike
    """r₁ₓ."""
    curved_radius: ArrayLike
    """r₁z."""
    flat_radius: ArrayLike
    """r₂z."""
    modulus: ArrayLike
    """E_c."""
    slip: ArrayLike
    """(v₂ − v₁)/v₁ of the unworn discs."""
    distance: DistanceConvention

    def __post_init__(self) -> None:
        load, crown, *_ = self.inputs
        if not np.all(load > 0):
            raise ContactError(
                f"contact: found a load of {show(float(np.min(load)), None, 'N')}; expected one above zero, or the "
                "discs do not touch; check normal_load"
            )
        if not np.all(self.start_height < crown):
            raise ContactError(
                f"contact: found a load of {show(float(np.max(load)), None, 'N')} on a crown of radius "
                f"{show(float(np.min(crown)), None, 'm', 'mm')}, whose elastic contact is as large as the crown; "
                "expected a contact much smaller than that; check load, crown radius and moduli"
            )

    @cached_property
    def inputs(self) -> tuple[Column, Column, Column, Column, Column, Column]:
        """Everything but the convention, as arrays."""
        given = (self.normal_load, self.crown_radius, self.curved_radius, self.flat_radius, self.modulus, self.slip)
        load, crown, curved, flat, modulus, slip = (np.asarray(value, dtype=float) for value in given)
        return load, crown, curved, flat, modulus, slip

    @cached_property
    def rotation_ratio(self) -> Column:
        """ν = n₂/n₁."""
        _, _, curved, flat, _, slip = self.inputs
        return np.asarray((1 + slip) * curved / flat)

    @cached_property
    def start_equivalent(self) -> Column:
        """r_eq of the unworn discs."""
        _, _, curved, flat, _, _ = self.inputs
        return np.asarray(curved * flat / (curved + flat))

    @cached_property
    def start_height(self) -> Column:
        """c* = u(a*) without wear, by Newton's method on its logarithm; u falls as a^(-1/4)."""
        load, crown, _, _, modulus, _ = self.inputs
        line = 2 * load * self.start_equivalent / (np.pi * modulus)
        target = np.log(load / (2 * modulus * np.sqrt(KAPPA) * line**0.25))
        log_c = np.asarray((target - np.log(2 * crown) / 8) * 8 / 9)
        for _ in range(_MOST_ITERATIONS):
            c = np.minimum(np.exp(log_c), crown)
            step = (np.log(c) + np.log(c * (2 * crown - c)) / 8 - target) / (1 + (crown - c) / (2 * crown - c) / 4)
            log_c = np.log(c) - step
            if np.all((np.abs(step) <= _CONVERGED) | (log_c >= np.log(crown))):
                break
        return np.asarray(np.exp(log_c))

    def with_axis(self) -> "DiscPair":
        """Return the same discs with an axis more, for the nodes of an integral."""
        load, crown, curved, flat, modulus, slip = (value[..., None] for value in self.inputs)
        return DiscPair(load, crown, curved, flat, modulus, slip, self.distance)

    def worn(self, rotations: ArrayLike, curved_coefficient: ArrayLike, flat_coefficient: ArrayLike = 0.0) -> DiscWear:
        """Return the discs after rotations of the curved one, for k₁ and k₂ in m²/N.

        Raises ``ContactError`` where the crown would be worn away before that.
        """
        turns = np.asarray(rotations, dtype=float)
        curved = np.asarray(self.curved_radius, dtype=float)
        total, course = self._course(curved_coefficient, flat_coefficient)
        growth = course.growth_of_turns(turns * total * (np.asarray(self.slip) != 0))
        contact, sums = course.contact(growth), course.sums(growth)
        slip = course.slip_distance(contact)
        start = np.broadcast_to(np.abs(slip), np.shape(sums.turns)).copy()
        mean_slip = np.divide(sums.slid, sums.turns, out=start, where=sums.turns > 0)
        return DiscWear(
            curved_depth=contact.curved_depth,
            flat_depth=contact.flat_depth,
            curved_volume=sums.curved_volume,
            flat_volume=sums.flat_volume,
            half_width=contact.half_width,
            half_length=course.half_length(contact),
            pressure=course.pressure(contact),
            slip=slip / (2 * np.pi * (curved - contact.curved_depth)),
            sliding_distance=mean_slip * turns,
        )

    def rotations(
        self, curved_depth: ArrayLike, curved_coefficient: ArrayLike, flat_coefficient: ArrayLike = 0.0
    ) -> Column:
        """Return the rotations of the curved disc after which it has worn by a depth, m; infinite where it never has.

        Raises ``ContactError`` where the crown would be worn away before that.
        """
        total, course = self._course(curved_coefficient, flat_coefficient)
        wears = (np.asarray(curved_coefficient) > 0) & (np.asarray(self.slip) != 0)
        growth = course.growth_of_curved_depth(np.where(wears, np.asarray(curved_depth, dtype=float), 0.0))
        turns = course.sums(growth).turns
        return np.where(wears, np.divide(turns, total, out=np.zeros(np.shape(turns)), where=wears), np.inf)

    def _course(self, curved_coefficient: ArrayLike, flat_coefficient: ArrayLike) -> "tuple[Column, _Course]":
        """Return k₁ + k₂ and the course of wear for k₁'s share of it; all of it where nothing wears."""
        first = np.asarray(curved_coefficient, dtype=float)
        total = np.asarray(first + flat_coefficient)
        return total, _Course(self, np.divide(first, total, out=np.ones(np.shape(total)), where=total > 0))


@dataclass(frozen=True)
class _Course:
    """What two discs go through as c grows, which depends on k₁ and k₂ only by k₁'s share of their sum."""

    discs: DiscPair
    share: Column

    def growth_of_turns(self, target: Column) -> Column:
        """Return the growth of c at which (k₁ + k₂)·N has some value, m²/N."""

        def reached(growth: Column) -> tuple[Column, Column]:
            contact = self.contact(growth)
            part = self.curved_part(contact)
            with np.errstate(divide="ignore"):
                slope = self.recession(contact, part) / contact.height / self.rate(contact)
            return self.sums(growth).turns, slope

        return self._growth(target, reached)

    def growth_of_curved_depth(self, target: Column) -> Column:
        """Return the growth of c at which h₁ has some value, m."""

        def reached(growth: Column) -> tuple[Column, Column]:
            contact = self.contact(growth)
            part = self.curved_part(contact)
            return contact.curved_depth, part * self.recession(contact, part) / contact.height

        return self._growth(target, reached)

    def _growth(self, target: Column, reached: Callable[[Column], tuple[Column, Column]]) -> Column:
        """Return the growth of c at which what increases from 0 reaches a target.

        By Newton's method on its logarithm against that of the growth, within a bracket. ``reached`` gives value and
        slope.
        """
        crown = np.asarray(self.discs.crown_radius, dtype=float)
        positive, most = target > 0, (crown - self.discs.start_height) + 0 * target
        _, slope = reached(np.zeros(np.shape(most)))
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            growth = np.where(positive, np.minimum(target / slope, most), 0.0)
            low, high = np.zeros(np.shape(growth)), most
            for _ in range(_MOST_ITERATIONS):
                value, slope = reached(growth)
                short = value < target
                low, high = np.where(short, growth, low), np.where(short, high, growth)
                step = np.log(value / target) * value / (slope * growth)
                moved = growth * np.exp(-step)
                inside = (moved > low) & (moved < high)
                moved = np.where(inside, moved, np.where(np.abs(step) <= _CONVERGED, growth, (low + high) / 2))
                moved = np.where(positive, moved, 0.0)
                settled = np.abs(moved - growth) <= _CONVERGED * growth
                growth = moved
                if np.all(settled):
                    break
        if np.any(positive & (growth >= most * (1 - 1e-12))):
            raise ContactError(
                f"contact: found wear beyond the crown's radius of {show(float(np.min(crown)), None, 'm', 'mm')}; "
                "expected the worn flat within the crown; check wear coefficients, load and rotations"
            )
        return np.asarray(growth)

    def sums(self, growth: Column) -> _Sums:
        """Integrate over ln c from the start to c* + growth."""
        span = np.log1p(growth / self.discs.start_height)
        count = _FEWEST_NODES + int(np.ceil(_NODES_PER_E_FOLD * float(np.max(span, initial=0.0))))
        nodes, weights = np.polynomial.legendre.leggauss(count)
        course = _Course(self.discs.with_axis(), np.asarray(self.share)[..., None])
        at = span[..., None] * (nodes + 1) / 2
        contact = course.contact(course.discs.start_height * np.expm1(at))
        part = course.curved_part(contact)
        recession = course.recession(contact, part) * span[..., None] / 2
        with np.errstate(divide="ignore", invalid="ignore"):
            turns = np.where(at > 0, recession / course.rate(contact), 0.0)
        _, _, curved, flat, _, _ = course.discs.inputs
        across = 4 * np.pi * contact.half_width * recession
        return _Sums(
            turns=turns @ weights,
            curved_volume=((curved - contact.curved_depth) * part * across) @ weights,
            flat_volume=((flat - contact.flat_depth) * (1 - part) * across) @ weights,
            slid=(np.abs(course.slip_distance(contact)) * turns) @ weights,
        )

    def contact(self, growth: Column) -> _Contact:
        """Return the contact where c = c* + growth."""
        _, crown, curved, flat, _, _ = self.discs.inputs
        start, equivalent = self.discs.start_height, self.discs.start_equivalent
        height = start + growth
        widened = (np.log1p(growth / start) + np.log1p(-growth / (2 * crown - start))) / 2
        depth = growth
        for _ in range(_MOST_ITERATIONS):  # r_eq falls with the depth, by so little that two rounds will do
            first, second = self._split(depth)
            sharpened = np.log1p(equivalent * (first / (curved * (curved - first)) + second / (flat * (flat - second))))
            before, depth = depth, growth - start * np.expm1((sharpened - widened) / 4)
            if np.all(np.abs(depth - before) <= _CONVERGED * depth):
                break
        return _Contact(
            height=height,
            half_width=np.sqrt(height * (2 * crown - height)),
            curved_depth=first,
            flat_depth=second,
            elastic=start * np.exp((sharpened - widened) / 4),
            equivalent=equivalent * np.exp(-sharpened),
        )

    def _split(self, depth: Column) -> tuple[Column, Column]:
        """Return h₁ and h₂ of their sum, m.

        In proportion to k₁ and ν·k₂; where volume is conserved, by k₂·h₁(2r₁ − h₁) = k₁·h₂(2r₂ − h₂).
        """
        _, _, curved, flat, _, _ = self.discs.inputs
        share = self.share
        if self.discs.distance == "volume-conserving":
            linear = 2 * (curved * (1 - share) + share * (flat - depth))
            constant = share * depth * (2 * flat - depth)
            first = 2 * constant / (linear + np.sqrt(linear**2 + 4 * (2 * share - 1) * constant))
        else:
            first = depth * share / (share + (1 - share) * self.discs.rotation_ratio)
        return first, depth - first

    def _mobilities(self, contact: _Contact) -> tuple[Column, Column]:
        """Return how easily the curved disc recedes, and both together, were k₁ + k₂ one."""
        if self.discs.distance != "volume-conserving":
            return self.share, self.share + (1 - self.share) * self.discs.rotation_ratio
        _, _, curved, flat, _, _ = self.discs.inputs
        mine = self.share / (curved - contact.curved_depth)
        return mine, mine + (1 - self.share) / (flat - contact.flat_depth)

    def curved_part(self, contact: _Contact) -> Column:
        """Return dh₁/d(h₁ + h₂)."""
        mine, both = self._mobilities(contact)
        return np.asarray(mine / both)

    def rate(self, contact: _Contact) -> Column:
        """Return d(h₁ + h₂)/dN over k₁ + k₂, N/m; 0 where the discs no longer slip as they did at the start."""
        load, *_, slip = self.discs.inputs
        _, both = self._mobilities(contact)
        line_load = load / (2 * contact.half_width)
        if self.discs.distance == "contact-width":
            return np.asarray(KAPPA * line_load * both)
        slid = np.maximum(self.slip_distance(contact) * np.sign(slip), 0.0)
        if self.discs.distance == "full-slip":
            return np.asarray(self.pressure(contact) * slid * both)
        return np.asarray(line_load * slid / (2 * np.pi) * both)

    def recession(self, contact: _Contact, part: Column) -> Column:
        """Return d(h₁ + h₂)/d ln c, m, from h₁ + h₂ = c − u."""
        _, crown, curved, flat, _, _ = self.discs.inputs
        sharpening = part / (curved - contact.curved_depth) ** 2 + (1 - part) / (flat - contact.flat_depth) ** 2
        widening = (crown - contact.height) / (2 * crown - contact.height)
        quarter = contact.elastic / 4
        return np.asarray((contact.height + quarter * widening) / (1 + quarter * contact.equivalent * sharpening))

    def slip_distance(self, contact: _Contact) -> Column:
        """Return 2π·(ν·(r₂ − h₂) − (r₁ − h₁)), m, with its sign."""
        _, _, curved, _, _, slip = self.discs.inputs
        lost = contact.curved_depth - self.discs.rotation_ratio * contact.flat_depth
        return np.asarray(2 * np.pi * (slip * curved + lost))

    def half_length(self, contact: _Contact) -> Column:
        """Return a_z of Eq. 12 and 15, m."""
        load, _, _, _, modulus, _ = self.discs.inputs
        line_load = load / (2 * contact.half_width)
        return np.asarray(KAPPA * np.sqrt(4 * line_load * contact.equivalent / (np.pi * modulus)))

    def pressure(self, contact: _Contact) -> Column:
        """Return p of Eq. 13 and 16, Pa."""
        load, _, _, _, modulus, _ = self.discs.inputs
        line_load = load / (2 * contact.half_width)
        return np.asarray(np.pi / 4 * np.sqrt(line_load * modulus / (np.pi * contact.equivalent)))
