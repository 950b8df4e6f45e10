r"""Rotating friction tester on Newport stages: rows without names below one line of settings.

ASCII, decimal point, lines ended by CRLF (LF and CR are taken as well):

    0.050\t0.001\t0.700\t10.000\t1.000\t0.400\t…\t-10.000
    12.035800;0.048575;-0.130228;-0.000320;499.720000;0.088757;0.050000
    0.135000;0.148945;-0.133837;0.001561;495.790000;0.889057;0.050000

* Line 1: sixteen settings of the program between tabs, without names. The fifth is the load in N that the stage
  presses with.
* Then seven columns between semicolons: time in the step (s), time (s), normal force (N), torque (N·m), height of
  the stage (µm), rotational speed (rotations a second), speed at which the stage follows the load (mm/s).

The step time begins with a stale value and starts again at each step. Force and torque are not zeroed. The stage
approaches from above, so its height falls by far more than wear. Track radius, materials and date are not in the file.
"""

import re
from dataclasses import replace
from typing import NamedTuple

from tribopipe.base.errors import ReaderError
from tribopipe.documents.signals import SignalName
from tribopipe.readers.delimited import read_table
from tribopipe.readers.headed_tables import cells_of, judge_lines, layout_below, without_cut_row
from tribopipe.readers.reader import Hints, Holds, Match, ReadTable
from tribopipe.readers.tables import PLACEHOLDER, is_number
from tribopipe.readers.text import decode, sample_lines
from tribopipe.results.run import SourceFile


class _Channel(NamedTuple):
    unit: str
    signal: SignalName | None = None


_CHANNELS = {
    "step time": _Channel("s"),
    "time": _Channel("s", "time"),
    "normal force": _Channel("N", "normal_force"),
    "torque": _Channel("N*m"),
    "stage height": _Channel("um"),
    "rotational speed": _Channel("rps"),
    "adjustment speed": _Channel("mm/s"),
}
_SETTINGS = 16
_LOAD = 4
_FIELD = rf"(?:[+-]?\d+\.\d+|{PLACEHOLDER})?"
_ROW = re.compile(rf"(?:{_FIELD};){{6}}{_FIELD}\s*", re.ASCII | re.IGNORECASE)


class NewportReader:
    """Semicolon rows of seven numbers below sixteen settings."""

    name = "newport-rheofriction"
    title = "Friction tester on Newport stages (settings in the first line)"
    holds: Holds = "signals"

    @judge_lines
    def match(self, lines: list[str]) -> Match:
        """Judge by the sixteen settings, and by the first row where it is whole."""
        if not _settings(lines):
            return Match(0.0, "the first line does not contain 16 tab-separated numbers")
        if len(lines) > 2 and not _ROW.fullmatch(lines[1]):
            return Match(
                0.2,
                "the first line contains 16 settings, but the rows do not contain 7 numbers separated by semicolons",
            )
        return Match(
            0.95, "the first line contains 16 settings, and the rows contain 7 numbers separated by semicolons"
        )

    def read(self, source: SourceFile, hints: Hints) -> ReadTable:
        """Parse the file; ``ReaderError`` with file and line where it is broken."""
        text = decode(source, hints.encoding)
        lines = sample_lines(text)
        settings = _settings(lines)
        if not settings:
            raise ReaderError(
                f"{source.name}, line 1: found {lines[0].strip()[:60]!r}; expected 16 tab-separated settings; "
                "specify another reader in run.toml, or copy the file again from the instrument"
            )
        text = without_cut_row(text, ";")
        table = read_table(text, layout_below(text, lines, 1, tuple(_CHANNELS), ";", "."))
        columns = (
            replace(column, unit=channel.unit, signal=channel.signal)
            for column, channel in zip(table.columns, _CHANNELS.values(), strict=True)
        )
        return replace(table, columns=tuple(columns), facts={"conditions.normal_load": f"{settings[_LOAD]:g} N"})


def _settings(lines: list[str]) -> list[float]:
    """Give the settings in the first line; none where it holds something else."""
    cells = cells_of(lines[0], "\t") if lines else ()
    whole = len(cells) == _SETTINGS and all(is_number(cell, ".") for cell in cells)
    return [float(cell) for cell in cells] if whole else []
