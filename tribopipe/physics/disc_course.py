"""What two discs go through as they wear, against the height c of the crown that is cut off.

h₁ : h₂ follows from the sum h₁ + h₂ in closed form, and the state from c (tribopipe.physics.twin_disc has the
equations). Rotations, volumes and the sliding distance are integrals over ln c, taken by Gauss and Legendre's rule to
the last digits and inverted by Newton's method.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tribopipe.base.arrays import Column
from tribopipe.base.errors import ContactError
from tribopipe.base.units import show
from tribopipe.physics.disc_contact import Discs

_MOST_ITERATIONS = 60
_CONVERGED = 1e-13
_LAST_STEP = 1e-9
"""Relative Newton step after which the next one, by quadratic convergence, is below the last digit."""
_LONGEST = 34.0
"""e-folds of the slip left, after which double precision does not resolve it."""
_NEARLY_ALL = 1 - 1e-15
"""Share of the way to the end of slip, beyond which double precision does not distinguish it from the end."""


class Rule(NamedTuple):
    """How many nodes an integral over ln c is taken with."""

    fewest: int
    per_e_fold: float


LAST_DIGITS = Rule(8, 2.0)
"""Enough that more of them change nothing in the last digits (tests/test_twin_disc.py)."""
NINE_DIGITS = Rule(7, 0.6)
"""Enough for 1e-9 (tests/test_disc_draws.py)."""


class Contact(NamedTuple):
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


class Sums(NamedTuple):
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
class Course:
    """What two discs go through as c grows, which depends on k₁ and k₂ only by their shares of the sum.

    Where the disc wears more that is faster, slip comes to an end at some x₀ = ln(c/c*), and wear with it but for
    *contact-width*. The rate then goes to zero there, so that integrals are taken over v of x = x₀(1 − exp(−v/x₀)).
    """

    discs: Discs
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
        return np.asarray(np.isfinite(self._slipless_growth) & self.discs.slip_counts)

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
            raise beyond(self.discs.largest_height)
        return growth_at(place)

    def sums(self, growth: Column) -> Sums:
        """Integrate over ln c from the start to c* + growth."""
        signed = self._integrals(growth)
        if self.discs.slip_counts or not np.any(beyond := growth > self._slipless_growth):
            return signed
        # Past the place without slip the discs slip the other way round.
        until = self._integrals(np.where(beyond, self._slipless_growth, 0.0)).slid
        return signed._replace(slid=np.where(beyond, 2 * until - signed.slid, signed.slid))

    def _integrals(self, growth: Column) -> Sums:
        nodes = self._nodes(growth, LAST_DIGITS)
        slip = nodes.course.discs.inputs[-1]
        with np.errstate(invalid="ignore"):
            slid = nodes.course.slip_distance(nodes.contact) * np.sign(slip) * nodes.turns
        return Sums(
            turns=nodes.turns @ nodes.weights,
            area=(2 * nodes.contact.half_width * nodes.recession) @ nodes.weights,
            curved_volume=nodes.curved_volume() @ nodes.weights,
            flat_volume=nodes.flat_volume() @ nodes.weights,
            slid=slid @ nodes.weights,
        )

    def turns_and_volumes(self, growth: Column) -> tuple[Column, Column, Column]:
        """Integrate (k₁ + k₂)·N, m²/N, V₁ and V₂, m³, alone: to fewer digits and with less work than ``sums``."""
        nodes = self._nodes(growth, NINE_DIGITS)
        parts = (nodes.turns, nodes.curved_volume(), nodes.flat_volume())
        turns, curved, flat = (part @ nodes.weights for part in parts)
        return turns, curved, flat

    def _nodes(self, growth: Column, rule: Rule) -> "_Nodes":
        """Return the contact at the nodes of an integral over ln c from the start to c* + growth."""
        span = np.log1p(growth / self.discs.start_height)
        end = np.log1p(np.where(self.slip_ends, self._slipless_growth, np.inf) / self.discs.start_height)
        with np.errstate(invalid="ignore"):
            bounded = np.isfinite(end)
            stretched = np.where(bounded, -end * np.log1p(-np.minimum(span / end, _NEARLY_ALL)), span)
            folds = span + np.where(bounded, stretched / end, 0.0)
        count = rule.fewest + int(np.ceil(rule.per_e_fold * float(np.max(folds, initial=0.0))))
        nodes, weights = _gauss_legendre(count)
        course = Course(self.discs.with_axis(), self.curved_share[..., None], self.flat_share[..., None])
        at, end = stretched[..., None] * (nodes + 1) / 2, end[..., None]
        if np.any(bounded):
            with np.errstate(invalid="ignore"):
                place = np.where(np.isfinite(end), -end * np.expm1(-at / end), at)
            step = np.exp(-at / end) * stretched[..., None] / 2
        else:
            place, step = at, stretched[..., None] / 2
        contact = course.contact(course.discs.start_height * np.expm1(place))
        part = course.curved_part(contact)
        recession = course.recession(contact, part) * step
        with np.errstate(divide="ignore", invalid="ignore"):
            turns = np.where(at > 0, recession / course.rate(contact), 0.0)
        return _Nodes(course, contact, part, recession, turns, weights)

    def contact(self, growth: Column) -> Contact:
        """Return the contact where c = c* + growth."""
        crown, start = np.asarray(self.discs.crown_radius, dtype=float), self.discs.start_height
        height, widened = start + growth, self._widened(growth)
        depth, change = growth - start * np.expm1(-widened / 4), np.zeros(())
        for _ in range(_MOST_ITERATIONS):  # r_eq falls with the depth, by so little that two rounds will do
            first, second = self._split(depth)
            sharpened = self._sharpened(first, second)
            before, depth = depth, growth - start * np.expm1((sharpened - widened) / 4)
            # The next round would change it by as much less again.
            earlier, change = change, np.abs(depth - before)
            if np.all((change**2 <= _CONVERGED * depth * earlier) | (change <= _CONVERGED * depth)):
                break
        first, second = self._split(depth)
        return Contact(
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

    def _mobilities(self, contact: Contact) -> tuple[Column, Column]:
        """Return how easily the crowned disc recedes, and both together, were k₁ + k₂ one."""
        if self.discs.distance != "volume-conserving":
            return self.curved_share, self.curved_share + self.flat_share * self.discs.rotation_ratio
        _, _, curved, flat, _, _ = self.discs.inputs
        mine = self.curved_share / (curved - contact.curved_depth)
        return mine, mine + self.flat_share / (flat - contact.flat_depth)

    def curved_part(self, contact: Contact) -> Column:
        """Return dh₁/d(h₁ + h₂)."""
        mine, both = self._mobilities(contact)
        return np.asarray(mine / both)

    def rate(self, contact: Contact) -> Column:
        """Return d(h₁ + h₂)/dN over k₁ + k₂, N/m; 0 where the discs no longer slip as they did at the start."""
        load, *_, slip = self.discs.inputs
        _, both = self._mobilities(contact)
        line_load = load / (2 * contact.half_width)
        if not self.discs.slip_counts:
            return np.asarray(self.discs.kappa * line_load * both)
        slid = np.maximum(self.slip_distance(contact) * np.sign(slip), 0.0)
        if self.discs.distance == "full-slip":
            return np.asarray(self.pressure(contact) * slid * both)
        return np.asarray(line_load * slid / (2 * np.pi) * both)

    def recession(self, contact: Contact, part: Column) -> Column:
        """Return d(h₁ + h₂)/d ln c, m, from h₁ + h₂ = c − u."""
        _, crown, curved, flat, _, _ = self.discs.inputs
        sharpening = part / (curved - contact.curved_depth) ** 2 + (1 - part) / (flat - contact.flat_depth) ** 2
        widening = (crown - contact.height) / (2 * crown - contact.height)
        quarter = contact.elastic / 4
        return np.asarray((contact.height + quarter * widening) / (1 + quarter * contact.equivalent * sharpening))

    def slip_distance(self, contact: Contact) -> Column:
        """Return 2π·(ν·(r₂ − h₂) − (r₁ − h₁)), m, with its sign."""
        _, _, curved, _, _, slip = self.discs.inputs
        lost = contact.curved_depth - self.discs.rotation_ratio * contact.flat_depth
        return np.asarray(2 * np.pi * (slip * curved + lost))

    def half_length(self, contact: Contact) -> Column:
        """Return a_z of Eq. 12 and 15, m."""
        load, _, _, _, modulus, _ = self.discs.inputs
        line_load = load / (2 * contact.half_width)
        return np.asarray(self.discs.kappa * np.sqrt(4 * line_load * contact.equivalent / (np.pi * modulus)))

    def pressure(self, contact: Contact) -> Column:
        """Return p of Eq. 13 and 16, Pa."""
        load, _, _, _, modulus, _ = self.discs.inputs
        line_load = load / (2 * contact.half_width)
        return np.asarray(np.pi / 4 * np.sqrt(line_load * modulus / (np.pi * contact.equivalent)))


class _Nodes(NamedTuple):
    """The contact at the nodes of an integral over ln c, with what comes together at each for its weight."""

    course: Course
    contact: Contact
    part: Column
    recession: Column
    turns: Column
    weights: Column

    def curved_volume(self) -> Column:
        """Return what the crowned disc loses, m³."""
        radius = self.course.discs.inputs[2] - self.contact.curved_depth
        return np.asarray(4 * np.pi * radius * self.contact.half_width * self.recession * self.part)

    def flat_volume(self) -> Column:
        """Return what the cylindrical disc loses, m³."""
        radius = self.course.discs.inputs[3] - self.contact.flat_depth
        return np.asarray(4 * np.pi * radius * self.contact.half_width * self.recession * (1 - self.part))


@cache
def _gauss_legendre(count: int) -> tuple[Column, Column]:
    """Return nodes between −1 and 1, and their weights."""
    return np.polynomial.legendre.leggauss(count)


def _part(depth: Column, mine: Column, other: Column, radius: Column, other_radius: Column) -> Column:
    """Return one disc's h of the sum of both by other·h(2r − h) = mine·h'(2r' − h'), as a quadratic without loss."""
    linear = 2 * (radius * other + mine * (other_radius - depth))
    constant = mine * depth * (2 * other_radius - depth)
    return np.asarray(2 * constant / (linear + np.sqrt(linear**2 + 4 * (mine - other) * constant)))


def beyond(height: Column) -> ContactError:
    """Return the error for wear beyond a height of the crown, m."""
    return ContactError(
        f"contact: found a wear depth of more than {show(float(np.min(height)), None, 'm', 'mm')}, at which the "
        "crown is completely worn away; expected less wear; check wear coefficients, load and rotations"
    )
