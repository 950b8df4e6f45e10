"""A reader of what our rig writes: a line that says so, settings, and a table whose names carry their units.

RIG LOG 2
load=200 mN
t/s;d/um;Ff/mN;T/degC;
0.00;1.20;102.5;21.5;
"""

from dataclasses import replace

from tribopipe.base.errors import ReaderError
from tribopipe.readers.delimited import read_table
from tribopipe.readers.layout import Layout
from tribopipe.readers.reader import Hints, Match, ReadColumn, ReadTable
from tribopipe.readers.text import decode, sample_lines
from tribopipe.results.run import SourceFile

MARK = "RIG LOG 2"
SIGNALS = {"t": "time", "d": "depth", "Ff": "friction_force", "T": "temperature"}


class RigLogReader:
    """Logs of our rig."""

    name = "rig-log"
    title = "Log of our rig (.rig)"
    holds = "signals"

    def match(self, source: SourceFile) -> Match:
        """Judge by the first line."""
        if source.content.startswith(MARK.encode()):
            return Match(0.95, f"the first line is {MARK!r}")
        return Match(0.0, f"the first line is not {MARK!r}")

    def read(self, source: SourceFile, hints: Hints) -> ReadTable:
        """Read settings, names and rows."""
        text = decode(source, hints.encoding)
        lines = sample_lines(text)
        top = next((number for number, line in enumerate(lines) if line.startswith("t/s;")), None)
        if top is None:
            raise ReaderError(f"{source.name}: found no row of names; expected one that begins t/s; copy the log again")
        names = tuple(lines[top].strip().split(";"))
        # The last semicolon of a row, behind which nothing stands, proves that its last number is whole.
        layout = Layout(";", ".", names, top + 2, "".join(lines[: top + 1]), len(names), len(names))
        table = read_table(text, layout)
        return replace(table, columns=tuple(map(told, table.columns)), facts=facts(lines[1:top]))


def told(column: ReadColumn) -> ReadColumn:
    """Add what the name of a column says: d/um is the depth in µm."""
    name, _, unit = column.name.partition("/")
    return replace(column, signal=SIGNALS.get(name), unit=unit or None)


def facts(settings: list[str]) -> dict[str, str]:
    """Return what the settings say of the run, by the keys of run.toml."""
    said = dict(line.strip().split("=", 1) for line in settings if "=" in line)
    return {"conditions.normal_load": said["load"]} if "load" in said else {}
