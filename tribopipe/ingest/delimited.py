"""Delimited text: a row of names, perhaps a row of units, and rows of numbers below.

What the reader finds by itself, and the manifest's word overrides:

* encoding: byte order marks, UTF-16 without one, strict UTF-8, then cp1252, then latin-1;
* separator: tab, semicolon, bar, comma, or runs of blanks. A comma separates only where nothing
  stronger does and numbers are written with a point;
* decimal sign: point or comma.

Line ends may be LF, CRLF, lone CR or a mixture; blank lines are skipped. Lines above the table are
kept verbatim. Units stand in a row above or below the row of names, or inside the names: "Depth [um]",
"Fz (N)", "time / s". Rows may end in separators that the header lacks.

"", "NaN", "nan" and "NA" are missing samples; anything else that is no plain finite number leaves its
column as text. Where the head of a file can be understood in two ways that give different numbers, the
file is refused rather than guessed.
"""

import csv
import math
import os
import re
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from io import BytesIO, TextIOWrapper
from itertools import islice
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tribopipe.errors import ReaderError
from tribopipe.ingest.layout import Decimal, Layout, find_layout
from tribopipe.ingest.names import split_name, without_brackets
from tribopipe.ingest.reader import Hints, Holds, Match, ReadColumn, ReadTable
from tribopipe.ingest.tables import MISSING, find_table, is_number
from tribopipe.ingest.text import BLANKS, LINE_END, LONGEST_LINE, SAMPLE_BYTES, Row, Text, decode, split_rows
from tribopipe.run import SourceFile
from tribopipe.units import is_unit

_NO_TABLE = re.compile(r"[{<]|\[(?:[\[{\"]|$)")
"""How JSON and XML begin."""
_WORDS = re.compile(r"[^\W\d_]{3}")
_MOST_CLOSING_LINES = 5
_PIECE_BYTES = 3 << 20
_THREADS = 4
_SPARE = 1.05
"""Room for rows over what the pieces read so far let expect."""


class DelimitedReader:
    """Text tables in whatever dialect, as nearly every instrument can export them."""

    name = "delimited"
    title = "Delimited text (CSV, TSV, columns between blanks) with a row of names"
    holds: Holds = "signals"

    def match(self, source: SourceFile) -> Match:
        """Judge by the head whether there is a table; below the confidence of any specific format."""
        head = SourceFile(source.name, source.content[:SAMPLE_BYTES])
        try:
            text = decode(head, partial=len(source.content) > SAMPLE_BYTES)
            table, _ = find_table(text, Hints())
        except ReaderError as error:
            return Match(0.0, str(error).removeprefix(source.name).lstrip(":, "))
        if not table.fits or table.regularity < 0.5:
            line = table.rows[table.top].line
            return Match(0.2, f"most rows have another number of fields than the names in line {line}")
        if len(table.numeric) < 2 and table.textual:
            return Match(0.3, f"of {table.width} columns a single one holds numbers")
        if _NO_TABLE.match(table.rows[0].cells[0]) or any("=" in row.cells for row in table.rows[table.body :]):
            return Match(0.3, "it is written as a document, settings or a program are")
        share = len(table.numeric) / table.width
        return Match(0.5 + 0.2 * share, f"a table of {table.width} columns, {len(table.numeric)} of them numbers")

    def read(self, source: SourceFile, hints: Hints) -> ReadTable:
        """Parse the file; ``ReaderError`` with file and line where it is no whole, unambiguous table."""
        text = decode(source, hints.encoding)
        layout = find_layout(text, hints)
        text, left_out = _without_closing_words(text, layout)
        table = read_table(text, layout)
        return replace(table, notes=(*table.notes, *left_out))


def _without_closing_words(text: Text, layout: Layout) -> tuple[Text, list[str]]:
    """Leave out what software writes below a table: lines of words without a separator; and say so."""
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
        left_out.insert(0, f"left out the line {line[:60]!r} below the table")
        tail = tail[:start]
    return (replace(text, content=text.content[: before + len(tail)]) if left_out else text), left_out


class _Parsed(NamedTuple):
    """One column, with row and text of its first field that is no number."""

    values: NDArray[Any]
    bad: tuple[int, str] | None = None

    @property
    def missing(self) -> NDArray[np.bool_]:
        """Whether each field is empty."""
        return np.isnan(self.values) if self.bad is None else np.asarray(self.values == "", dtype=bool)


def read_table(text: Text, layout: Layout) -> ReadTable:
    """Read the body of a table whose layout is known.

    Raises ``ReaderError`` where the layout is in doubt, and with the line where a row has too many fields,
    or too few, or is cut.
    """
    if layout.doubt is not None:
        raise ReaderError(layout.doubt)
    parsed = _parsed(text, layout)
    _refuse_short_rows(text, layout, parsed[-1])
    if not all(column.missing.all() for column in parsed[len(layout.names) :]):
        raise _too_wide(text, layout)
    names, notes = _unique_names(layout.names)
    lines = _line_numbers(text, layout, {column.bad[0] for column in parsed if column.bad})
    columns = tuple(
        ReadColumn(
            name, column.values, _unit(layout, number), first_bad=column.bad and (lines[column.bad[0]], column.bad[1])
        )
        for number, (name, column) in enumerate(zip(names, parsed, strict=False))
        if layout.names[number] or not column.missing.all()
    )
    if text.unterminated and layout.width == layout.least:
        notes.append("the last line has no line end; its last number may have been cut short")
    return ReadTable(columns, layout.header, (*text.notes, *notes))


def _unique_names(written: tuple[str, ...]) -> tuple[list[str], list[str]]:
    """Make names unique, and say where that took a change."""
    names: list[str] = []
    notes = []
    for number, name in enumerate(written, 1):
        wanted = unique = name or f"column {number}"
        times = 1
        while unique in names:
            times += 1
            unique = f"{wanted} ({times})"
        if times > 1:
            notes.append(f"column {number} is called {unique!r}, since another is {wanted!r} already")
        names.append(unique)
    return names, notes


def _unit(layout: Layout, column: int) -> str | None:
    below = without_brackets(layout.units[column]) if column < len(layout.units) else ""
    return split_name(layout.names[column])[1] or (below if below and is_unit(below) else None)


def _body_start(text: Text, layout: Layout) -> int:
    return text.start + len(layout.header.encode())


def _body_rows(text: Text, layout: Layout, start: int | None = None) -> Iterator[Row]:
    """Go through the body row by row: slow, for finding the line of what is known to be wrong."""
    stream = BytesIO(text.content)
    stream.seek(_body_start(text, layout) if start is None else start)
    line = layout.line
    try:
        for row in split_rows(TextIOWrapper(stream, encoding="utf-8", newline=""), layout.separator):
            line = row.line + layout.line - 1
            yield Row(line, row.cells)
    except csv.Error:
        raise _unclosed(text, line) from None


def _parsed(text: Text, layout: Layout) -> list[_Parsed]:
    columns, textual = _columns(text, layout)
    return [
        _from_texts([str(field).strip() for field in values], layout.decimal) if number in textual else _Parsed(values)
        for number, values in enumerate(columns)
    ]


def _columns(text: Text, layout: Layout) -> tuple[list[NDArray[Any]], set[int]]:
    """Parse the body, and name the columns that had to be read as text."""
    textual = set(layout.textual)
    try:
        columns = _read_columns(text, layout, textual)
    except ValueError:
        guessed = _read_csv(text, layout, textual, guess=True)
        textual |= {number for number in range(layout.width) if guessed[number].dtype.kind not in "fiu"}
        columns = _read_columns(text, layout, textual)
    infinite = {n for n, values in enumerate(columns) if n not in textual and np.isinf(values).any()}
    if infinite:
        textual |= infinite
        columns = _read_columns(text, layout, textual)
    return columns, textual


def _read_columns(text: Text, layout: Layout, textual: set[int]) -> list[NDArray[Any]]:
    """Parse the body piece by piece in threads: pandas holds no lock while it parses."""
    starts = _pieces(text, layout)
    spans = list(zip(starts, [*starts[1:], len(text.content)], strict=True))
    columns = [np.empty(0, object if number in textual else float) for number in range(layout.width)]
    rows = 0
    with ThreadPoolExecutor(max_workers=min(_THREADS, os.cpu_count() or 1)) as pool:
        pieces = pool.map(lambda span: _read_csv(text, layout, textual, *span), spans)
        for (_, end), piece in zip(spans, pieces, strict=True):
            filled, rows = rows, rows + len(piece)
            if rows > len(columns[0]):
                share = (end - starts[0]) / (spans[-1][1] - starts[0])
                columns = [_with_room(column, filled, math.ceil(rows / share * _SPARE)) for column in columns]
            for number, column in enumerate(columns):
                column[filled:rows] = piece[number].to_numpy()
    return [column[:rows] for column in columns]


def _with_room(column: NDArray[Any], filled: int, room: int) -> NDArray[Any]:
    """Return a longer column: room for all rows from the first piece on, since joining takes the memory twice."""
    longer = np.empty(room, column.dtype)
    longer[:filled] = column[:filled]
    return longer


def _pieces(text: Text, layout: Layout) -> list[int]:
    """Find where to divide the body: between rows, so nowhere if quotes may hold line ends.

    Raises ``ReaderError`` where the first row of a piece is too long, which pandas would shorten without a word.
    """
    starts = [_body_start(text, layout)]
    if text.content.find(b'"', starts[0]) < 0:
        while (end := LINE_END.search(text.content, starts[-1] + _PIECE_BYTES)) and end.end() < len(text.content):
            starts.append(end.end())
    firsts = [next(_body_rows(text, layout, start), None) for start in starts]
    if firsts[0] is None:
        raise ReaderError(
            f"{text.name}, line {layout.line}: found no row of numbers below the names; expected at least one; "
            "export the file again with its data"
        )
    if any(first is not None and len(first.cells) > layout.width for first in firsts):
        raise _too_wide(text, layout)
    return starts


def _stream(content: bytes, start: int, end: int) -> BytesIO:
    """Open part of a file, without the lone CRs after which pandas may lose a separator or make up a row."""
    if content.find(b"\r", start, end) < 0:
        return _Piece(content, start, end)
    codes = np.frombuffer(content, np.uint8, end - start, start)
    returns = np.flatnonzero(codes == ord("\r"))
    if returns.size and (returns[-1] + 1 == codes.size or np.any(codes[returns + 1] != ord("\n"))):
        return BytesIO(content[start:end].replace(b"\r\n", b"\n").replace(b"\r", b"\n"))
    return _Piece(content, start, end)


class _Piece(BytesIO):
    """Part of a file's bytes, not copied."""

    def __init__(self, content: bytes, start: int, end: int) -> None:
        super().__init__(content)
        self.seek(start)
        self._end = end

    def read(self, size: int | None = -1, /) -> bytes:
        left = self._end - self.tell()
        return super().read(left if size is None or size < 0 else min(size, left))

    read1 = read


def _read_csv(
    text: Text, layout: Layout, textual: set[int], start: int = 0, end: int | None = None, *, guess: bool = False
) -> Any:
    import pandas as pd

    start = start or _body_start(text, layout)
    numeric = [number for number in range(layout.width) if number not in textual]
    blanks = layout.separator == BLANKS
    options: dict[str, Any] = {
        "dtype": dict.fromkeys(textual, object) | ({} if guess else dict.fromkeys(numeric, np.float64)),
        "na_values": dict.fromkeys(numeric, MISSING),
        "quoting": csv.QUOTE_NONE if blanks else csv.QUOTE_MINIMAL,
        "skipinitialspace": text.content.find(b" ", start, end) >= 0,  # slow, so only where needed
    }
    try:
        return pd.read_csv(
            _stream(text.content, start, len(text.content) if end is None else end),
            sep=r"\s+" if blanks else layout.separator,
            decimal=layout.decimal,
            header=None,
            names=range(layout.width),
            index_col=False,
            keep_default_na=False,
            encoding="utf-8",
            low_memory=False,  # bit by bit, types would be guessed anew and columns joined
            **options,
        )
    except pd.errors.ParserError:
        raise _too_wide(text, layout) from None


def _from_texts(fields: list[str], decimal: Decimal) -> _Parsed:
    """Turn fields into numbers, or leave all as they are where one is none."""
    numbers = np.full(len(fields), math.nan)
    for row, field in enumerate(fields):
        if field in MISSING:
            continue
        if not is_number(field, decimal) or not math.isfinite(number := float(field.replace(decimal, "."))):
            return _Parsed(np.array(fields, dtype=object), (row, field))
        numbers[row] = number
    return _Parsed(numbers)


def _line_numbers(text: Text, layout: Layout, wanted: set[int]) -> dict[int, int]:
    """Find the lines where rows of the body start."""
    rows = islice(_body_rows(text, layout), max(wanted, default=-1) + 1)
    return {index: row.line for index, row in enumerate(rows) if index in wanted}


def _refuse_short_rows(text: Text, layout: Layout, last: _Parsed) -> None:
    """Refuse rows that end early: pandas fills them up, so that their last field is missing."""
    if not last.missing.any() or _is_even(text, layout, len(last.values)):
        return
    final: Row | None = None
    for row in _body_rows(text, layout):
        if final is not None and len(final.cells) < layout.least:
            raise _too_short(text, final, layout.least, "complete or delete that line")
        final = row
    whole = layout.width if text.unterminated else layout.least
    if final is not None and len(final.cells) < whole:
        remedy = "the file ends in the middle of a row: copy it again from the instrument, or delete that line"
        raise _too_short(text, final, whole, remedy)


def _is_even(text: Text, layout: Layout, rows: int) -> bool:
    """Tell whether the number of separators proves that no row lacks one."""
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
                "header; mend that line; where commas are decimal signs, export with another separator"
            )
    return _unclosed(text, line)


def _unclosed(text: Text, line: int) -> ReaderError:
    return ReaderError(
        f"{text.name}, line {line}: found a quotation mark without its partner, here or in the next line; expected "
        "quoted fields to end in one; mend that line"
    )
