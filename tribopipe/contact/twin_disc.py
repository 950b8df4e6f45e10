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
from functools import cache, cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tribopipe.contact.mechanics import contact_modulus
from tribopipe.errors import ContactError
from tribopipe.geometry import cap_height
from tribopipe.motion import slip
from tribopipe.records.manifest import RunManifest, TwinDisc
from tribopipe.records.recipe import DistanceConvention
from tribopipe.run import Column, Values
from tribopipe.units import show

KAPPA = np.pi / 4
"""κ of Eq. 12 and 15."""
_MOST_ITERATIONS = 60
_CONVERGED = 1e-13
_LAST_STEP = 1e-9
"""Relative Newton step after which the next one, by quadratic convergence, is below the last digit."""
_LONGEST = 34.0
"""e-folds of the slip left, after which double precision tells no more of it."""
_NEARLY_ALL = 1 - 1e-15
"""Share of the way to the end of slip, beyond which double precision does not tell it from the end."""
_INPUTS = (
    ("load", "N", 0.0),
    ("crown radius", "m", 0.0),
    ("curved disc's radius", "m", 0.0),
    ("flat disc's radius", "m", 0.0),
    ("modulus", "Pa", 0.0),
    ("slip", "1", -1.0),
)
"""Name, unit and bound of each argument."""
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
    curved_rate: Column
    """dh₁/dN, m."""
    flat_rate: Column
    """dh₂/dN, m."""


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
    area: Column
    """Cross-section lost by both discs, m²."""
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
        for (name, unit, least), value in zip(_INPUTS, self.inputs, strict=True):
            if not np.all((value > least) & np.isfinite(value)):
                raise ContactError(
                    f"contact: found a {name} of {show(float(np.min(value)), None, unit)}; expected more than "
                    f"{least:g}, or the discs do not touch and roll; check load, radii, moduli and slip"
                )
        load, crown, *_ = self.inputs
        if not np.all(self.start_height < self.largest_height):
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

    @property
    def largest_height(self) -> Column:
        """Height c beyond which nothing is left of the crown, or of a disc, m."""
        _, crown, curved, flat, _, _ = self.inputs
        return np.minimum(crown, np.minimum(curved, flat))

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
        total, course = self._course(curved_coefficient, flat_coefficient)
        if not np.all(turns >= 0):
            raise ContactError(
                f"contact: found {float(np.min(turns)):.4g} rotations; expected zero or more; check their number"
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

    def rotations(
        self, curved_depth: ArrayLike, curved_coefficient: ArrayLike, flat_coefficient: ArrayLike = 0.0
    ) -> Column:
        """Return the rotations of the curved disc after which it has worn by a depth, m; infinite where it never has.

        Raises ``ContactError`` where the crown would be worn away before that.
        """
        total, course = self._course(curved_coefficient, flat_coefficient)
        wears = (np.asarray(curved_coefficient) > 0) & (np.asarray(self.slip) != 0)
        depth = np.asarray(curved_depth, dtype=float)
        reached = wears & (depth < course.contact(course.end_growth).curved_depth)
        if np.any(wears & ~reached & ~course.slip_ends):
            raise _beyond(self.largest_height)
        turns = course.sums(course.growth_of_curved_depth(np.where(reached, depth, 0.0))).turns
        return np.where(reached, np.divide(turns, total, out=np.zeros(np.shape(turns)), where=total > 0), np.inf)

    def depth_of_area(self, area: ArrayLike) -> Column:
        """Return h₁ + h₂, m, where the discs have lost a cross-section A₁ + A₂ = ∫2a·dh, m²."""
        course = _Course(self, np.asarray(1.0), np.asarray(0.0))
        return self._depth(course, course.growth_of_area(np.asarray(area, dtype=float)))

    def depth_of_width(self, width: ArrayLike) -> Column:
        """Return h₁ + h₂, m, where the worn track is 2a wide, m; 0 where the elastic contact alone is wider."""
        half, crown = np.asarray(width, dtype=float) / 2, np.asarray(self.crown_radius, dtype=float)
        growth = cap_height(scar_radius=half, sphere_radius=crown) - self.start_height
        return self._depth(_Course(self, np.asarray(1.0), np.asarray(0.0)), np.maximum(growth, 0.0))

    def _depth(self, course: "_Course", growth: Column) -> Column:
        contact = course.contact(growth)
        return np.asarray(contact.curved_depth + contact.flat_depth)

    def _course(self, curved_coefficient: ArrayLike, flat_coefficient: ArrayLike) -> "tuple[Column, _Course]":
        """Return k₁ + k₂ and the course of wear for their shares; all of it the first's where nothing wears."""
        first, second = np.broadcast_arrays(
            np.asarray(curved_coefficient, dtype=float), np.asarray(flat_coefficient, dtype=float)
        )
        total = first + second
        if not np.all((first >= 0) & (second >= 0) & np.isfinite(total)):
            raise ContactError(
                f"contact: found a wear coefficient of {float(np.min([first, second])):.4g} m²/N; expected zero or "
                "more; check both"
            )
        mine = np.divide(first, total, out=np.ones(np.shape(total)), where=total > 0)
        other = np.divide(second, total, out=np.zeros(np.shape(total)), where=total > 0)
        return total, _Course(self, mine, other)


@dataclass(frozen=True)
class _Course:
    """What two discs go through as c grows, which depends on k₁ and k₂ only by their shares of the sum.

    Where the disc wears more that is faster, slip comes to an end at some x₀ = ln(c/c*), and wear with it but for
    *contact-width*. The rate then goes to zero there, so that integrals are taken over v of x = x₀(1 − exp(−v/x₀)).
    """

    discs: DiscPair
    curved_share: Column
    flat_share: Column

    @cached_property
    def _slipless_growth(self) -> Column:
        """Growth of c at which the discs no longer slip; infinite where they always do.

        There ν(r₂ − h₂) = r₁ − h₁. With h₁ and h₂ in proportion that is linear; where volume is conserved it leaves
        h₂² − 2r₂h₂ = r₁²·s(2 + s)·(k₂/k)/(k₁/k − ν²·k₂/k).
        """
        _, _, curved, flat, _, slip = self.discs.inputs
        ratio = self.discs.rotation_ratio
        with np.errstate(divide="ignore", invalid="ignore"):
            if self.discs.distance == "volume-conserving":
                square = (
                    curved**2 * slip * (2 + slip) * self.flat_share / (self.curved_share - ratio**2 * self.flat_share)
                )
                second = -square / (flat + np.sqrt(flat**2 + square))
                first = ratio * second - slip * curved
                # k₂ = 0 leaves h₁ alone: −slip·r₁.
                first = np.where(self.flat_share > 0, first, -slip * curved)
                second = np.where(self.flat_share > 0, second, 0.0)
            else:
                mine, other = self._proportions
                depth = -slip * curved / (mine - ratio * other)
                first, second = mine * depth, other * depth
            growth = self._growth_of_depths(first, second)
        sound = (first >= 0) & (second >= 0) & (first + second > 0) & (growth < self._crown_growth)
        return np.where(sound, growth, np.inf)

    @property
    def _proportions(self) -> tuple[Column, Column]:
        """h₁ and h₂ over their sum, where that is constant."""
        other = self.flat_share * self.discs.rotation_ratio
        return self.curved_share / (self.curved_share + other), other / (self.curved_share + other)

    def _growth_of_depths(self, first: Column, second: Column) -> Column:
        """Return the growth of c at which the discs have worn by h₁ and h₂, m."""
        start, growth = self.discs.start_height, first + second
        sharpened = self._sharpened(first, second)
        for _ in range(_MOST_ITERATIONS):
            before, growth = growth, first + second + start * np.expm1((sharpened - self._widened(growth)) / 4)
            if not np.any(np.abs(growth - before) > _CONVERGED * np.abs(growth)):
                break
        return np.asarray(growth)

    @property
    def _crown_growth(self) -> Column:
        """Growth at which nothing is left of the crown."""
        return np.asarray(self.discs.largest_height - self.discs.start_height)

    @property
    def slip_ends(self) -> NDArray[np.bool_]:
        """Whether wear ends with the slip, before the crown does."""
        lasting = self.discs.distance == "contact-width"
        return np.asarray(np.isfinite(self._slipless_growth) & (not lasting))

    @property
    def end_growth(self) -> Column:
        """Growth of c at which wear ends."""
        return np.where(self.slip_ends, self._slipless_growth, self._crown_growth)

    def growth_of_turns(self, target: Column) -> Column:
        """Return the growth of c at which (k₁ + k₂)·N has some value, m²/N."""

        def reached(growth: Column) -> tuple[Column, Column]:
            contact = self.contact(growth)
            part = self.curved_part(contact)
            with np.errstate(divide="ignore"):
                slope = self.recession(contact, part) / contact.height / self.rate(contact)
            return self.sums(growth).turns, slope

        return self._growth(target, reached)

    def growth_of_area(self, target: Column) -> Column:
        """Return the growth of c at which both discs have lost a cross-section, m²."""

        def reached(growth: Column) -> tuple[Column, Column]:
            contact = self.contact(growth)
            across = 2 * contact.half_width * self.recession(contact, self.curved_part(contact))
            return self.sums(growth).area, across / contact.height

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

        By Newton's method on its logarithm against that of w, within a bracket. w is the growth g; where wear ends with
        the slip it is −g₀·ln(1 − g/g₀), which goes on with the rotations there. ``reached`` gives value and slope.
        """
        positive, end = target > 0, self.end_growth + 0 * target
        most = np.where(self.slip_ends, _LONGEST * end, end)

        def growth_at(place: Column) -> Column:
            return np.where(self.slip_ends, -end * np.expm1(-place / end), place)

        _, slope = reached(np.zeros(np.shape(most)))
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            place = np.where(positive, np.minimum(target / slope, most), 0.0)
            low, high = np.zeros(np.shape(place)), most
            for _ in range(_MOST_ITERATIONS):
                value, slope = reached(growth_at(place))
                slope = slope * np.where(self.slip_ends, np.exp(-place / end), 1.0)
                short = value < target
                low, high = np.where(short, place, low), np.where(short, high, place)
                step = np.log(value / target) * value / (slope * place)
                moved = place * np.exp(-step)
                found = np.abs(step) <= _LAST_STEP
                moved = np.where((moved > low) & (moved < high), moved, np.where(found, place, (low + high) / 2))
                moved = np.where(positive, moved, 0.0)
                settled = found | (np.abs(moved - place) <= _CONVERGED * place)
                place = moved
                if np.all(settled):
                    break
        if np.any(positive & (place >= most * (1 - 1e-12)) & ~self.slip_ends):
            raise _beyond(self.discs.largest_height)
        return growth_at(place)

    def sums(self, growth: Column) -> _Sums:
        """Integrate over ln c from the start to c* + growth."""
        signed = self._integrals(growth)
        if self.discs.distance != "contact-width" or not np.any(beyond := growth > self._slipless_growth):
            return signed
        # Past the place without slip the discs slip the other way round.
        until = self._integrals(np.where(beyond, self._slipless_growth, 0.0)).slid
        return signed._replace(slid=np.where(beyond, 2 * until - signed.slid, signed.slid))

    def _integrals(self, growth: Column) -> _Sums:
        span = np.log1p(growth / self.discs.start_height)
        end = np.log1p(np.where(self.slip_ends, self._slipless_growth, np.inf) / self.discs.start_height)
        with np.errstate(invalid="ignore"):
            bounded = np.isfinite(end)
            stretched = np.where(bounded, -end * np.log1p(-np.minimum(span / end, _NEARLY_ALL)), span)
            folds = span + np.where(bounded, stretched / end, 0.0)
        count = _FEWEST_NODES + int(np.ceil(_NODES_PER_E_FOLD * float(np.max(folds, initial=0.0))))
        nodes, weights = _gauss_legendre(count)
        course = _Course(self.discs.with_axis(), self.curved_share[..., None], self.flat_share[..., None])
        at, end = stretched[..., None] * (nodes + 1) / 2, end[..., None]
        with np.errstate(invalid="ignore"):
            place = np.where(np.isfinite(end), -end * np.expm1(-at / end), at)
        contact = course.contact(course.discs.start_height * np.expm1(place))
        part = course.curved_part(contact)
        recession = course.recession(contact, part) * np.exp(-at / end) * stretched[..., None] / 2
        with np.errstate(divide="ignore", invalid="ignore"):
            turns = np.where(at > 0, recession / course.rate(contact), 0.0)
        _, _, curved, flat, _, slip = course.discs.inputs
        across = 4 * np.pi * contact.half_width * recession
        return _Sums(
            turns=turns @ weights,
            area=(2 * contact.half_width * recession) @ weights,
            curved_volume=((curved - contact.curved_depth) * part * across) @ weights,
            flat_volume=((flat - contact.flat_depth) * (1 - part) * across) @ weights,
            slid=(course.slip_distance(contact) * np.sign(slip) * turns) @ weights,
        )

    def contact(self, growth: Column) -> _Contact:
        """Return the contact where c = c* + growth."""
        crown, start = np.asarray(self.discs.crown_radius, dtype=float), self.discs.start_height
        height, widened = start + growth, self._widened(growth)
        depth = growth - start * np.expm1(-widened / 4)
        for _ in range(_MOST_ITERATIONS):  # r_eq falls with the depth, by so little that two rounds will do
            first, second = self._split(depth)
            sharpened = self._sharpened(first, second)
            before, depth = depth, growth - start * np.expm1((sharpened - widened) / 4)
            if np.all(np.abs(depth - before) <= _CONVERGED * depth):
                break
        return _Contact(
            height=height,
            half_width=np.sqrt(height * (2 * crown - height)),
            curved_depth=first,
            flat_depth=second,
            elastic=start * np.exp((sharpened - widened) / 4),
            equivalent=self.discs.start_equivalent * np.exp(-sharpened),
        )

    def _widened(self, growth: Column) -> Column:
        """Return ln(a/a*)."""
        crown, start = np.asarray(self.discs.crown_radius, dtype=float), self.discs.start_height
        return np.asarray((np.log1p(growth / start) + np.log1p(-growth / (2 * crown - start))) / 2)

    def _sharpened(self, first: Column, second: Column) -> Column:
        """Return ln of the unworn r_eq over that of discs worn by h₁ and h₂."""
        _, _, curved, flat, _, _ = self.discs.inputs
        lost = first / (curved * (curved - first)) + second / (flat * (flat - second))
        return np.asarray(np.log1p(self.discs.start_equivalent * lost))

    def _split(self, depth: Column) -> tuple[Column, Column]:
        """Return h₁ and h₂ of their sum, m.

        In proportion to k₁ and ν·k₂; where volume is conserved, by k₂·h₁(2r₁ − h₁) = k₁·h₂(2r₂ − h₂).
        """
        _, _, curved, flat, _, _ = self.discs.inputs
        mine, other = self.curved_share, self.flat_share
        if self.discs.distance == "volume-conserving":
            return _part(depth, mine, other, curved, flat), _part(depth, other, mine, flat, curved)
        mine, other = self._proportions
        return np.asarray(depth * mine), np.asarray(depth * other)

    def _mobilities(self, contact: _Contact) -> tuple[Column, Column]:
        """Return how easily the curved disc recedes, and both together, were k₁ + k₂ one."""
        if self.discs.distance != "volume-conserving":
            return self.curved_share, self.curved_share + self.flat_share * self.discs.rotation_ratio
        _, _, curved, flat, _, _ = self.discs.inputs
        mine = self.curved_share / (curved - contact.curved_depth)
        return mine, mine + self.flat_share / (flat - contact.flat_depth)

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


@cache
def _gauss_legendre(count: int) -> tuple[Column, Column]:
    """Return nodes between −1 and 1, and their weights."""
    return np.polynomial.legendre.leggauss(count)


def _part(depth: Column, mine: Column, other: Column, radius: Column, other_radius: Column) -> Column:
    """Return one disc's h of the sum of both by other·h(2r − h) = mine·h'(2r' − h'), as a quadratic without loss."""
    linear = 2 * (radius * other + mine * (other_radius - depth))
    constant = mine * depth * (2 * other_radius - depth)
    return np.asarray(2 * constant / (linear + np.sqrt(linear**2 + 4 * (mine - other) * constant)))


def _beyond(height: Column) -> ContactError:
    return ContactError(
        f"contact: found wear beyond {show(float(np.min(height)), None, 'm', 'mm')}, where nothing is left of the "
        "crown; expected the worn flat within the crown; check wear coefficients, load and rotations"
    )


def disc_pair(contact: TwinDisc, values: Values, distance: DistanceConvention) -> DiscPair:
    """Build two discs from values of ``nominal_values``' names."""
    curved, flat = contact.curved_disc, contact.flat_disc
    modulus = contact_modulus(
        pin_modulus=values["curved_modulus"],
        pin_ratio=curved.poisson_ratio.value,
        disc_modulus=values["flat_modulus"],
        disc_ratio=flat.poisson_ratio.value,
    )
    return DiscPair(
        normal_load=values["normal_load"],
        crown_radius=values["crown_radius"],
        curved_radius=values["curved_radius"],
        flat_radius=values["flat_radius"],
        modulus=modulus,
        slip=values["slip"],
        distance=distance,
    )


def nominal_values(manifest: RunManifest) -> dict[str, float]:
    """Return what run.toml says of two discs, SI."""
    discs = manifest.twin_disc
    return {
        "normal_load": manifest.conditions.normal_load.value,
        "crown_radius": discs.curved_disc.crown_radius.value,
        "curved_radius": discs.curved_disc.rolling_radius.value,
        "flat_radius": discs.flat_disc.rolling_radius.value,
        "curved_modulus": discs.curved_disc.youngs_modulus.value,
        "flat_modulus": discs.flat_disc.youngs_modulus.value,
        "slip": slip(manifest).value,
    }
