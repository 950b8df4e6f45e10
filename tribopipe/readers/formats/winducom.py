r"""Ducom WINDUCOM 2010 (.dwf): what the software of Ducom's pin-on-disc tribometers saves of a run.

ASCII text, one line a sample, lines ended by a lone CR (CRLF and LF are taken as well):

              TIME;          FF;\r
            0,9150;        4,80;;\r
            1,8240;       16,13;;\r

* The first line names the channels, each right-aligned and followed by a semicolon; TIME comes first.
* Each row holds one number a channel, with a decimal comma, padded with blanks on the left and followed by a
  semicolon; one more semicolon closes the row. A row without it has been cut.
* Nothing else stands in the file: load, track radius and speed are known to whoever ran the test.

Channels: TIME in s since the start (about one sample a second, with jitter), FF the friction force in N, COF or
MU the friction coefficient, WEAR the displacement reading in micrometres, LOAD or NF the normal force in N.
Other channels (SPEED, TEMP, …) are kept without a meaning, since the file does not state in what unit they are.
"""

import re
from dataclasses import replace

from tribopipe.base.errors import ReaderError
from tribopipe.documents.signals import SignalName
from tribopipe.readers.delimited import read_table
from tribopipe.readers.headed_tables import judge_lines
from tribopipe.readers.layout import Layout
from tribopipe.readers.reader import Hints, Holds, Match, ReadColumn, ReadTable
from tribopipe.readers.tables import PLACEHOLDER
from tribopipe.readers.text import Text, decode, sample_lines, split_rows
from tribopipe.results.run import SourceFile

_HEADER = re.compile(r" +TIME;(?: +[^;\s][^;]*;)*\s*")
_ROW = re.compile(rf"(?: *(?:[+-]?\d+(?:,\d+)?|{PLACEHOLDER})?;)+;\s*", re.ASCII | re.IGNORECASE)
_CHANNELS: dict[str, tuple[SignalName, str]] = {
    "TIME": ("time", "s"),
    "FF": ("friction_force", "N"),
    "COF": ("friction_coefficient", "1"),
    "MU": ("friction_coefficient", "1"),
    "WEAR": ("depth", "um"),
    "LOAD": ("normal_force", "N"),
    "NF": ("normal_force", "N"),
}


class WinducomReader:
    """Tables of Ducom's WINDUCOM 2010."""

    name = "ducom-winducom"
    title = "Ducom WINDUCOM 2010 (.dwf)"
    holds: Holds = "signals"
    suffixes = (".dwf",)

    @judge_lines
    def match(self, lines: list[str]) -> Match:
        """Judge by the padded header that starts with TIME, and by the first row where there is one."""
        if not lines or not _HEADER.fullmatch(lines[0]):
            return Match(0.0, "the first line does not contain TIME and other channel names as in WINDUCOM files")
        # A last line may be cut: it is for reading to say so.
        if len(lines) > 2 and not _ROW.fullmatch(lines[1]):
            return Match(
                0.2, "the channel names are as in WINDUCOM files, but the rows do not have the form '0,9150; 4,80;;'"
            )
        return Match(0.95, "the channel names and rows are as in WINDUCOM files")

    def read(self, source: SourceFile, hints: Hints) -> ReadTable:
        """Parse the file; ``ReaderError`` with file and line where it is cut or no WINDUCOM table."""
        text = decode(source, hints.encoding)
        table = read_table(text, _layout(text, hints))
        return replace(table, columns=tuple(map(_with_meaning, table.columns)))


def _layout(text: Text, hints: Hints) -> Layout:
    separator = hints.separator or ";"
    header = sample_lines(text)[0]
    names = [cell for row in split_rows([header], separator) for cell in row.cells]
    # A header without its last separator may be cut in the middle of a name.
    if len(names) < 3 or names[0] != "TIME" or names[-1] or not all(names[:-1]):
        raise ReaderError(
            f"{text.name}, line 1: found {header.strip()[:60]!r}; expected WINDUCOM channel names, such as "
            "'TIME;          FF;'; specify another reader in run.toml, or copy the file again from the instrument"
        )
    width = len(names) + 1
    return Layout(separator, hints.decimal or ",", tuple(names), line=2, header=header, width=width, least=width)


def _with_meaning(column: ReadColumn) -> ReadColumn:
    if column.name not in _CHANNELS:
        return column
    signal, unit = _CHANNELS[column.name]
    return replace(column, signal=signal, unit=unit)
