"""Channels of a run by what they are: its measured signals, and columns without a meaning whose name and unit show."""

import re
from collections.abc import Iterator
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
    "frequency": ("frequency", "frequency|frequenz"),
    "nominal_load": ("force", "nominalload|setload|setforce|loadsetpoint"),
    "nominal_speed": ("speed", "nominalspeed|setspeed|maxlinearspeed|speedsetpoint"),
    "stroke": ("length", "stroke|hub|strokelength"),
    "slip": ("percentage", "slip|slipratio|schlupf"),
}
"""Kind of number and names, written in small letters alone."""
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


def _channel(run: RawRun, name: str, kind: str, unit: str) -> Channel:
    extra = run.extras[name]
    shown_in = extra.unit or "1"
    return Channel(name, np.asarray(to_si(extra.values, shown_in, kind), dtype=float), unit, shown_in)


def _plain(name: str) -> str:
    """Write a name in small letters alone, without the unit in brackets behind it."""
    return re.sub(r"[^a-z]", "", re.sub(r"[\[(][^\[\]()]*[\])]\s*$", "", name).casefold())
