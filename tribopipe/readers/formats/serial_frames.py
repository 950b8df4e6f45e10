r"""Frames of a load-cell indicator, logged from its serial port.

One reading a frame, as common weighing indicators send them over RS-232; a terminal program writes the control
characters as they are, or by their names:

    <STX>   0.072KGM<CR><LF>
    \x02   0.072KG \r\n

* STX (byte 0x02 or the text <STX>) begins a frame.
* The reading is padded with blanks on the left, its sign among them; decimal point, or comma.
* The unit follows at once: G, KG, LB or N. A weight is a force here: KG is kilogram-force.
* M states that the reading moves (has not settled), a blank that it is stable.
* CR, LF or both end a frame, by their names, as they are, or one after the other.

No time is in the file, only the order of frames: it has to come from another file with a row for each frame.
"""

import re

import numpy as np

from tribopipe.base.errors import ReaderError
from tribopipe.readers.reader import Hints, Holds, Match, ReadColumn, ReadTable
from tribopipe.results.run import SourceFile

_START = re.compile(rb"<STX>|\x02")
_FRAME = re.compile(
    rb" *+(?P<sign>[+-]?) *+(?P<number>\d{1,12}(?:[.,]\d{0,12})?) *(?P<unit>KG|G|LB|N)(?P<motion>[ M]?)"
    rb"(?P<end>(?:<ETX>|<CR>|<LF>|[\x03\r\n])++)",
    re.IGNORECASE,
)
_UNITS = {b"KG": "kgf", b"G": "gf", b"LB": "lbf", b"N": "N"}
_HEAD_BYTES = 1 << 12
_ENOUGH = 0.8
"""Share of whole frames in the head by which a file is known."""


class SerialFramesReader:
    """Readings of a load cell, one a frame."""

    name = "load-cell-frames"
    title = "Frames of a load-cell indicator, logged from its serial port"
    holds: Holds = "signals"

    def match(self, source: SourceFile) -> Match:
        """Judge by how many of the first frames are whole."""
        frames = _START.split(source.content[:_HEAD_BYTES])[1:]
        whole = sum(_FRAME.fullmatch(frame) is not None for frame in frames)
        judged = max(1, len(frames) - 1)  # the last may be cut
        if whole == 0 or whole < _ENOUGH * judged:
            return Match(0.0, f"no frames of the form '<STX>   0.072KGM<CR><LF>', or too few complete frames ({whole})")
        return Match(0.95, f"{whole} of the first {len(frames)} frames have the form '<STX>   0.072KGM<CR><LF>'")

    def read(self, source: SourceFile, hints: Hints) -> ReadTable:  # noqa: ARG002 - frames leave nothing open
        """Parse the file; ``ReaderError`` where it holds no whole frame, or several units."""
        before, *frames = _START.split(source.content)
        found = [_FRAME.fullmatch(frame) for frame in frames]
        notes = []
        if found and found[-1] is None:
            del found[-1]
            notes.append("the last frame is truncated; it is omitted")
        unit = _unit(source.name, {frame["unit"].upper() for frame in found if frame})
        broken = [number for number, frame in enumerate(found, 1) if frame is None]
        if broken:
            text = frames[broken[0] - 1].decode(errors="replace").strip()
            notes.append(
                f"{len(broken)} of {len(found)} frames are corrupted and treated as missing samples; the first is "
                f"frame {broken[0]}: {text[:40]!r}"
            )
        notes.append(
            "found frames without time stamps; expected a time or sliding distance for each frame; map time or sliding "
            "distance from a file with one row per frame"
        )
        columns = (
            ReadColumn("load", np.array([_number(frame) for frame in found]), unit),
            ReadColumn("motion", np.array([_moves(frame) for frame in found]), "1"),
        )
        return ReadTable(columns, before.decode("latin-1"), tuple(notes))


def _unit(file: str, units: set[bytes]) -> str:
    if len(units) == 1:
        return _UNITS[units.pop()]
    found = f"frames in {' and '.join(sorted(unit.decode() for unit in units))}" if units else "no complete frame"
    raise ReaderError(
        f"{file}: found {found}; expected frames of the form '<STX>   0.072KGM<CR><LF>', all in the same unit; split "
        "the file where the unit changes, or specify another reader in run.toml"
    )


def _number(frame: re.Match[bytes] | None) -> float:
    return float(frame["sign"] + frame["number"].replace(b",", b".")) if frame else np.nan


def _moves(frame: re.Match[bytes] | None) -> float:
    return float(frame["motion"] in b"Mm" and frame["motion"] != b"") if frame else np.nan
