"""UMESHMOTION's economy: contact is not solved again as the surface wears, but corrected (paper, Sections 3.3 and 3.4).

ABAQUS calls UMESHMOTION once an increment has converged, sweeps the surface nodes by the wear of Eq. 9, carries the
stresses over to the moved mesh by advection, and corrects the loss of equilibrium by solving the last time increment
only.
The Wear-Processor solves the whole contact on the moved mesh after every increment. Fig. 11 asks how far the one drifts
from the other, and how external corrections of the geometry bring it back.

Modeled is what the paper shows of that scheme:

* Explicit wear by the pressure before the increment.
* One linear correction of equilibrium, with the elasticity of the mesh as last corrected and the contact status of the
  increment before: what touched goes on touching. Nodes that then pull leave the contact and nodes that overlap join
  it, but for the next increment only; there is no second round. A pull counts as no pressure, and the other nodes bear
  the load, so that volume is k_D·F_N·s here too.
* After every so many increments an external correction: the mesh is moved as the surface has worn, its elasticity
  computed again and the contact solved fully. After every single one, that is the Wear-Processor.

So much alone hardly drifts: contact status is one increment late, and the worn shape is nearly as compliant as the
unworn one. Not modeled is ABAQUS' advection, a Lax-Wendroff scheme, whose errors stay in the body until the next
correction. What such errors do can be asked, though: where each increment loses a share ε of the stresses it carries
over, the body keeps that share of its elastic displacement u for good, like one that creeps,

    gap + worn + crept + u(p) − approach ≥ 0,    crept ← crept + ε·u(p),    crept ← 0 in a correction.

It conforms to the flat, so that the pressure falls below the Wear-Processor's and rises at once with a correction, as
in Fig. 11. Which ε would be ABAQUS' is not known. Friction, which the paper's law of wear has not, is left out too.
"""

from collections.abc import Iterator, Sequence
from typing import NamedTuple, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from tribopipe.base.arrays import Column
from tribopipe.base.errors import ContactError
from tribopipe.physics.local.contact_solvers import Contact, Surface, touching_at
from tribopipe.physics.local.course import LocalWear, WornState, collected, smooth

_MOST_INCREMENTS = 200_000


@runtime_checkable
class Elastic(Surface, Protocol):
    """A surface whose compliance is a matrix, such as one by finite elements."""

    @property
    def normal_load(self) -> float:
        """N."""
        ...

    @property
    def compliance(self) -> Column:
        """Displacement of each point by unit pressure at each, m/Pa."""
        ...


class _State(NamedTuple):
    surface: Elastic
    worn: Column
    contact: Contact
    touching: NDArray[np.bool_]
    crept: Column


def wear_economically(
    surface: Elastic,
    amounts: Sequence[float] | Column,
    *,
    increment: float,
    correct_every: int | None = None,
    stress_loss: float = 0.0,
) -> LocalWear:
    """Return the surface at each of the increasing amounts of wear, and before any, by increments of so much.

    ``stress_loss`` is ε, the share of its stresses that an increment loses as it carries them over. Raises
    ``ContactError`` where an increment is too long to be stable or increments are too many, a full contact is not
    found, or the mesh is turned inside out.
    """
    asked = np.asarray(amounts, dtype=float)
    _check(asked[-1], increment, correct_every, stress_loss)
    return collected(surface, list(_course(surface, asked, increment, correct_every, stress_loss)))


def _course(
    surface: Elastic, ends: Column, increment: float, correct_every: int | None, stress_loss: float
) -> Iterator[WornState]:
    unworn = np.zeros_like(surface.gap)
    contact = surface.press(unworn)
    state = _State(surface, unworn, contact, contact.pressure > 0, unworn)
    yield WornState(0.0, state.worn, contact)
    before, taken = 0.0, 0
    for end in ends:
        while before < end:
            step = min(increment, end - before)
            worn = state.worn + _stable(step, state) * state.surface.exposure(state.contact.pressure)
            taken += 1
            corrected = correct_every is not None and taken % correct_every == 0
            state = _corrected(state, worn) if corrected else _mended(state, worn, stress_loss)
            before = end if step == end - before else before + step
        yield WornState(float(end), state.worn, state.contact)


def _corrected(state: _State, worn: Column) -> _State:
    """Move the mesh and solve the contact."""
    surface = state.surface.refreshed(worn)
    contact = smooth(surface, surface.press(worn, start=state.contact))
    return _State(surface, worn, contact, contact.pressure > 0, np.zeros_like(worn))


def _mended(state: _State, worn: Column, stress_loss: float) -> _State:
    """Correct equilibrium by one linear solution."""
    surface, at = state.surface, np.flatnonzero(state.touching)
    compliance, gap, areas = surface.compliance, (surface.gap + worn + state.crept).ravel(), surface.areas.ravel()
    pressure = np.zeros_like(gap)
    pressure[at], approach = touching_at(at, compliance, gap, areas, surface.normal_load)
    left = gap + compliance @ pressure - approach
    touching = np.where(state.touching.ravel(), pressure > 0, left < 0).reshape(worn.shape)
    pressure = np.maximum(pressure, 0.0)
    pressure *= surface.normal_load / (areas @ pressure)
    contact = Contact(pressure.reshape(worn.shape), approach)
    crept = state.crept + stress_loss * (compliance @ pressure).reshape(worn.shape)
    return _State(surface, worn, smooth(surface, contact), touching, crept)


def _check(end: float, increment: float, correct_every: int | None, stress_loss: float) -> None:
    """Raise ``ContactError`` where increments would not come to an end, or make no sense."""
    if not increment * _MOST_INCREMENTS >= end:
        raise ContactError(
            f"local wear: found increments of {increment:.3g} for a total amount of wear of {end:.3g}; expected at "
            f"most {_MOST_INCREMENTS:,} increments; use larger increments"
        )
    if correct_every is not None and correct_every < 1:
        raise ContactError(
            f"local wear: found an interval of {correct_every} increments between corrections; expected at least 1 "
            "increment; omit this option to make no corrections"
        )
    if not 0 <= stress_loss < 1:
        raise ContactError(
            f"local wear: found a stress loss of {stress_loss:g}; expected a fraction from 0 to less than 1; omit "
            "this option to keep all stresses"
        )


def _stable(step: float, state: _State) -> float:
    """Return the step. Raises ``ContactError`` where it is so long that pressure would become a checkerboard."""
    limit = state.surface.stable_amount(state.contact)
    if step > limit:
        raise ContactError(
            f"local wear: found an increment of {step:.3g} in the amount of wear; expected at most {limit:.3g} (SI "
            "units), since a larger increment causes a checkerboard pattern in the pressure on this mesh; use "
            "smaller increments"
        )
    return step
