"""The surface that wears, from what run.toml states about the bodies: which engine solves its contact, on what points.

The contact of a pin grows by orders of magnitude while it wears. So rings and finite elements are a 20th of Hertz's
radius wide at first, and from there on 2.5 % of their own radius, out to beyond the contact of the most worn pin, whose
radius the Global Incremental Wear Model states. A regular grid is as fine everywhere, and so it is coarse for the first
contact of a pin that wears far.
"""

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from tribopipe.base.arrays import Column, Values
from tribopipe.base.errors import ContactError
from tribopipe.contacts.pin_on_disc import no_local_wear_of_a_block, pin_contact
from tribopipe.contacts.wear import State
from tribopipe.documents.contact import Contact, SlidingPin
from tribopipe.documents.contact_kinds import family_of
from tribopipe.documents.twin_disc import TwinDisc
from tribopipe.physics.calculation_methods import Engine
from tribopipe.physics.geometry import cap_height
from tribopipe.physics.hertz import hertz_radius
from tribopipe.physics.local.contact_solvers import Surface
from tribopipe.physics.local.course import LocalWear
from tribopipe.physics.local.finite_elements import pin_body, quarter_disc
from tribopipe.physics.local.grids import disc_track, round_pin
from tribopipe.physics.local.rings import Rings, ring_edges
from tribopipe.physics.local.track import PinOnTrack, contact_reach, tip_on_track

_RINGS_OF_A_FLAT_PIN = 160
_MARGIN = 1.25
"""Radius of the outermost point over that of the largest contact."""


def surface_of(contact: Contact, values: Values, amount: float, last: State, engine: Engine | None = None) -> Surface:
    """Build the surface that wears for an amount of wear, m³/N of a pin, m²/N of discs, by an engine or the usual one.

    ``last`` is the state in which the model with uniform pressure leaves the bodies after that amount. Raises
    ``ContactError`` where a body would be worn away before that, where they do not touch, or where the engine does not
    have its package or is none for such bodies.
    """
    engines = _engines(contact, last)
    return _fit(engine or engines.usual, engines)(contact, values, amount)


def usual_engine(contact: Contact, last: State) -> Engine:
    """Return the engine that suits the bodies: rings under a pin alone, otherwise a half space."""
    return _engines(contact, last).usual


def economy_refused(contact: Contact, last: State) -> ContactError:
    """Return the error that the scheme economy is for bodies, or an engine, without finite elements."""
    engines = _engines(contact, last)
    remedy = "; add --engine fe"
    if "fe" not in engines.builders:
        remedy = f", but only {engines.named} can be used; omit --scheme"
    return ContactError(f"local wear: found --scheme economy for {engines.of}; expected finite elements{remedy}")


def worn_bodies(surface: Surface, course: LocalWear, last: State) -> State:
    """Return the wear of a pin and of its track along a course, named as in ``last``; nothing for other bodies."""
    if not isinstance(surface, PinOnTrack):
        return {}
    bodies = [surface.bodies(worn) for worn in course.worn]
    section = np.array([one.groove_area for one in bodies])
    # What the track loses over what its middle shows of it, also of a track that is not worn.
    length = last["track_volume"] / last["track_section"] if last["track_section"] > 0 else 0.0
    return {
        "approach": course.depth,
        "wear_depth": np.array([one.pin_depth for one in bodies]),
        "track_depth": np.array([one.groove_depth for one in bodies]),
        "pin_volume": course.volume,
        "track_volume": length * section,
        "track_section": section,
        "half_width": np.array([one.half_width for one in bodies]),
        "half_length": np.array([one.half_length for one in bodies]),
    }


def _engines(contact: Contact, last: State) -> "_Engines":
    return family_of(contact, _FAMILIES)(contact, last)


def _pin_rings(contact: SlidingPin, values: Values, amount: float) -> Surface:
    edges = _pin_edges(contact, values, amount)
    gap = _tip(contact, values)((edges[1:] + edges[:-1]) / 2)
    return Rings(float(values["normal_load"]), _pin_modulus(contact, values), edges, gap)


def _pin_grid(contact: SlidingPin, values: Values, amount: float) -> Surface:
    return round_pin(
        normal_load=float(values["normal_load"]),
        modulus=_pin_modulus(contact, values),
        tip=_tip(contact, values),
        reach=float(_pin_edges(contact, values, amount)[-1]),
    )


def _pin_elements(contact: SlidingPin, values: Values, amount: float) -> Surface:
    radius = _pin_edges(contact, values, amount)
    return pin_body(
        normal_load=float(values["normal_load"]),
        modulus=_pin_modulus(contact, values),
        poisson_ratio=contact.pin.poisson_ratio.value,
        radius=radius,
        gap=_tip(contact, values)(radius),
    )


def _pin_edges(contact: SlidingPin, values: Values, amount: float) -> Column:
    load, radius, modulus = float(values["normal_load"]), float(values["pin_radius"]), _pin_modulus(contact, values)
    if contact.pin.line:
        raise no_local_wear_of_a_block(contact)
    if contact.pin.shape == "flat":
        return np.linspace(0.0, radius, _RINGS_OF_A_FLAT_PIN + 1)
    first = float(hertz_radius(normal_load=load, pin_radius=radius, modulus=modulus))
    largest = float(pin_contact(contact, values).worn(amount * load).radius)
    return ring_edges(first, min(_MARGIN * max(largest, first), radius))


def _tip(contact: SlidingPin, values: Values) -> Callable[[Column], Column]:
    """Return how far the tip lies behind its end at radii from its axis, m; with a flat pin there is none."""
    radius = float(values["pin_radius"])
    if contact.pin.shape == "flat":
        return lambda r: np.where(r <= radius, 0.0, np.inf)
    missing = cap_height(scar_radius=contact.pin.flat, sphere_radius=radius)
    return lambda r: np.maximum(cap_height(scar_radius=r, sphere_radius=radius) - missing, 0.0)


def _pin_modulus(contact: SlidingPin, values: Values) -> float:
    return float(contact.reduced_modulus(values["pin_modulus"], values["disc_modulus"]))


def _pin_on_track(contact: SlidingPin, values: Values, amount: float, *, last: State) -> Surface:
    """Build a pin on a track whose wear is to that of the pin as in the last state, which is that of rigid bodies."""
    if contact.pin.line:
        raise no_local_wear_of_a_block(contact)
    if not amount > 0:
        raise ContactError(
            f"local wear: found a {contact.body_names[0]} that does not wear; expected a positive wear coefficient; "
            "use `tribopipe predict --engine local`"
        )
    load, radius = float(values["normal_load"]), float(values["pin_radius"])
    # Rigid bodies have no modulus among their values.
    modulus = float(contact.reduced_modulus())
    rounded = not contact.pin.constant_area
    start = float(hertz_radius(normal_load=load, pin_radius=radius, modulus=modulus)) if rounded else 0.0
    return tip_on_track(
        normal_load=load,
        modulus=modulus,
        tip=_tip(contact, values),
        radius=radius if rounded else np.inf,
        track_ratio=float(last["track_section"] / last["pin_volume"]),
        reach=contact_reach(start, float(last["half_width"]), float(last["half_length"])),
    )


def _disc_grid(contact: TwinDisc, values: Values, amount: float) -> Surface:
    return disc_track(**_discs(contact, values), amount=amount)


def _disc_elements(contact: TwinDisc, values: Values, amount: float) -> Surface:
    ratio = contact.curved_disc.poisson_ratio.value
    return quarter_disc(**_discs(contact, values), poisson_ratio=ratio, amount=amount)


def _discs(contact: TwinDisc, values: Values) -> dict[str, Any]:
    names = ("normal_load", "crown_radius", "curved_radius", "flat_radius")
    modulus = contact.reduced_modulus(values["curved_modulus"], values["flat_modulus"])
    return {name: float(values[name]) for name in names} | {"modulus": float(modulus)}


class _Engines(NamedTuple):
    """Engines that can solve the contact of a pair of bodies."""

    of: str
    usual: Engine
    builders: Mapping[Engine, Callable[..., Surface]]

    @property
    def named(self) -> str:
        """Return their names, for messages."""
        return " or ".join(self.builders)


def _engines_of_a_pin(contact: SlidingPin, last: State) -> _Engines:
    if "track_section" in last:
        # A groove is not axisymmetric.
        grid = partial(_pin_on_track, last=last)
        return _Engines("a pin on a counterbody that wears", "half-space", {"half-space": grid})
    grids: dict[Engine, Callable[..., Surface]] = {"rings": _pin_rings, "half-space": _pin_grid}
    if contact.pin.shape == "flat":
        # The mesh would fold at its edge.
        return _Engines("a flat pin", "rings", grids)
    return _Engines("a pin", "rings", {**grids, "fe": _pin_elements})


def _engines_of_discs(_contact: TwinDisc, _last: State) -> _Engines:
    return _Engines("two discs", "half-space", {"half-space": _disc_grid, "fe": _disc_elements})


_FAMILIES: dict[type[Contact], Callable[..., _Engines]] = {
    SlidingPin: _engines_of_a_pin,
    TwinDisc: _engines_of_discs,
}


def _fit(engine: Engine, engines: _Engines) -> Callable[..., Surface]:
    """Return the builder of an engine. Raises ``ContactError`` where there is none."""
    if engine not in engines.builders:
        raise ContactError(
            f"local wear: found the engine {engine!r} for {engines.of}; expected {engines.named}; "
            "specify one of these engines, or omit the engine to use the default"
        )
    return engines.builders[engine]
