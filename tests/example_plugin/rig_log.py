"""A reader for the files of our rig: signature line, settings, and a table with units in the column names.

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
        """Recognize the format by its first line."""
        if source.content.startswith(MARK.encode()):
            return Match(0.95, f"the first line is {MARK!r}")
        return Match(0.0, f"the first line is not {MARK!r}")

    def read(self, source: SourceFile, hints: Hints) -> ReadTable:
        """Read settings, column names and rows."""
        text = decode(source, hints.encoding)
        lines = sample_lines(text)
        header = next((number for number, line in enumerate(lines) if line.startswith("t/s;")), None)
        if header is None:
            raise ReaderError(
                f"{source.name}: found no header row; expected a row that begins with t/s; copy the log again"
            )
        names = tuple(lines[header].strip().split(";"))
        # Nothing follows the last semicolon of a row, so its last number is complete.
        layout = Layout(";", ".", names, header + 2, "".join(lines[: header + 1]), len(names), len(names))
        table = read_table(text, layout)
        return replace(table, columns=tuple(map(with_meaning, table.columns)), facts=facts(lines[1:header]))


def with_meaning(column: ReadColumn) -> ReadColumn:
    """Add signal and unit from the column name: d/um is the depth in µm."""
    name, _, unit = column.name.partition("/")
    return replace(column, signal=SIGNALS.get(name), unit=unit or None)


def facts(settings: list[str]) -> dict[str, str]:
    """Return values from the settings, by keys of run.toml."""
    values = dict(line.strip().split("=", 1) for line in settings if "=" in line)
    return {"conditions.normal_load": values["load"]} if "load" in values else {}
