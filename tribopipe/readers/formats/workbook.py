"""Spreadsheets (.xlsx, .xlsb, .xls, .ods): a table in a sheet, perhaps with lines of text above it.

* .xlsx and .xlsb are zip files with members below xl/; .ods is a zip file whose first member states its type; .xls is
  an OLE2 file with a stream called Workbook or Book.
* The table is found as in delimited text: a row of names, perhaps a row of units, rows of numbers; the rows above it
  are the header, its cells separated by tabs. Line numbers in messages are the row numbers of the sheet.
* One sheet is one test. Several sheets with a table of a test are refused until one of them is named; where time goes
  on from each to the next, as in a test with more rows than a sheet holds, they are segments of one test. Sheets
  without a table, and lists of settings, are left out, hidden sheets with a note; lists are part of the header.
* Numbers are read with all digits stored, whatever a cell shows. Empty cells and errors (#DIV/0!) are missing samples;
  a formula gives the value that the spreadsheet program saved. Numbers stored as text are read with a point, or with
  the decimal separator that run.toml names, or with a comma where one of them shows that it is a decimal one.
* A column of durations is given in seconds, one of times of day or of dates with times in seconds since the first row;
  times of day of several sheets count from the first row of the first sheet.

Reading takes the package python-calamine: pip install "tribopipe[excel]".

The numeric sheet of an Optimol SRV is read as any other; what its columns mean is known:

    Tick | Time | Temperature 1 | … | Frequency | … | Stroke sliding speed average value current | … | Load | … | Stroke
         | [s]  | [°C]          | … | [Hz]      | … | [m/s]                                      | … | [N]  | … | [mm]

* Names stand in row 1, units in brackets in row 2, one row of numbers per second below.
* Friction stands there in several definitions (effective value, integral, peak): none is taken by itself.
* The sliding speed is the mean over a stroke, 2·stroke·frequency.
"""

import json
import re
import zipfile
from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace
from importlib.util import find_spec
from io import BytesIO
from itertools import pairwise
from typing import Any

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.base.errors import ReaderError
from tribopipe.base.units import is_unit_of
from tribopipe.documents.signals import SignalName
from tribopipe.readers.clock_times import OF_DAY, of_day, past_midnight
from tribopipe.readers.delimited import read_table
from tribopipe.readers.headed_tables import bare_key
from tribopipe.readers.layout import Decimal, find_layout
from tribopipe.readers.reader import Hints, Holds, Match, ReadColumn, ReadTable
from tribopipe.readers.subprocess_readers import answer_of
from tribopipe.readers.table_parts import (
    is_time,
    join_parts,
    seconds_since_first,
    several_tests,
    tests_among,
    unknown_sheet,
)
from tribopipe.readers.tables import is_number
from tribopipe.readers.text import Text
from tribopipe.results.run import SourceFile

_MARKS = frozenset({"oelpumptemperature", "strokeslidingspeedaveragevaluecurrent", "frictionabsoluteintegral"})
_SIGNALS: dict[str, tuple[SignalName, str]] = {
    "time": ("time", "time"),
    "temperature1": ("temperature", "temperature"),
    "load": ("normal_force", "force"),
    "strokeslidingspeedaveragevaluecurrent": ("sliding_speed", "speed"),
}
"""Signal and kind of unit by column name."""


def with_srv_meanings(table: ReadTable) -> ReadTable:
    """Report what the columns of an SRV mean; any other table stays as it is."""
    if len(_MARKS & {bare_key(column.name) for column in table.columns}) < 2:
        return table
    columns = []
    for column in table.columns:
        signal, kind = _SIGNALS.get(bare_key(column.name), (None, ""))
        fits = signal is not None and column.unit is not None and is_unit_of(column.unit, kind)
        columns.append(replace(column, signal=signal) if fits else column)
    note = "the columns are those of an Optimol SRV; its sliding speed is the mean over a stroke"
    return replace(table, columns=tuple(columns), notes=(*table.notes, note))


_HEAD_BYTES = 1 << 20
_ZIP = b"PK\x03\x04"
_MEMBER_OF_XLSX = re.compile(rb"PK\x03\x04.{26}xl/", re.DOTALL)
_ODS_TYPE = b"application/vnd.oasis.opendocument.spreadsheet"
_OLE2 = b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1"
_STREAMS = tuple(f"{name}\0".encode("utf-16-le") for name in ("Workbook", "Book", "EncryptedPackage"))
_MOST_BYTES = 1 << 30
_LONGEST_LIST = 200
"""Lines of a sheet of settings."""
_INTERVALS = 3
"""Sampling intervals within which a test goes on in the next sheet."""
_REMEDY = "save the workbook again, without a password, or export the table as text"
_DECIMAL_COMMA = re.compile(r"(?:^|\t)[+-]?\d+,(?:\d{1,2}|\d{4,})(?=\t|$)", re.ASCII | re.MULTILINE)
"""Number stored as text whose comma cannot stand between thousands."""
_DURATION = re.compile(r"PT(-?\d+(?:\.\d+)?(?:e[+-]?\d+)?)S")
_DATE = re.compile(r"\d{4}-\d\d-\d\d(?P<time>T\d\d:\d\d:\d\d(?:\.\d{1,6})?)?")
"""Date with its time, or without one, as calamine gives midnight."""


class WorkbookReader:
    """Spreadsheets."""

    name = "workbook"
    title = "Spreadsheet (.xlsx, .xls, .ods), including exports of an Optimol SRV"
    holds: Holds = "signals"
    suffixes = (".xlsx", ".xls", ".ods")

    def match(self, source: SourceFile) -> Match:
        """Judge by the first members of a zip file, or the streams of an OLE2 file."""
        head = source.content[:_HEAD_BYTES]
        if head.startswith(_ZIP):
            if head.startswith(b"mimetype", 30) and _ODS_TYPE in head[:512]:
                return Match(0.95, "a zip file declared as an OpenDocument spreadsheet")
            if _MEMBER_OF_XLSX.search(head):
                return Match(0.95, "a zip file with members below xl/, as written by Excel")
            return Match(0.1, "a zip file without the members of a spreadsheet")
        if head.startswith(_OLE2):
            if any(name in head or name in _directory(source.content) for name in _STREAMS):
                return Match(0.95, "an OLE2 file with a workbook stream")
            return Match(0.1, "an OLE2 file without a workbook stream")
        return Match(0.0, "neither a zip file nor an OLE2 file")

    def read(self, source: SourceFile, hints: Hints) -> ReadTable:
        """Parse the file; ``ReaderError`` where it is damaged or locked, or holds no table, or several."""
        filled, decimal = _sheets_and_decimal(source, hints)
        chosen = [sheet for sheet in filled if sheet["visible"]]
        if hints.sheet is not None:
            chosen = [sheet for sheet in filled if sheet["name"] == hints.sheet]
            if not chosen:
                raise unknown_sheet(source.name, hints.sheet, [sheet["name"] for sheet in filled])
        tables = _tables(source, chosen, Hints(None, "\t", decimal))
        tests = tests_among(tables)
        if len(tests) > 1 and not _go_on(list(tests.values())):
            raise several_tests(source.name, list(tests))
        joined = join_parts(source.name, "sheet", tables)
        left = [sheet["name"] for sheet in filled if not sheet["visible"] and hints.sheet is None]
        above = _settings(filled, tests or tables) + joined.header
        hidden = [f"sheet {name!r} is hidden and omitted" for name in left]
        return with_srv_meanings(replace(joined, header=above, notes=(*joined.notes, *hidden)))

    def first_sheet(self, source: SourceFile) -> str:
        """Return the cells of the first visible sheet, between tabs; ``ReaderError`` where none holds anything."""
        visible = [sheet["text"] for sheet in _filled_sheets(source, ".") if sheet["visible"]]
        if not visible:
            raise ReaderError(
                f"{source.name}: found no visible sheet with data; expected a table; add the data to a visible sheet"
            )
        return str(visible[0])

    def sheets(self, source: SourceFile, hints: Hints) -> list[str]:
        """Name the visible sheets that hold a table like that of a test. Raises ``ReaderError`` where none does."""
        filled, decimal = _sheets_and_decimal(source, hints)
        visible = [sheet for sheet in filled if sheet["visible"]]
        tables = _tables(source, visible, Hints(None, "\t", decimal))
        return list(tests_among(tables)) or list(tables)[:1]


def _settings(sheets: Sequence[dict[str, Any]], read: Collection[str]) -> str:
    """Return the texts of visible sheets that hold nothing but a list, such as the settings of all tests."""
    lists = (one["text"] for one in sheets if one["visible"] and one["name"] not in read)
    return "".join(text for text in lists if _is_list(text.splitlines()))


def _is_list(lines: Sequence[str]) -> bool:
    numbers = (sum(is_number(cell, ".,") for cell in line.split("\t")) for line in lines)
    return len(lines) <= _LONGEST_LIST and sum(count > 1 for count in numbers) <= 1


def _go_on(tables: Sequence[ReadTable]) -> bool:
    """Return whether time goes on from each table to the next of the same columns, by about one sampling interval."""
    times = [next((column.values for column in table.columns if is_time(column)), None) for table in tables]
    if len({tuple(column.name for column in table.columns) for table in tables}) > 1:
        return False
    return all(
        before is not None
        and after is not None
        and before.dtype.kind == after.dtype.kind == "f"
        and 0 < after[0] - before[-1] <= _INTERVALS * np.median(np.diff(before))
        for before, after in pairwise(times)
    )


def _directory(content: bytes) -> bytes:
    """Give the sector of an OLE2 file where the names of its streams begin."""
    shift = min(int.from_bytes(content[30:32], "little"), 12)
    start = (int.from_bytes(content[48:52], "little") + 1) << shift
    return content[start : start + (1 << shift)]


def _refuse_bombs(source: SourceFile) -> None:
    if source.content.startswith(_OLE2):
        return
    try:
        with zipfile.ZipFile(BytesIO(source.content)) as archive:
            size = sum(member.file_size for member in archive.infolist())
    except Exception as error:  # noqa: BLE001 - damaged archives raise more than BadZipFile
        raise ReaderError(
            f"{source.name}: found a damaged zip file ({error}); expected a complete workbook; {_REMEDY}"
        ) from None
    if size > _MOST_BYTES:
        raise ReaderError(
            f"{source.name}: found {size >> 20} MB in the unpacked sheets; expected at most {_MOST_BYTES >> 20} MB; "
            "export the table as text instead"
        )


def _sheets_and_decimal(source: SourceFile, hints: Hints) -> tuple[list[dict[str, Any]], Decimal]:
    """Return the sheets that are not empty, and the decimal separator of their numbers, even if stored as text."""
    sheets = _filled_sheets(source, hints.decimal or ".")
    if hints.decimal is None and any(_DECIMAL_COMMA.search(sheet["text"]) for sheet in sheets):
        return _filled_sheets(source, ","), ","
    return sheets, hints.decimal or "."


def _filled_sheets(source: SourceFile, decimal: str) -> list[dict[str, Any]]:
    """Give each sheet that is not empty: its name, whether it is visible, and its cells as text."""
    _refuse_bombs(source)
    if find_spec("python_calamine") is None:
        raise ReaderError(
            f"{source.name}: found a spreadsheet, but python-calamine is not installed; expected this package; run "
            'pip install "tribopipe[excel]"'
        )
    answer = json.loads(answer_of("workbook_cells.py", source, decimal, remedy=_REMEDY))
    return [sheet for sheet in answer if sheet["text"].strip()]


def _tables(source: SourceFile, sheets: list[dict[str, Any]], hints: Hints) -> dict[str, ReadTable]:
    """Read the sheets that hold a table; ``ReaderError`` states about the first one what is missing where none does."""
    tables, reasons = {}, []
    begins: dict[str, float] = {}
    for sheet in sheets:
        text = Text(f"{source.name}, sheet {sheet['name']!r}", sheet["text"].encode())
        try:
            layout = find_layout(text, hints)
        except ReaderError as error:
            reasons.append(error)
            continue
        table = _with_times(read_table(text, layout), begins)
        if any(column.first_bad is None for column in table.columns):
            tables[sheet["name"]] = table
        else:
            reasons.append(_without_numbers(text))
    if tables:
        return tables
    if reasons:
        raise reasons[0]
    raise ReaderError(
        f"{source.name}: found no visible sheet with data; expected a header row and data rows; save "
        "the workbook again with its data"
    )


def _without_numbers(text: Text) -> ReaderError:
    return ReaderError(
        f"{text.name}: found no column that contains only numbers; expected a header row and data rows; save the "
        "workbook with the test data in a separate sheet"
    )


def _with_times(table: ReadTable, begins: dict[str, float]) -> ReadTable:
    """Turn columns of durations, of times of day and of dates with times into seconds.

    Times of day count from where their column ``begins``, by its name; a column that is not there is added.
    """
    columns, notes = [], list(table.notes)
    known = any(map(is_time, table.columns))
    for column in table.columns:
        found = _durations(column) or _of_day(column, begins) or _since_first(column, known=known)
        if found:
            notes.append(f"column {column.name!r} contains {found[1]}")
        columns.append(found[0] if found else column)
    return replace(table, columns=tuple(columns), notes=tuple(notes))


def _durations(column: ReadColumn) -> tuple[ReadColumn, str] | None:
    matched = list(_matches(column, _DURATION))
    if not matched or not all(matched):
        return None
    seconds = [float(found[1]) if isinstance(found, re.Match) else np.nan for found in matched]
    return _in_seconds(column, seconds), "durations, which are converted to seconds"


def _of_day(column: ReadColumn, begins: dict[str, float]) -> tuple[ReadColumn, str] | None:
    matched = list(_matches(column, OF_DAY))
    if not matched or not all(matched):
        return None
    seconds = np.array([of_day(found) if isinstance(found, re.Match) else np.nan for found in matched])
    known = ~np.isnan(seconds)
    seconds[known] = past_midnight(seconds[known])
    seconds -= begins.setdefault(column.name, seconds[known][0])
    return _in_seconds(column, seconds), "times of day, which are converted to seconds since the first row"


def _in_seconds(column: ReadColumn, seconds: Sequence[float] | Column) -> ReadColumn:
    return ReadColumn(column.name, np.asarray(seconds, dtype=float), "s", column.signal)


def _since_first(column: ReadColumn, *, known: bool) -> tuple[ReadColumn, str] | None:
    matched = list(_matches(column, _DATE))
    if not matched or not all(matched) or not any(isinstance(found, re.Match) and found["time"] for found in matched):
        return None
    stamps = [found[0] if isinstance(found, re.Match) else "NaT" for found in matched]
    try:
        seconds = seconds_since_first(np.array(stamps, dtype="datetime64[us]"))
    except ValueError:  # a text that looks like a date
        return None
    steps = np.diff(seconds[~np.isnan(seconds)])
    if not (steps.size and steps.min() >= 0 and steps.max() > 0):
        return None
    return ReadColumn(column.name, seconds, "s", None if known else "time"), (
        f"dates since {stamps[0]}, which are converted to seconds"
    )


def _matches(column: ReadColumn, pattern: re.Pattern[str]) -> Iterator[re.Match[str] | str | None]:
    """Match each text; a missing one counts as matched. Nothing where the column holds numbers."""
    if column.first_bad is None:
        return
    for value in column.values:
        yield pattern.fullmatch(value) or ("missing" if not value else None)
