"""Channels of a run by what they are: its measured signals, and columns without a meaning whose name and unit show."""

import re
from collections.abc import Iterator
from itertools import combinations
from typing import NamedTuple

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.base.units import KINDS, is_rotational, is_unit_of, show, to_si
from tribopipe.documents.signals import SIGNALS, SignalName
from tribopipe.results.run import RawRun

_SIGNALS: tuple[SignalName, ...] = (
    *("time", "sliding_distance", "sliding_speed", "rotations"),
    *("normal_force", "friction_force", "friction_coefficient"),
)
_EXTRAS = {
    "track_radius": ("length", "radius|trackradius|wearradius"),
    "mass": ("mass", "mass|deadmass"),
    "rotations": ("count", "revolutions|totalrevolutions|numberofrevolutions|laps"),
    "cycles": ("count", "cycles?|numberofcycles|cyclenumber|cyclecount|zyklen"),
    "frequency": ("frequency", "frequency|frequenz"),
    "nominal_load": ("force", "nominalload|setload|setforce|loadsetpoint"),
    "nominal_speed": ("speed", "nominalspeed|setspeed|maxlinearspeed|speedsetpoint"),
    "stroke": ("length", "stroke|hub|strokelength"),
    "slip": ("percentage", "slip|slipratio|schlupf"),
}
"""Kind of number and names, written in small letters alone."""
_TWO_DISCS = tuple(
    frozenset(pair.split())
    for pair in ("1 2", "upper lower", "top bottom", "curved flat", "crowned cylindrical", "oben unten")
)
"""Words in which the names of two columns differ that are the speeds of two discs."""
_POSITION = re.compile(r"(?:xyz)?[xy](?:position)?|position|wegx|weg")


class Channel(NamedTuple):
    """Recorded channel of one quantity."""

    label: str
    """The signal, or the name of the column."""
    values: Column
    """Values in SI units."""
    unit: str
    """SI unit."""
    shown_in: str

    def shown(self, value: float) -> str:
        """Write a value for people."""
        return show(value, None, self.unit, self.shown_in)


def channels(run: RawRun) -> dict[str, Channel]:
    """Return the measured channels of a run by what they are: a ``Role`` of an identity, frequency, stroke or slip."""
    found = dict(_from_extras(run))
    for role in _SIGNALS:
        if role in run.columns and run.origins[role] == "measured":
            unit = SIGNALS[role].unit
            found[role] = Channel(role, run.columns[role], unit, unit)
    return found


def _from_extras(run: RawRun) -> Iterator[tuple[str, Channel]]:
    turning = [name for name, extra in run.extras.items() if extra.unit and is_rotational(extra.unit)]
    for name, extra in run.extras.items():
        if extra.values.dtype.kind != "f" or not np.any(np.isfinite(extra.values)):
            continue
        if turning == [name]:
            yield "rotational_speed", _channel(run, name, "rotational speed", "rad/s")
        for role, (kind, names) in _EXTRAS.items():
            stated = bool(extra.unit) or kind != "percentage"
            if stated and re.fullmatch(names, _plain(name)) and is_unit_of(extra.unit or "1", kind):
                yield role, _channel(run, name, kind, KINDS[kind].si)


def positions(run: RawRun) -> Iterator[Channel]:
    """Give the columns in which a pin that slides there and back may be identified by its position."""
    for name, extra in run.extras.items():
        if (
            extra.values.dtype.kind == "f"
            and _POSITION.fullmatch(_plain(name))
            and is_unit_of(extra.unit or "1", "length")
        ):
            yield _channel(run, name, "length", "m")


def disc_speeds(run: RawRun) -> Iterator[tuple[Channel, Channel]]:
    """Give the columns with the speeds of two discs, both in rad/s or both in m/s."""
    for kind, unit in (("rotational speed", "rad/s"), ("speed", "m/s")):
        named = [name for name, extra in run.extras.items() if extra.unit and is_unit_of(extra.unit, kind)]
        moving = [name for name in named if run.extras[name].values.dtype.kind == "f"]
        for one, other in combinations(moving, 2):
            if _names_two_discs(one, other):
                yield _channel(run, one, kind, unit), _channel(run, other, kind, unit)


def _names_two_discs(one: str, other: str) -> bool:
    first, second = (re.findall(r"[^\W\d_]+|\d+", name.casefold()) for name in (one, other))
    differ = [{*pair} for pair in zip(first, second, strict=False) if pair[0] != pair[1]]
    return len(first) == len(second) and len(differ) == 1 and differ[0] in _TWO_DISCS


def _channel(run: RawRun, name: str, kind: str, unit: str) -> Channel:
    extra = run.extras[name]
    shown_in = extra.unit or "1"
    return Channel(name, np.asarray(to_si(extra.values, shown_in, kind), dtype=float), unit, shown_in)


def _plain(name: str) -> str:
    """Write a name in small letters alone, without the unit in brackets behind it."""
    return re.sub(r"[^a-z]", "", re.sub(r"[\[(][^\[\]()]*[\])]\s*$", "", name).casefold())
