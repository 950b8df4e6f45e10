"""How a surface wears: Archard's law in steps of the amount of wear, implicit by default, explicit as published.

With the amount of wear q = k_D·S(s) under a pin, k_D·N under a disc (tribopipe.physics.local.contact_solvers),
dw/dq = m(p).
The explicit step of the paper (Eq. 9) takes m of the pressure before the step. It is stable only where it is shorter
than about 4Δx/(πE_c) under a pin: a wave of wear of wavelength 2Δx changes the pressure by πE_c/(2Δx) times its
height, and a step of more than 2 over that overshoots. The implicit step takes m of the pressure after it, within the
solution of the contact, and is stable however long: it is the backward differentiation formula of second order, for a
step Δ that is ρ times the one before

    w₊ = w + ρ²/(1 + 2ρ)·(w − w₋) + Δ·(1 + ρ)/(1 + 2ρ)·m(p₊).

Either way each step removes k_D·F_N·Δs, to the last digits.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.base.errors import ContactError
from tribopipe.physics.calculation_methods import Scheme
from tribopipe.physics.local.contact_solvers import Contact, Surface

STEPS_PER_DECADE = 16
_DECADES = 2.0
"""How far below the first place asked for, in the amount of wear, steps begin."""
_ROUNDING = 1e-9
_FASTEST_GROWTH = 1 + math.sqrt(2)
"""Ratio of steps up to which the second-order formula is stable."""
_SHOWN_LATER = 0.01
"""Share of the wear so far that the step takes whose contact is shown."""
_MOST_EXPLICIT_STEPS = 200_000
_STABLE_SHARE = 0.8
_ROUGH = 0.2
"""Alternation of the pressure above which it is a checkerboard rather than a contact."""


class WornState(NamedTuple):
    """Surface after some amount of wear."""

    amount: float
    worn: Column
    contact: Contact


class Steps(NamedTuple):
    """The steps of a course."""

    ends: Column
    """Amount of wear at the end of each."""
    shown: frozenset[float]
    """Those ends at which the surface is kept."""
    refresh_every: int | None
    """Steps after which elasticity is computed for the worn shape."""


@dataclass(frozen=True)
class LocalWear:
    """The wear of a surface against the amount of wear; fields have one more axis in front."""

    amount: Column
    """k_D·S, m³/N, or k_D·N, m²/N, at each place; the first is 0."""
    depth: Column
    """Wear depth of the deepest point, m."""
    volume: Column
    """m³ of a pin; the cross-section of a disc's track, m²."""
    half_width: Column
    half_length: Column
    peak_pressure: Column
    approach: Column
    places: tuple[Column, ...]
    """Axes of the fields, m."""
    pressure: Column
    worn: Column

    @property
    def middle_pressure(self) -> Column:
        """Contact pressure at the center, Pa."""
        middle = tuple(int(np.argmin(np.abs(axis))) for axis in self.places)
        return np.array([pressure[middle] for pressure in self.pressure])


def wear(
    surface: Surface,
    amounts: Sequence[float] | Column,
    *,
    scheme: Scheme = "implicit",
    steps_per_decade: int = STEPS_PER_DECADE,
    refresh_every: int | None = 1,
) -> LocalWear:
    """Return the surface at each of the increasing amounts of wear, and before any.

    Steps grow geometrically, so many to a decade, from a hundredth of the first amount, and end at each amount asked
    for. Elasticity is computed for the worn shape after every so many steps, where it depends on it; None: never.
    Raises ``ContactError`` where a contact is not found, or where explicit steps would be too many or have made a
    checkerboard of the pressure.
    """
    asked = np.asarray(amounts, dtype=float)
    if not (asked.size and asked[0] > 0 and np.all(np.diff(asked) > 0)):
        raise ContactError(
            "local wear: found positions that are not positive and increasing; expected one or more positive "
            "positions; list them in increasing order"
        )
    course = _implicit if scheme == "implicit" else _explicit
    steps = Steps(step_ends(asked, steps_per_decade), frozenset(asked.tolist()), refresh_every)
    return collected(surface, list(course(surface, steps)))


def step_ends(asked: Column, per_decade: int) -> Column:
    """Return where steps end: geometric from a share of the first place on, and at each place."""
    stretches = pairwise([asked[0] * 10**-_DECADES, *asked])
    ends = [
        np.geomspace(start, end, math.ceil(per_decade * math.log10(end / start) - _ROUNDING) + 1)[1:]
        for start, end in stretches
    ]
    return np.concatenate([[asked[0] * 10**-_DECADES], *ends])


def _implicit(surface: Surface, steps: Steps) -> Iterator[WornState]:
    """Where there is no step before, or a much shorter one, ρ is 0: Euler's backward step.

    Points that have just come into contact bear more than they should for a step to be of second order, which evens
    out within another. So the contact shown is that of a short backward step on from there.
    """
    worn = last = np.zeros_like(surface.gap)
    contact, before = surface.press(worn), 0.0
    yield WornState(0.0, worn, contact)
    for number, (start, end) in enumerate(pairwise([0.0, *steps.ends]), 1):
        step = end - start
        growth = step / before if step < _FASTEST_GROWTH * before else 0.0
        carried = worn + growth**2 / (1 + 2 * growth) * (worn - last)
        amount = step * (1 + growth) / (1 + 2 * growth)
        contact = surface.press(carried, amount, contact)
        worn, last, before = carried + amount * surface.exposure(contact.pressure), worn, step
        if end in steps.shown:
            yield WornState(float(end), worn, surface.press(worn, _SHOWN_LATER * end, contact))
        if steps.refresh_every and number % steps.refresh_every == 0:
            surface = surface.refreshed(worn)


def _explicit(surface: Surface, steps: Steps) -> Iterator[WornState]:
    """As the paper has it, with each step divided into stable ones."""
    worn = np.zeros_like(surface.gap)
    contact, before, taken = surface.press(worn), 0.0, 0
    yield WornState(0.0, worn, contact)
    for number, end in enumerate(steps.ends, 1):
        while before < end:
            longest = _STABLE_SHARE * surface.stable_amount(contact)
            step = min(longest, end - before)
            worn = worn + step * surface.exposure(contact.pressure)
            contact = smooth(surface, surface.press(worn, start=contact))
            before = end if step == end - before else before + step
            taken += 1
            if taken + (steps.ends[-1] - before) / longest > _MOST_EXPLICIT_STEPS:
                raise _too_many(steps.ends[-1], longest)
        if end in steps.shown:
            yield WornState(float(end), worn, contact)
        if steps.refresh_every and number % steps.refresh_every == 0:
            surface = surface.refreshed(worn)


def smooth(surface: Surface, contact: Contact) -> Contact:
    """Return a contact whose pressure is smooth. Raises ``ContactError`` where it is a checkerboard."""
    if (roughness := surface.roughness(contact)) > _ROUGH:
        raise ContactError(
            f"local wear: found a pressure that oscillates by {100 * roughness:.0f} % from point to point; expected a "
            "smooth pressure distribution; explicit steps were too long for this grid: use the implicit scheme"
        )
    return contact


def _too_many(amount: float, step: float) -> ContactError:
    return ContactError(
        f"local wear: found that a stable solution on this grid requires about {amount / step:.2g} explicit steps; "
        f"expected at most {_MOST_EXPLICIT_STEPS}; use the implicit scheme, a coarser grid or a shorter test"
    )


def collected(surface: Surface, states: Sequence[WornState]) -> LocalWear:
    """Return the states of a surface as one course."""
    extents = [surface.extent(state.contact) for state in states]
    pressure = np.stack([state.contact.pressure for state in states])
    worn = np.stack([state.worn for state in states])
    points = tuple(range(1, worn.ndim))
    return LocalWear(
        amount=np.array([state.amount for state in states]),
        depth=worn.max(axis=points),
        volume=np.array([surface.volume(state.worn) for state in states]),
        half_width=np.array([extent.half_width for extent in extents]),
        half_length=np.array([extent.half_length for extent in extents]),
        peak_pressure=pressure.max(axis=points),
        approach=np.array([state.contact.approach for state in states]),
        places=surface.places,
        pressure=pressure,
        worn=worn,
    )
