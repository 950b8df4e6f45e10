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

from collections.abc import Set
from dataclasses import replace

from tribopipe.documents.signals import SignalName
from tribopipe.readers.headed_tables import HeaderRowReader, bare_key
from tribopipe.readers.reader import ReadColumn, ReadTable

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


class T11Reader(HeaderRowReader):
    """Tables of the T-11 pin-on-disc tester."""

    name = "t-11"
    title = "T-11 pin-on-disc tester (ITeE Radom)"
    separator = ";"
    sought = "such as 'Time [s];Friction force [N];…;Number of revolutions'"
    whose = "a T-11 file"

    def is_header(self, line: str, names: Set[str]) -> bool:  # noqa: ARG002
        """Judge by the names alone."""
        return names >= _ALWAYS and len(names & _USUAL) >= _ENOUGH

    def understood(self, table: ReadTable, lines: list[str], at: int) -> ReadTable:  # noqa: ARG002
        """Return the table with signals and units."""
        return replace(table, columns=tuple(map(_with_meaning, table.columns)))


def _with_meaning(column: ReadColumn) -> ReadColumn:
    signal = _SIGNALS.get(bare_key(column.name))
    unit = "degC" if column.unit == "C" else "1" if signal == "rotations" else column.unit
    return replace(column, unit=unit, signal=signal)
