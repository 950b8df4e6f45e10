"""Delimited text: a row of names, perhaps a row of units, and rows of numbers below.

What the reader finds by itself, and the manifest's word overrides:

* encoding: byte order marks, UTF-16 without one, strict UTF-8, then a Chinese, Japanese or Korean one in which a word
  of tribometers stands, cp1252, latin-1;
* separator: tab, semicolon, bar, comma, or runs of blanks. A comma separates only where nothing
  stronger does and numbers are written with a point;
* decimal separator: point or comma.

Line ends may be LF, CRLF, lone CR or a mixture; blank lines are skipped. Lines above the table are
kept verbatim. Units stand in a row above or below the row of names, or inside the names: "Depth [um]",
"Fz (N)", "time / s", "load_N". Rows may end in separators that the header does not have.

"", "NaN", "nan" and "NA" are missing samples, and so are placeholders such as "OVL" or "---", which are counted.
Anything else that is no plain finite number leaves its column as text, with line and text of the first. Where the
head of a file can be understood in two ways that give different numbers, the file is refused rather than guessed.
"""

import csv
import re
from collections.abc import Iterator, Mapping
from dataclasses import replace
from io import BytesIO, TextIOWrapper
from itertools import islice
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tribopipe.base.errors import ReaderError
from tribopipe.base.units import is_same_unit, is_unit
from tribopipe.readers.clock_times import is_clock_time, with_clock_times
from tribopipe.readers.layout import Layout, find_layout
from tribopipe.readers.number_fields import Parsed, parse_fields
from tribopipe.readers.reader import Hints, Holds, Match, Placeholders, ReadColumn, ReadTable, refused
from tribopipe.readers.tables import (
    GROUPED,
    MISSING,
    Table,
    find_table,
    meant_unit,
    split_name,
    unit_in_brackets,
    without_brackets,
)
from tribopipe.readers.text import BLANKS, LONGEST_LINE, SAMPLE_BYTES, Row, Text, decode, split_rows
from tribopipe.results.run import SourceFile

_NO_TABLE = re.compile(r"[{<]|\[(?:[\[{\"]|$)")
"""How JSON and XML begin."""
_WORDS = re.compile(r"[^\W\d_]{3}")
_MOST_CLOSING_LINES = 5
_WIDEST = 1 << 13
"""Columns of the widest map; a table has far fewer."""
_ROWS_AT_ONCE = 50_000
"""Few enough to stay close to the processor."""
_COUNTED_AT_ONCE = 1 << 18


class DelimitedReader:
    """Text tables in whatever dialect, as nearly every instrument can export them."""

    name = "delimited"
    title = "Delimited text (CSV, TSV, whitespace-separated) with a header row"
    holds: Holds = "signals"
    suffixes = (".csv", ".tsv", ".txt")

    def match(self, source: SourceFile) -> Match:
        """Judge by the head whether there is a table; below the confidence of any specific format."""
        head = SourceFile(source.name, source.content[:SAMPLE_BYTES])
        try:
            text = decode(head, partial=len(source.content) > SAMPLE_BYTES)
            table, _ = find_table(text, Hints())
        except ReaderError as error:
            return refused(source, error)
        if not table.fits or table.regularity < 0.5:
            line = table.rows[table.top].line
            return Match(0.2, f"most rows do not have as many fields as the header in line {line}")
        first = table.rows[table.body].cells
        numeric = table.numeric | {n for n in table.textual if n < len(first) and is_clock_time(first[n])}
        if len(numeric) < 2 and table.textual:
            return Match(0.3, _why_texts(table))
        if _NO_TABLE.match(table.rows[0].cells[0]) or any("=" in row.cells for row in table.rows[table.body :]):
            return Match(0.3, "it looks like a document, settings or a program")
        share = len(numeric) / table.width
        return Match(0.5 + 0.2 * share, f"a table of {table.width} columns, {len(numeric)} of them numeric")

    def read(self, source: SourceFile, hints: Hints) -> ReadTable:
        """Parse the file; ``ReaderError`` with file and line where it is no whole, unambiguous table."""
        text = decode(source, hints.encoding)
        layout = find_layout(text, hints)
        text, left_out = without_closing_words(text, layout)
        table = with_clock_times(read_table(text, layout))
        return replace(table, notes=(*table.notes, *left_out))


def _why_texts(table: Table) -> str:
    """Report that most columns hold texts, such as numbers with thousands separators."""
    fields = ((row.line, cell) for row in table.rows[table.body :] for cell in row.cells)
    line, grouped = next(((line, cell) for line, cell in fields if GROUPED.fullmatch(cell)), (0, ""))
    if grouped:
        return (
            f"line {line} contains {grouped!r}; expected numbers without thousands separators; export the table "
            "without them"
        )
    return f"only one of {table.width} columns contains numbers"


def without_closing_words(text: Text, layout: Layout) -> tuple[Text, list[str]]:
    """Leave out what software writes below a table: lines of words without a separator; and report it."""
    left_out: list[str] = []
    # The end alone is looked at: a copy of a long file costs as much as reading it.
    tail = text.content[max(_body_start(text, layout), len(text.content) - LONGEST_LINE) :]
    before = len(text.content) - len(tail)
    while layout.separator != BLANKS and len(left_out) < _MOST_CLOSING_LINES:
        kept = tail.rstrip(b"\r\n \t")
        start = max(kept.rfind(b"\n"), kept.rfind(b"\r")) + 1
        line = kept[start:].decode(errors="replace").strip()
        if not start or layout.separator in line or not _WORDS.match(line):
            break
        left_out.insert(0, f"omitted the line {line[:60]!r} below the table")
        tail = tail[:start]
    return (replace(text, content=text.content[: before + len(tail)]) if left_out else text), left_out


def read_table(text: Text, layout: Layout, *, keep_empty: bool = False) -> ReadTable:
    """Read the body of a table whose layout is known; columns without a name that are empty are left out, or kept.

    Raises ``ReaderError`` where the layout is in doubt, and with the line where a row has too many fields,
    or too few, or is cut.
    """
    if layout.doubt is not None:
        raise ReaderError(layout.doubt)
    if layout.width > _WIDEST:
        raise ReaderError(
            f"{text.name}, line {layout.line}: found {layout.width} columns; expected at most {_WIDEST}; check that "
            "the line endings of the file are intact"
        )
    parsed = _parsed(text, layout)
    _refuse_short_rows(text, layout, parsed[-1])
    if not all(column.missing.all() for column in parsed[len(layout.names) :]):
        raise _too_wide(text, layout)
    names, notes = _unique_names(layout.names)
    notes += _contradicting_units(layout)
    lines = _line_numbers(text, layout, {row for column in parsed for row in _rows_to_name(column)})
    columns = tuple(
        _column(name, column, _unit(layout, number), lines)
        for number, (name, column) in enumerate(zip(names, parsed, strict=False))
        if keep_empty or layout.names[number] or not column.missing.all()
    )
    if text.unterminated and layout.width == layout.least:
        notes.append("the last line has no line ending; its last number may have been cut short")
    return ReadTable(
        columns,
        layout.header,
        (*text.notes, *notes),
        line_of=lambda row: _line_numbers(text, layout, {row})[row],
        decimal=layout.decimal,
    )


def _rows_to_name(parsed: Parsed) -> Iterator[int]:
    """Give the rows whose lines a person may have to look at."""
    if parsed.bad:
        yield parsed.bad[0]
    if parsed.placeholders:
        yield parsed.placeholders[1]


def _column(name: str, parsed: Parsed, unit: str | None, lines: Mapping[int, int]) -> ReadColumn:
    bad = parsed.bad and (lines[parsed.bad[0]], parsed.bad[1])
    gaps = None
    if parsed.placeholders:
        count, row, text = parsed.placeholders
        gaps = Placeholders(count, lines[row], text)
    return ReadColumn(name, parsed.values, unit, first_bad=bad, placeholders=gaps)


def _unique_names(written: tuple[str, ...]) -> tuple[list[str], list[str]]:
    """Make names unique, and report where that took a change."""
    names: dict[str, int] = {}
    notes = []
    for number, name in enumerate(written, 1):
        wanted = unique = name or f"column {number}"
        while unique in names:
            names[wanted] += 1
            unique = f"{wanted} ({names[wanted]})"
        if unique != wanted:
            notes.append(f"column {number} is renamed {unique!r}, since another column is already called {wanted!r}")
        names[unique] = 1
    return list(names), notes


def _unit(layout: Layout, column: int) -> str | None:
    name, row = layout.names[column], _unit_in_row(layout, column)
    return unit_in_brackets(name) or row or split_name(name)[1]


def _unit_in_row(layout: Layout, column: int) -> str | None:
    below = without_brackets(layout.units[column]) if column < len(layout.units) else ""
    return meant_unit(below) if is_unit(below) else None


def _contradicting_units(layout: Layout) -> Iterator[str]:
    """Report columns whose name has another unit than the row of units."""
    for column, name in enumerate(layout.names):
        named, row = split_name(name)[1], _unit_in_row(layout, column)
        if named and row and not is_same_unit(named, row):
            yield (
                f"column {name!r} has another unit in the row of units, {row}, than in its name, {named}; "
                f"{_unit(layout, column)} is used"
            )


def _body_start(text: Text, layout: Layout) -> int:
    return text.start + len(layout.header.encode())


def has_rows(text: Text, layout: Layout) -> bool:
    """Return whether the body of a table has a row."""
    return next(_body_rows(text, layout), None) is not None


def _body_rows(text: Text, layout: Layout) -> Iterator[Row]:
    """Go through the body row by row: slow, for finding the line of what is known to be wrong."""
    stream = BytesIO(text.content)
    stream.seek(_body_start(text, layout))
    line = layout.line
    try:
        for row in split_rows(TextIOWrapper(stream, encoding="utf-8", newline=""), layout.separator):
            line = row.line + layout.line - 1
            yield Row(line, row.cells)
    except csv.Error:
        raise _unclosed(text, line) from None


def _parsed(text: Text, layout: Layout) -> list[Parsed]:
    columns, textual = _columns(text, layout)
    return [
        _from_texts([str(field).strip() for field in values], layout, number) if number in textual else Parsed(values)
        for number, values in enumerate(columns)
    ]


def _columns(text: Text, layout: Layout) -> tuple[list[NDArray[Any]], set[int]]:
    """Parse the body, and name the columns that had to be read as text."""
    textual = set(layout.textual | layout.words)
    try:
        columns = _read_columns(text, layout, textual)
    except ValueError:
        options = _options(text, layout, textual, guess=True)
        for rows in _read_csv(text, layout, _body(text, layout), options):
            textual |= {number for number in range(layout.width) if rows[number].dtype.kind not in "fiu"}
        columns = _read_columns(text, layout, textual)
    infinite = {n for n, values in enumerate(columns) if n not in textual and np.isinf(values).any()}
    if infinite:
        textual |= infinite
        columns = _read_columns(text, layout, textual)
    return columns, textual


def _read_columns(text: Text, layout: Layout, textual: set[int]) -> list[NDArray[Any]]:
    """Parse the body some rows at a time into columns that were set aside for it."""
    body, end = _body(text, layout), 0
    most = _most_rows(body)
    columns = [np.empty(most, object if number in textual else float) for number in range(layout.width)]
    for rows in _read_csv(text, layout, body, _options(text, layout, textual)):
        for number, column in enumerate(columns):
            column[end : end + len(rows)] = rows[number].to_numpy()
        end += len(rows)
    return [column[:end] for column in columns]


def _body(text: Text, layout: Layout) -> memoryview:
    """Return the body without lone CRs.

    Raises ``ReaderError`` where it has no rows, or the first of them is too long, which pandas would shorten without a
    word.
    """
    first = next(_body_rows(text, layout), None)
    if first is None:
        raise ReaderError(
            f"{text.name}, line {layout.line}: found no data rows below the header; expected at least one data row; "
            "export the file again with its data"
        )
    if len(first.cells) > layout.width:
        raise _too_wide(text, layout)
    return _without_lone_returns(text.content, _body_start(text, layout))


def _without_lone_returns(content: bytes, start: int) -> memoryview:
    """Give the rest of a file without the lone CRs after which pandas may lose a separator or make up a row."""
    part = memoryview(content)[start:]
    if content.find(b"\r", start) >= 0:
        codes = np.frombuffer(part, np.uint8)
        returns = np.flatnonzero(codes == ord("\r"))
        if returns[-1] + 1 == codes.size or np.any(codes[returns + 1] != ord("\n")):
            return memoryview(bytes(part).replace(b"\r\n", b"\n").replace(b"\r", b"\n"))
    return part


def _most_rows(part: memoryview) -> int:
    """Return how many rows a body has at most: its line ends, and one where it does not end in one."""
    codes = np.frombuffer(part, np.uint8)
    blocks = range(0, codes.size, _COUNTED_AT_ONCE)
    ends = sum(int(np.count_nonzero(codes[at : at + _COUNTED_AT_ONCE] == ord("\n"))) for at in blocks)
    return ends + int(codes[-1] != ord("\n"))


class _Stream:
    """Bytes for pandas to read, which decodes those of Python's own streams only to encode them again."""

    def __init__(self, part: memoryview) -> None:
        self._left = part

    def read(self, size: int, /) -> bytes:
        taken, self._left = self._left[:size], self._left[size:]
        return bytes(taken)

    def __iter__(self) -> Iterator[bytes]:  # by which pandas knows a file
        while line := self.read(LONGEST_LINE):
            yield line


def _options(text: Text, layout: Layout, textual: set[int], *, guess: bool = False) -> dict[str, Any]:
    """Return the options for pandas; with ``guess``, it infers the types of columns that need not be text."""
    numeric = [number for number in range(layout.width) if number not in textual]
    blanks = layout.separator == BLANKS
    dtypes = dict.fromkeys(textual, object) | ({} if guess else dict.fromkeys(numeric, np.float64))
    return {
        "sep": r"\s+" if blanks else layout.separator,
        "decimal": layout.decimal,
        "header": None,
        "names": range(layout.width),
        "index_col": False,
        # One type for all columns is handled faster than a type for each.
        "dtype": dtypes if textual or guess else np.float64,
        "na_values": dict.fromkeys(numeric, MISSING) if textual else MISSING,
        "keep_default_na": False,
        "quoting": csv.QUOTE_NONE if blanks else csv.QUOTE_MINIMAL,
        "skipinitialspace": text.content.find(b" ", _body_start(text, layout)) >= 0,  # slow, so only where needed
        "encoding": "utf-8",
        "chunksize": _ROWS_AT_ONCE,
        "low_memory": False,  # which would divide what is small already
    }


def _read_csv(text: Text, layout: Layout, part: memoryview, options: dict[str, Any]) -> Iterator[Any]:
    """Read a body some rows at a time."""
    import pandas as pd

    try:
        reader: Any = pd.read_csv(_Stream(part), **options)  # type: ignore[call-overload]
        with reader:
            yield from reader
    except pd.errors.ParserError:
        raise _too_wide(text, layout) from None


def _from_texts(fields: list[str], layout: Layout, column: int) -> Parsed:
    """Turn the fields of a column into numbers, unless they are to stay texts."""
    found = parse_fields(fields, layout.decimal)
    return found if found.bad or column not in layout.words else Parsed(np.array(fields, dtype=object))


def _line_numbers(text: Text, layout: Layout, wanted: set[int]) -> dict[int, int]:
    """Find the lines where rows of the body start."""
    rows = islice(_body_rows(text, layout), max(wanted, default=-1) + 1)
    return {index: row.line for index, row in enumerate(rows) if index in wanted}


def _refuse_short_rows(text: Text, layout: Layout, last: Parsed) -> None:
    """Refuse rows that end early: pandas fills them up, so that their last field is missing."""
    if not last.missing.any() or _is_even(text, layout, len(last.values)):
        return
    final: Row | None = None
    amend = "complete or delete that line"
    for row in _body_rows(text, layout):
        if final is not None and len(final.cells) < layout.least:
            raise _too_short(text, final, layout.least, amend)
        final = row
    whole = layout.width if text.unterminated else layout.least
    if final is not None and len(final.cells) < whole:
        cut = "the file ends in the middle of a row: copy it again from the instrument, or delete the last line"
        raise _too_short(text, final, whole, amend if text.partial else cut)


def _is_even(text: Text, layout: Layout, rows: int) -> bool:
    """Return whether the number of separators proves that all rows are complete."""
    start = _body_start(text, layout)
    if layout.separator == BLANKS or text.content.find(b'"', start) >= 0:
        return False
    return text.content.count(layout.separator.encode(), start) == rows * (layout.width - 1)


def _too_short(text: Text, row: Row, expected: int, remedy: str) -> ReaderError:
    return ReaderError(f"{text.name}, line {row.line}: found {_fields(row)}, expected {expected}; {remedy}")


def _fields(row: Row) -> str:
    return "1 field" if len(row.cells) == 1 else f"{len(row.cells)} fields"


def _too_wide(text: Text, layout: Layout) -> ReaderError:
    """Find the row that has more fields than the header, or else the quote that was never closed."""
    line = layout.line
    for row in _body_rows(text, layout):
        line = row.line
        if len(row.cells) > layout.width or any(row.cells[len(layout.names) :]):
            return ReaderError(
                f"{text.name}, line {line}: found {_fields(row)}, expected {layout.least} as in the "
                "header; correct that line; if commas are decimal separators, export with a different column separator"
            )
    return _unclosed(text, line)


def _unclosed(text: Text, line: int) -> ReaderError:
    return ReaderError(
        f"{text.name}, line {line}: found an unmatched quotation mark in this line or the next; expected a "
        "closing quotation mark; correct that line"
    )
