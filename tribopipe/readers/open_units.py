"""Units that a header leaves open, as the identities between its columns propose them.

An identity such as m·g = F_N holds for masses in g and forces in N, not for masses in kg. It fixes ratios of units
alone; of those that hold, the most usual ones are proposed.
"""

from collections.abc import Iterator, Mapping, Sequence
from itertools import product
from typing import NamedTuple

import numpy as np

from tribopipe.base.units import is_unit_of, to_si
from tribopipe.physics.identities import Identity, Role, ratios
from tribopipe.readers.column_aliases import plain_name
from tribopipe.readers.reader import ReadColumn

_UNITS: dict[Role, tuple[str, ...]] = {
    "time": ("s", "min", "h", "ms"),
    "sliding_distance": ("m", "mm", "km"),
    "sliding_speed": ("m/s", "mm/s"),
    "track_radius": ("mm", "m"),
    "rotational_speed": ("rpm", "rad/s"),
    "rotations": ("1",),
    "mass": ("g", "kg"),
    "normal_force": ("N", "mN", "kN"),
    "friction_force": ("N", "mN", "kN"),
    "friction_coefficient": ("1", "%"),
}
"""The most usual ones first."""
_KINDS: dict[Role, str] = {
    "time": "time",
    "sliding_distance": "distance",
    "sliding_speed": "speed",
    "track_radius": "length",
    "rotational_speed": "rotational speed",
    "rotations": "count",
    "mass": "mass",
    "normal_force": "force",
    "friction_force": "force",
    "friction_coefficient": "ratio",
}
_NAMES: dict[Role, str] = {
    "time": "time testtime elapsedtime zeit",
    "sliding_distance": "distance slidingdistance totaldistance weg gleitweg",
    "sliding_speed": "slidingvelocity slidingspeed linearvelocity linearspeed velocity gleitgeschwindigkeit speed",
    "track_radius": "radius trackradius wearradius wearscarradius spurradius reibradius",
    "rotational_speed": "rotationalspeed rpm drehzahl rotationspeed speed",
    "rotations": "revolutions totalrevolutions numberofrevolutions rotations laps umdrehungen",
    "mass": "mass deadmass masse",
    "normal_force": "load normalload normalforce fn fz normalkraft last",
    "friction_force": "frictionforce friction ff reibkraft",
    "friction_coefficient": "frictioncoefficient cof mu reibwert reibzahl",
}
NEAR = 0.2
"""Tolerance of the ratio of both sides of an identity: a radius may be rounded to a whole mm, and units that could
be confused are further apart."""
_MOST_ROWS = 100_000


class OpenUnit(NamedTuple):
    """A unit that a header leaves open."""

    unit: str
    why: str
    """The identities that hold with it."""


def roles_of(columns: Sequence[ReadColumn]) -> dict[Role, ReadColumn]:
    """State by their names which quantities columns are, of two of one name the first.

    "Speed" is the sliding speed, or next to a sliding velocity the rotational one.
    """
    found: dict[Role, ReadColumn] = {}
    for role, names in _NAMES.items():
        fitting = [one for one in columns if _may_be(one, role) and all(one is not other for other in found.values())]
        named = {plain_name(one): one for one in reversed(fitting)}
        name = next((name for name in names.split() if name in named), None)
        if name is not None:
            found[role] = named[name]
    return found


def _may_be(column: ReadColumn, role: Role) -> bool:
    """Return whether a column is one of numbers whose unit, where it has one, fits."""
    return column.first_bad is None and (column.unit is None or is_unit_of(column.unit, _KINDS[role]))


def open_units(roles: Mapping[Role, ReadColumn]) -> dict[Role, OpenUnit]:
    """Propose units for the columns that have none, by the identities that hold with them."""
    values = {role: np.asarray(column.values[:_MOST_ROWS], dtype=float) for role, column in roles.items()}
    known = list(ratios(values))
    concerned = [role for role in roles if any(role in identity.roles for identity, _ in known)]
    if not known or all(roles[role].unit for role in concerned):
        return {}
    best = max(_choices(roles, concerned), key=lambda choice: _fit(choice, known))
    holding = [identity for identity, ratio in known if _holds(identity, ratio, best)]
    return {
        role: OpenUnit(best[role], ", ".join(one.formula for one in holding if role in one.roles))
        for role in concerned
        if roles[role].unit is None and any(role in one.roles for one in holding)
    }


Choice = dict[Role, str]


def _choices(roles: Mapping[Role, ReadColumn], concerned: Sequence[Role]) -> Iterator[Choice]:
    """Give every choice of units, the most usual ones first."""
    units = [(roles[role].unit or "",) if roles[role].unit else _UNITS[role] for role in concerned]
    for chosen in product(*units):
        yield dict(zip(concerned, chosen, strict=True))


def _fit(choice: Choice, known: Sequence[tuple[Identity, float]]) -> tuple[int, int]:
    """Rank a choice: by the identities that hold, then by how usual its units are."""
    unusual = sum(_UNITS[role].index(unit) for role, unit in choice.items() if unit in _UNITS[role])
    return sum(_holds(identity, ratio, choice) for identity, ratio in known), -unusual


def _holds(identity: Identity, ratio: float, choice: Choice) -> bool:
    for role in identity.left:
        ratio *= _factor(role, choice[role])
    for role in identity.right:
        ratio /= _factor(role, choice[role])
    return abs(ratio - 1) <= NEAR


def _factor(role: Role, unit: str) -> float:
    return float(to_si(1.0, unit, unit_kind(role)))


def unit_kind(role: Role) -> str:
    """Return the kind of number that a quantity is."""
    return _KINDS[role]
