"""T-11 (ITeE Radom): what the software of this pin-on-disc tester exports.

    Time [s];Friction force [N];Displacement [um];Temperature2 [C];Temperature1 [C];Rotational speed [rpm];Number of …
    0,000;0,12;0,0;23,1;22,8;120;0;

* Semicolons separate; a row may end in one more. Decimal comma or point. Column order and lines above the names vary.
* Friction force in N, displacement (linear wear of both bodies) in µm, rotational speed of the disc in rotations a
  minute, its rotations since the start. [C] is °C.
* A friction force of exactly 0 between others is a failed reading, kept as it stands.

Load, track radius and date are not in the file. Where the thermometers are is the lab's choice, so that temperatures
have no meaning by themselves.
"""

from dataclasses import replace

from tribopipe.base.errors import ReaderError
from tribopipe.documents.signals import SignalName
from tribopipe.readers.headed_tables import bare_key, cells_of, judge_lines, read_below
from tribopipe.readers.reader import Hints, Holds, Match, ReadColumn, ReadTable
from tribopipe.readers.text import decode, sample_lines
from tribopipe.results.run import SourceFile

_SIGNALS: dict[str, SignalName] = {
    "time": "time",
    "frictionforce": "friction_force",
    "frictioncoefficient": "friction_coefficient",
    "displacement": "depth",
    "numberofrevolutions": "rotations",
}
_ALWAYS = frozenset({"time", "frictionforce"})
_USUAL = frozenset({"displacement", "temperature1", "temperature2", "rotationalspeed", "numberofrevolutions"})
_ENOUGH = 2
_SEPARATOR = ";"


class T11Reader:
    """Tables of the T-11 pin-on-disc tester."""

    name = "t-11"
    title = "T-11 pin-on-disc tester (ITeE Radom)"
    holds: Holds = "signals"

    @judge_lines
    def match(self, lines: list[str]) -> Match:
        """Judge by the names of the columns."""
        found = _names_row(lines)
        if found is None:
            return Match(
                0.0, "no header row with friction force, displacement, temperatures and revolutions, as in T-11 files"
            )
        return Match(0.95, f"line {found + 1} is the header row of a T-11 file")

    def read(self, source: SourceFile, hints: Hints) -> ReadTable:
        """Parse the file; ``ReaderError`` with file and line where it is broken."""
        text = decode(source, hints.encoding)
        lines = sample_lines(text)
        at = _names_row(lines)
        if at is None:
            raise ReaderError(
                f"{source.name}: found no header row such as 'Time [s];Friction force [N];…;Number of revolutions'; "
                "expected the header row of a T-11 file; specify another reader in run.toml"
            )
        table = read_below(text, lines, at, _SEPARATOR, hints.decimal)
        return replace(table, columns=tuple(map(_with_meaning, table.columns)))


def _are_marks(names: frozenset[str]) -> bool:
    return names >= _ALWAYS and len(names & _USUAL) >= _ENOUGH


def _names_row(lines: list[str]) -> int | None:
    """Find the index of the row of names, where there is one."""
    rows = (frozenset(map(bare_key, cells_of(line, _SEPARATOR))) for line in lines)
    return next((index for index, names in enumerate(rows) if _are_marks(names)), None)


def _with_meaning(column: ReadColumn) -> ReadColumn:
    signal = _SIGNALS.get(bare_key(column.name))
    unit = "degC" if column.unit == "C" else "1" if signal == "rotations" else column.unit
    return replace(column, unit=unit, signal=signal)
