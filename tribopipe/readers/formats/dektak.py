r"""Bruker (formerly Veeco) Dektak stylus profilometers (.csv): one scan.

Text in cp1252 (a micro sign stands in it), fields separated by commas, lines ended by CRLF, some by CR CR LF:

    Scan Parameters
    Scan Type,Standard Scan
    Stylus,Radius: 2.5 µm
    Resolution,0.156 um/sample
    ...
    Analytical Results
    Function,R.Cur Pos,R.Cur Width,M.Cur Pos,M.Cur Width,Result
    Ra,468.0 um,0.0 um,733.0 um,0.0 um,0.00525 um

    Scan Data
    Lateral um,Raw Micrometer,
    0.0,-0.00933,,
    0.2,-0.00760,,

* Sections have a name on a line of its own. "Scan Data" comes last, or "Data" alone where Vision64 exported nothing
  but the scan: a row of names that end in their units ("um", "Micrometer", "Angstrom", "(nm)", …), and one row a
  sample.
* Rows close in more separators than there are names: the columns behind them are empty. A row without them was cut.
* Lateral positions are rounded, to 0.1 µm as a rule, so that their steps alternate; closer samples repeat them.
* Heights count upwards. "Raw" ones are as they were scanned, not leveled; only they are taken where others stand
  next to them, which the software made of them.
"""

import re
from dataclasses import dataclass, replace

from tribopipe.base.errors import ReaderError
from tribopipe.base.units import is_unit
from tribopipe.readers.delimited import read_table
from tribopipe.readers.headed_tables import judge_lines
from tribopipe.readers.layout import Layout
from tribopipe.readers.number_fields import is_mostly_numbers
from tribopipe.readers.reader import Axis, Hints, Holds, Match, ReadColumn, ReadTable
from tribopipe.readers.tables import split_name
from tribopipe.readers.text import Text, decode, sample_lines, split_rows, trimmed
from tribopipe.results.run import SourceFile

_SECTIONS = ("scan data", "data")
_NAMES = re.compile(r"\s*lateral\b", re.IGNORECASE)
_UNITS = {"a": "angstrom", "å": "angstrom", "angstroms": "angstrom", "microns": "um", "micrometers": "um"}


class DektakReader:
    """Scans of a Dektak stylus profilometer."""

    name = "dektak"
    title = "Bruker Dektak stylus scan (.csv)"
    holds: Holds = "profile"
    suffixes = (".csv",)

    @judge_lines
    def match(self, lines: list[str]) -> Match:
        """Judge by the sections and by the row of names that starts with Lateral."""
        if _names_at(lines) is not None:
            return Match(0.95, "a data section starts with the column 'Lateral', as in Dektak files")
        if lines and _bare(lines[0]) == "scan parameters":
            return Match(0.6, "the first line is Dektak's 'Scan Parameters'")
        return Match(0.0, "no data section that starts with the column 'Lateral'")

    def read(self, source: SourceFile, hints: Hints) -> ReadTable:
        """Parse the file; ``ReaderError`` with file and line where it is cut or no Dektak scan."""
        text = decode(source, hints.encoding)
        header = _find_header(text, hints.separator or ",")
        layout = Layout(
            header.separator,
            hints.decimal or ".",
            header.names,
            line=header.line,
            header=header.verbatim,
            width=header.width,
            least=header.width,
        )
        table = read_table(text, layout)
        columns = [_with_unit(column) for column in table.columns]
        return replace(table, columns=tuple(_with_axes(columns)))


@dataclass(frozen=True)
class _Header:
    """Header above the samples."""

    separator: str
    names: tuple[str, ...]
    line: int
    """Number of the first line of samples."""
    verbatim: str
    width: int
    """Fields of a row, empty ones behind its last separator included."""


def _bare(line: str) -> str:
    return line.strip(" \t\r\n,;").lower()


def _names_at(lines: list[str]) -> int | None:
    """Find the row of names in the section of samples."""
    section = next((at for at, line in enumerate(lines) if _bare(line) in _SECTIONS), len(lines))
    named = next((at for at in range(section + 1, len(lines)) if _bare(lines[at])), None)
    return named if named is not None and _NAMES.match(lines[named]) else None


def _find_header(text: Text, separator: str) -> _Header:
    """Find names and first row. Raises ``ReaderError`` where either is missing."""
    lines = sample_lines(text)
    at = _names_at(lines)
    if at is None or not lines[at].endswith(("\r", "\n")):
        raise ReaderError(
            f"{text.name}: found no section 'Scan Data' with a header row such as 'Lateral um,Raw Micrometer,'; "
            "expected this section below Dektak's 'Scan Parameters'; export the scan again, or specify another "
            "reader in run.toml"
        )
    names = [cell for row in split_rows([lines[at]], separator) for cell in row.cells]
    below = [line for line in lines[at + 1 :] if not line.isspace()]
    if text.unterminated and len(below) == 1:
        raise ReaderError(
            f"{text.name}: found the end of the file in the first data row; expected complete rows; copy the file "
            "again from the instrument"
        )
    first = next(split_rows(below, separator), None)
    width = max(len(first.cells), len(trimmed(names))) if first else len(names)
    verbatim = "".join(lines[: at + 1])
    return _Header(separator, tuple(names[:width]), at + 2, verbatim, width)


def _with_unit(column: ReadColumn) -> ReadColumn:
    """Remove the unit from the end of a name: "Raw Micrometer", "Lateral(um)"."""
    word = split_name(column.name)[1] or column.name.rpartition(" ")[2].strip("()[]")
    unit = next((one for one in (_UNITS.get(word.lower()), word, word.lower()) if one and is_unit(one)), None)
    return replace(column, unit=unit)


def _with_axes(columns: list[ReadColumn]) -> list[ReadColumn]:
    """Name position and height: of several heights the raw ones, else the first."""
    heights = [column for column in columns[1:] if is_mostly_numbers(column)]
    raw = [column for column in heights if column.name.lower().startswith("raw")] or heights
    axes: dict[str, Axis] = {column.name: "z" for column in raw[:1]}
    return [replace(columns[0], axis="x"), *(replace(column, axis=axes.get(column.name)) for column in columns[1:])]
