r"""Kyowa PCD-400A and its kin (DCS-100A, EDX): what the software of these strain-gauge interfaces exports.

Shift-JIS (UTF-8 is taken as well), commas, decimal point, every text in quotation marks:

    "ID番号","PCD-400A"
    "試験日時","2019/06/03","14:05:33"
    "測定CH数",2
    "サンプリング周波数(Hz)",100
    "集録データ数/CH",2000
    "CH名称","Fx","Fz"
    "CH No","CH1","CH2"
    …
    "単位","g","g"
    "Time(sec)","CH1","CH2"
    0.00,1.25,-0.50

* About fifteen labeled lines of unequal length, in Japanese or English; the last is the row of units (単位, Unit),
  which has a label where the rows below have the time.
* Then a row of names; where it is left out, the names are those of "CH名称" or, where these are empty, "CH No".
* Rows of numbers: the time in s, then one number a channel.

g and kg are gram-force and kilogram-force: load cells are calibrated so. What a channel measures is not in the file;
time alone has a meaning. Date and time of the start are written year first. The file states how many samples it should
hold; one that holds another number is read with a note.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

from tribopipe.base.errors import ReaderError
from tribopipe.readers.delimited import read_table
from tribopipe.readers.headed_tables import cells_of, head_lines, layout_below, moment, without_cut_row
from tribopipe.readers.reader import Hints, Holds, Match, ReadColumn, ReadTable, refused
from tribopipe.readers.tables import bare_name, count_in, is_gap, is_number, without_brackets
from tribopipe.readers.text import decode, sample_lines, trimmed
from tribopipe.results.run import SourceFile

_TIME = "Time(sec)"
_TIMES = ("time", "時間")
_LABELS = {
    "ID番号": "model",
    "ID No.": "model",
    "タイトル": "title",
    "Title": "title",
    "試験日時": "started",
    "Test Date": "started",
    "測定CH数": "channels",
    "サンプリング周波数(Hz)": "frequency",
    "集録データ数/CH": "samples",
    "CH名称": "names",
    "CH Name": "names",
    "CH No": "numbers",
    "レンジ": "range",
    "校正係数": "calibration",
    "単位": "units",
    "Unit": "units",
    "Units": "units",
}
_FORCES = {"g": "gf", "kg": "kgf"}


@dataclass(frozen=True)
class _Head:
    """Header above the data."""

    said: Mapping[str, list[str]]
    """Fields by what their label means."""
    names: tuple[str, ...]
    body: int
    """Index of the first line of numbers."""


class KyowaReader:
    """Tables of Kyowa's PCD-400A, quoted, in Shift-JIS."""

    name = "kyowa-pcd"
    title = "Kyowa PCD-400A and EDX (CSV in Shift-JIS)"
    holds: Holds = "signals"

    def match(self, source: SourceFile) -> Match:
        """Judge by the labels of the lines above the row of units."""
        try:
            lines = head_lines(source, _encoding(source))
        except ReaderError as error:
            return refused(source, error)
        head = _head(lines)
        if head is None:
            return Match(0.0, "no unit row labeled 単位 or Unit above the data")
        known = len(head.said)
        if known < 3:
            return Match(0.2, f"the unit row is labeled as in Kyowa files, but only {known} of the lines above it are")
        return Match(0.95, f"{known} lines above the data are labeled as in Kyowa files")

    def read(self, source: SourceFile, hints: Hints) -> ReadTable:
        """Parse the file; ``ReaderError`` with file and line where it is broken."""
        text = decode(source, hints.encoding or _encoding(source))
        lines = sample_lines(text)
        head = _head(lines)
        if head is None:
            raise ReaderError(
                f"{source.name}: found no unit row labeled 単位 or Unit above the data; expected a Kyowa file in "
                "Shift-JIS; specify the encoding or another reader in run.toml, or copy the file again from the "
                "instrument"
            )
        text = without_cut_row(text, ",")
        layout = layout_below(text, lines, head.body, head.names, ",", ".")
        table = read_table(text, replace(layout, units=("", *head.said["units"])))
        columns = tuple(_with_meaning(column, first=at == 0) for at, column in enumerate(table.columns))
        notes = (*table.notes, *_notes(head, table, columns))
        return replace(table, columns=columns, notes=notes, facts=_facts(head))


def _encoding(source: SourceFile) -> str | None:
    """Shift-JIS, unless the file is UTF-8 or UTF-16."""
    return "cp932" if "単位".encode("cp932") in source.content else None


def _head(lines: list[str]) -> _Head | None:
    """Understand the lines above the numbers; none where they are not Kyowa's."""
    said: dict[str, list[str]] = {}
    for index, line in enumerate(lines):
        label, *cells = cells_of(line, ",") or ("",)
        if label in _LABELS:
            said[_LABELS[label]] = trimmed(cells)
        if _LABELS.get(label) == "units":
            below = cells_of(lines[index + 1], ",") if index + 1 < len(lines) else ()
            named = bool(below) and not is_number(below[0], ".") and not (below[0] and is_gap(below[0]))
            names = tuple(trimmed(below)) if named else _names(said)
            return _Head(said, names, index + 2 if named else index + 1)
    return None


def _names(said: Mapping[str, list[str]]) -> tuple[str, ...]:
    """Name the columns of a table without a row of names."""
    numbered = said.get("numbers") or [f"CH{number}" for number in range(1, len(said["units"]) + 1)]
    given = said.get("names") or []
    given += [""] * (len(numbered) - len(given))
    return (_TIME, *(name or number for name, number in zip(given, numbered, strict=False)))


def _with_meaning(column: ReadColumn, *, first: bool) -> ReadColumn:
    if first and bare_name(column.name).casefold() in _TIMES:
        return replace(column, signal="time", unit=column.unit or "s")
    unit = without_brackets(column.unit or "")
    return replace(column, unit=_FORCES.get(unit, unit) or None)


def _notes(head: _Head, table: ReadTable, columns: tuple[ReadColumn, ...]) -> list[str]:
    notes = []
    forces = [
        column.name for column, as_read in zip(columns, table.columns, strict=True) if column.unit != as_read.unit
    ]
    if forces:
        notes.append(f"g and kg of {', '.join(forces)} are interpreted as gram-force and kilogram-force")
    claimed = count_in("".join(head.said.get("samples", [])[:1]))
    present = len(table.columns[0].values)
    if claimed not in (None, present):
        notes.append(f"the header declares {claimed:,} samples; {present:,} are present")
    return notes


def _facts(head: _Head) -> dict[str, str]:
    facts = {"started": moment(" ".join(head.said.get("started", []))) or ""}
    model = "".join(head.said.get("model", [])[:1])
    facts |= {"title": "".join(head.said.get("title", [])[:1]), "instrument": f"Kyowa {model}" if model else ""}
    return {key: value for key, value in facts.items() if value}
