"""What names of files seem to state about the conditions: "9-Al10Cu-50N-140m-328rpm". Only hints, so never taken.

A value is offered where the names state one alone, with the label that its unit has; all else is named and not offered.
"""

import re
from collections.abc import Iterable, Iterator
from pathlib import PurePath
from typing import NamedTuple

from tribopipe.base.errors import UnitError
from tribopipe.base.units import with_point
from tribopipe.readers.draft.known_values import LOAD, Known, alike

_DATE = re.compile(r"(?<!\d)(?:\d{4}([-_.]?)\d\d\1\d\d|\d\d([-_.])\d\d\2\d{4})(?!\d)", re.ASCII)
# A number with its unit, and the letters in front of it; none behind a digit and a dash, which may be a decimal sign:
# "0-3N".
_HINT = re.compile(
    r"(?<![^\W_])(?<![.,])(?<!\d[-_])(?P<label>[^\W\d_]*)(?P<gap>[ =]?)(?P<number>\d+(?:[.,]\d+)?) ?"
    r"(?P<unit>mN|kN|N|rpm|mm[-_/]s|mmp?s|m[-_/]s|mp?s|mm|Hz|°C|degC)(?![^\W_]|[.,]\d)"
)


class _Meaning(NamedTuple):
    """What a number with a unit stands for behind some labels."""

    key: str
    unit: str
    labels: tuple[str, ...]


_LOADS = ("", "f", "fn", "load", "last", "kraft")
_SPEED = ("v", "speed")
_MEANINGS: dict[str, tuple[_Meaning, ...]] = {
    **{unit: (_Meaning(LOAD, unit, _LOADS),) for unit in ("mN", "kN", "N")},
    **dict.fromkeys(
        ("mm/s", "mm-s", "mm_s", "mmps", "mms"), (_Meaning("conditions.sliding_speed", "mm/s", ("", *_SPEED)),)
    ),
    **dict.fromkeys(("m/s", "m-s", "m_s", "mps"), (_Meaning("conditions.sliding_speed", "m/s", ("", *_SPEED)),)),
    "ms": (_Meaning("conditions.sliding_speed", "m/s", _SPEED),),  # alone, milliseconds
    "rpm": (_Meaning("conditions.rotational_speed", "rpm", ("", "n")),),
    "Hz": (_Meaning("conditions.frequency", "Hz", ("", "f")),),
    **dict.fromkeys(("°C", "degC"), (_Meaning("conditions.temperature", "degC", ("", "t", "temp")),)),
    "mm": (
        _Meaning("contact.pin.diameter", "mm", ("ball", "kugel", "bille", "bola", "kulka")),
        _Meaning("conditions.track_radius", "mm", ("r", "radius", "track", "spur")),
        _Meaning("conditions.stroke", "mm", ("stroke", "hub")),
    ),
}


def doubt_names(known: Known, names: Iterable[str]) -> None:
    """Offer what names of files, where they agree, seem to state about what is not known."""
    seen: dict[str, dict[str, str]] = {}
    for name in names:
        for key, value, written in _said(PurePath(name).stem):
            seen.setdefault(key, {}).setdefault(value, written)
    for key, values in seen.items():
        fitting = [value for value in values if known.fits(key, value)]
        stated = known.given.get(key)
        for value in fitting:
            if stated is not None and not (len(fitting) == 1 and alike(key, stated.value, value)):
                known.object(key, f"{values[value]!r} in the name of the file")
            elif stated is None and len(fitting) == 1:
                known.offer(key, value, f"probable from the name of the file, {values[value]!r}")
            elif stated is None:
                known.doubt(key, value, f"the name of the file has {values[value]!r}, and another value as well")


def _said(stem: str) -> Iterator[tuple[str, str, str]]:
    """Give key, value and what is written of each value in a name."""
    for found in _HINT.finditer(_DATE.sub("", stem)):
        labels = (found["label"].casefold(), "") if found["gap"] == " " else (found["label"].casefold(),)
        meanings = _MEANINGS[found["unit"]]
        meaning = next((one for label in labels for one in meanings if label in one.labels), None)
        if meaning is None:
            continue
        try:
            yield meaning.key, with_point(f"{found['number']} {meaning.unit}"), found[0].strip()
        except UnitError:
            continue
