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

import codecs
import csv
import os
import re
from collections import Counter
from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import cached_property
from io import BytesIO, TextIOWrapper
from itertools import islice, pairwise
from math import isfinite, nan
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tribopipe.errors import ReaderError
from tribopipe.ingest.reader import Hints, Match, ReadColumn, ReadTable
from tribopipe.run import SourceFile
from tribopipe.units import is_unit

Decimal = Literal[".", ","]

BLANKS = " "
"""As a separator: runs of blanks and tabs."""
_STRONG_SEPARATORS = ("\t", ";", "|")
_SEPARATORS = (*_STRONG_SEPARATORS, ",", BLANKS)
_SAMPLE_BYTES = 1 << 19
_SAMPLE_LINES = 300
_PIECE_BYTES = 3 << 20
_THREADS = 4
_LONGEST_LINE = 1 << 17
_MOST_COLUMNS = 1000
_CONTROLS = bytes(set(range(32)) - set(b"\t\n\v\f\r\x1a\x1b"))
_LINE_END = re.compile(rb"\r\n?|\n")
_LINE = re.compile(r"[^\r\n]*(?:\r\n|\r|\n)|[^\r\n]+")
_MISSING = ("", "NaN", "nan", "NA")
_NUMBER = {
    signs: re.compile(rf"[+-]?(?:{digits})(?:[eE][+-]?\d+)?", re.ASCII)
    for signs, digits in {
        ".": r"\d+\.?\d*|\.\d+",
        ",": r"\d+(?:,\d+)?",
        ".,": r"\d+\.?\d*|\.\d+|\d+,\d+",
    }.items()
}
_INTEGER = re.compile(r"[+-]?\d+", re.ASCII)
_MAYBE_THOUSANDS = re.compile(r"[+-]?[1-9]\d{0,2}[.,]\d{3}", re.ASCII)
_UNIT_IN_WORD = re.compile(r"(?P<bare>[^\s/]+)/(?P<unit>\S+)")
_UNITS_IN_NAMES = (
    re.compile(r"(?P<bare>.+?)\s*\[(?P<unit>[^\[\]]*)\]"),
    re.compile(r"(?P<bare>.+?)\s*\((?P<unit>(?:[^()]|\([^()]*\))*)\)"),
    re.compile(r"(?P<bare>.+)\s+/\s+(?P<unit>\S+)"),
    _UNIT_IN_WORD,
)
_NAME_AMONG_BLANKS = re.compile(r"\S+(?:[ \t]*(?:\[[^\]]*\]|\([^)]*\))|[ \t]+/[ \t]+\S+)?")
_UNIT_ROW_LABELS = ("unit", "units", "einheit", "einheiten", "単位", "单位")
_ASK_FOR_SEPARATOR = (
    "expected to see whether commas separate columns or are decimal signs; name separator and decimal in run.toml"
)


class DelimitedReader:
    """Text tables in whatever dialect, as nearly every instrument can export them."""

    name = "delimited"
    title = "Delimited text (CSV, TSV, columns between blanks) with a row of names"

    def match(self, source: SourceFile) -> Match:
        """Judge by the head whether there is a table; below the confidence of any specific format."""
        head = SourceFile(source.name, source.content[:_SAMPLE_BYTES])
        try:
            text = decode(head, partial=len(source.content) > _SAMPLE_BYTES)
            table, _ = _find_table(text, Hints())
        except ReaderError as error:
            return Match(0.0, str(error).removeprefix(source.name).lstrip(":, "))
        if not table.fits or table.regularity < 0.5:
            line = table.rows[table.top].line
            return Match(0.2, f"most rows have another number of fields than the names in line {line}")
        share = len(table.numeric) / table.width
        return Match(0.5 + 0.2 * share, f"a table of {table.width} columns, {len(table.numeric)} of them numbers")

    def read(self, source: SourceFile, hints: Hints) -> ReadTable:
        """Parse the file; ``ReaderError`` with file and line where it is no whole, unambiguous table."""
        text = decode(source, hints.encoding)
        return read_table(text, find_layout(text, hints))


# --- names and units ---


def split_name(name: str) -> tuple[str, str | None]:
    """Split a column's name as a header writes it into name and unit."""
    for pattern in _UNITS_IN_NAMES:
        matched = pattern.fullmatch(name)
        if matched is None:
            continue
        bare, unit = matched["bare"].rstrip(" /"), matched["unit"].strip()
        # "m/s" and "rev/min" alone are units, not names with one.
        if bare and is_unit(unit) and not (pattern is _UNIT_IN_WORD and is_unit(bare)):
            return bare, unit or None
    return name, None


def bare_name(name: str) -> str:
    """Strip the unit off a column's name: "Depth [um]" is "Depth"."""
    return split_name(name)[0]


def _without_brackets(cell: str) -> str:
    return cell[1:-1].strip() if cell[:1] + cell[-1:] in ("[]", "()") else cell


def _is_unit_row(cells: Iterable[str]) -> bool:
    units = [_without_brackets(cell) for cell in cells if cell]
    if units and units[0].lower() in _UNIT_ROW_LABELS:
        del units[0]
    return not all(map(_INTEGER.fullmatch, units)) and all(map(is_unit, units))


# --- from bytes to text ---


@dataclass(frozen=True)
class Text:
    """A file as UTF-8, whatever it was before."""

    name: str
    """Name of the file."""
    content: bytes
    start: int = 0
    """Where the text starts, behind a byte order mark."""
    partial: bool = False
    """Whether this is only the beginning of the file."""
    notes: tuple[str, ...] = ()
    """What a person should know about the encoding."""

    @property
    def unterminated(self) -> bool:
        """Whether the last line has no line end."""
        return not self.partial and not self.content.endswith((b"\r", b"\n"))


def decode(source: SourceFile, encoding: str | None = None, *, partial: bool = False) -> Text:
    """Decode a file by the encoding named, or find it.

    Raises ``ReaderError`` where the file is empty or binary, where the encoding is unknown, or where
    the file is not in it.
    """
    if not source.content:
        raise ReaderError(
            f"{source.name}: found an empty file; expected a row of names and rows of numbers; "
            "copy it again from the instrument"
        )
    encoding = encoding or _utf16(source.content)
    text = _guessed(source, partial) if encoding is None else _as_named(source, encoding, partial)
    _refuse_binary(text)
    return text


def _utf16(content: bytes) -> str | None:
    """Recognise UTF-16 by its byte order mark, or by the zeros in the codes of ASCII letters."""
    if content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return "utf-16"
    head = content[:4096]
    for encoding, zeros in (("utf-16-le", head[1::2]), ("utf-16-be", head[::2])):
        if zeros.count(0) > 0.6 * len(zeros):
            return encoding
    return None


def _guessed(source: SourceFile, partial: bool) -> Text:
    content = source.content
    start = len(codecs.BOM_UTF8) if content.startswith(codecs.BOM_UTF8) else 0
    try:
        if not content.isascii():
            _strictly(content, "utf-8", partial)
    except UnicodeDecodeError as error:
        cut = error.reason == "unexpected end of data" and not content[: error.start].isascii()
        if start or cut:
            raise _undecodable(source.name, "utf-8", error) from None
        return _western(source, partial)
    return Text(source.name, content, start, partial)


def _western(source: SourceFile, partial: bool) -> Text:
    try:
        encoding, text = "cp1252", _strictly(source.content, "cp1252", partial)
    except UnicodeDecodeError:
        encoding, text = "latin-1", _strictly(source.content, "latin-1", partial)
    note = f"read as {encoding}, since it is no UTF-8; name the encoding in run.toml if letters are wrong"
    return Text(source.name, text.encode(), 0, partial, (note,))


def _as_named(source: SourceFile, encoding: str, partial: bool) -> Text:
    try:
        "".encode(encoding)
    except (LookupError, ValueError):
        raise ReaderError(
            f"{source.name}: found the unknown encoding {encoding!r} in run.toml; expected one such as "
            "'utf-8', 'cp1252' or 'shift_jis'; correct it"
        ) from None
    try:
        text = _strictly(source.content, encoding, partial).removeprefix("\ufeff")
        return Text(source.name, text.encode(), 0, partial)
    except UnicodeError as error:
        raise _undecodable(source.name, encoding, error) from None


def _strictly(content: bytes, encoding: str, partial: bool) -> str:
    return codecs.getincrementaldecoder(encoding)().decode(content, final=not partial)


def _undecodable(name: str, encoding: str, error: UnicodeError) -> ReaderError:
    where = f"byte {error.start}" if isinstance(error, UnicodeDecodeError) else "a character"
    return ReaderError(
        f"{name}: found {where}, which is no {encoding}; expected the whole file in that encoding; copy "
        "it again from the instrument, or name its encoding in run.toml"
    )


def _refuse_binary(text: Text) -> None:
    zero = text.content.find(b"\0")
    head = text.content[:_LONGEST_LINE]
    controls = len(head) - len(head.translate(None, _CONTROLS))
    if zero < 0 and controls <= len(head) // 100:
        return
    found = f"a zero byte at offset {zero}" if zero >= 0 else f"{controls} control characters"
    raise ReaderError(
        f"{text.name}: found {found}; expected text; export the table as text, or name the reader for this "
        "format in run.toml"
    )


# --- lines and rows ---


class Row(NamedTuple):
    """One line split into fields; several lines where a quoted field holds line ends."""

    line: int
    """Number of the first line, counted from 1."""
    cells: list[str]


def sample_lines(text: Text) -> list[str]:
    """Give the first lines with their ends, whole ones only, up to a few hundred.

    Raises ``ReaderError`` where there is nothing but blanks, or a line too long for a table.
    """
    lines, rest = _lines_from(text, text.start)
    for number, line in enumerate([*lines, rest], 1):
        if len(line) > _LONGEST_LINE:
            raise ReaderError(
                f"{text.name}, line {number}: found more than {_LONGEST_LINE} characters in one line; "
                f"expected a table of at most {_MOST_COLUMNS} columns; check that this file is one and "
                "has kept its line ends"
            )
    if not rest and len(lines) < _SAMPLE_LINES and all(map(str.isspace, lines)):
        raise ReaderError(
            f"{text.name}: found nothing but blanks; expected a row of names and rows of numbers; copy the "
            "file again from the instrument"
        )
    return lines


def _lines_from(text: Text, start: int) -> tuple[list[str], str]:
    """Give a sample of lines, and the beginning of the next one where it may be cut."""
    block = text.content[start : start + _SAMPLE_BYTES]
    found = _LINE.finditer(block.decode(errors="ignore"))
    lines = [line[0] for line in islice(found, _SAMPLE_LINES + 1)]
    at_end = not text.partial and start + len(block) == len(text.content)
    rest = "" if at_end or len(lines) > _SAMPLE_LINES or not lines else lines.pop()
    return lines[:_SAMPLE_LINES], rest


def split_rows(lines: Iterable[str], separator: str) -> Iterator[Row]:
    """Split lines into fields stripped of blanks, leaving out blank lines.

    Raises ``csv.Error`` where a quoted field runs on without end.
    """
    if separator == BLANKS:
        for number, line in enumerate(lines, 1):
            if not line.isspace():
                yield Row(number, re.split(r"[ \t]+", line.strip(" \t\r\n")))
        return
    reader = csv.reader(lines, delimiter=separator, skipinitialspace=True)
    number = 1
    for fields in reader:
        cells = [field.strip() for field in fields]
        if len(cells) > 1 or any(cells):
            yield Row(number, cells)
        number = reader.line_num + 1


def _sampled(lines: list[str], separator: str) -> list[Row]:
    try:
        return list(split_rows(lines, separator))
    except csv.Error:
        return []


def _trimmed(cells: Iterable[str]) -> list[str]:
    kept = list(cells)
    while kept and not kept[-1]:
        del kept[-1]
    return kept


# --- the table in the head of the file ---


@dataclass(frozen=True)
class Layout:
    """Where the table stands in a text, and how it is written."""

    separator: str
    decimal: Decimal
    names: tuple[str, ...]
    """As the header writes them, "" where it leaves one out."""
    line: int
    """Number of the first line of the body."""
    header: str
    """Everything above the body, verbatim."""
    width: int
    """Fields of a row, empty ones behind its last separator included."""
    least: int
    """Fewest fields of a row that is whole."""
    units: tuple[str, ...] = ()
    """The row of units, where there is one."""
    textual: frozenset[int] = frozenset()
    """Columns known to hold something other than numbers."""
    doubt: str | None = None
    """Why the numbers might be read in another way than meant."""


@dataclass(frozen=True)
class _Table:
    """What one separator makes of the sample."""

    separator: str
    signs: str
    """Decimal signs that numbers may have."""
    rows: list[Row]
    body: int
    """Index of the first row below the header."""
    width: int
    numeric: frozenset[int]
    """Columns of numbers."""
    textual: frozenset[int]
    """Columns of something else; those in neither set are empty."""
    top: int = -1
    """Index of the row of names, -1 where there is none."""
    names: tuple[str, ...] = ()
    units: tuple[str, ...] = ()
    fits: bool = False
    """Whether there are as many names as columns."""

    @cached_property
    def numbers(self) -> list[tuple[int, int, str]]:
        """Line, column and text of each number in the columns of numbers."""
        return [
            (row.line, column, cell)
            for row in self.rows[self.body :]
            for column, cell in enumerate(row.cells)
            if column in self.numeric and _is_number(cell, self.signs)
        ]

    def has_sample(self, row: Row) -> bool:
        """Tell whether a row has numbers, and something else only in columns of something else."""
        if len(row.cells) != self.width or not _count(row, self.signs):
            return False
        cells = [cell for column, cell in enumerate(row.cells) if column not in self.textual]
        return all(cell in _MISSING or _is_number(cell, self.signs) for cell in cells)

    @property
    def coverage(self) -> float:
        """Share of the body's characters that stand in numbers."""
        cells = [cell for row in self.rows[self.body :] for cell in row.cells if cell not in _MISSING]
        return sum(len(cell) for cell in cells if _is_number(cell, self.signs)) / max(1, sum(map(len, cells)))

    @property
    def regularity(self) -> float:
        """Share of the body's rows that have as many fields as the header."""
        body = self.rows[self.body :]
        return sum(len(_trimmed(self.names)) <= len(row.cells) <= self.width for row in body) / len(body)


def _is_number(cell: str, signs: str) -> bool:
    return _NUMBER[signs].fullmatch(cell) is not None


def _count(row: Row, signs: str) -> int:
    return sum(_is_number(cell, signs) for cell in row.cells)


def _looks_like_names(row: Row) -> bool:
    cells = [cell for cell in row.cells if cell]
    lettered = sum(any(map(str.isalpha, cell)) for cell in cells if cell not in _MISSING)
    return len(row.cells) > 1 and 2 * lettered >= max(1, len(cells))


def find_layout(text: Text, hints: Hints) -> Layout:
    """Find the table in a text; where it is ambiguous, the layout says so.

    Raises ``ReaderError`` where there is none, saying what is missing.
    """
    table, lines = _find_table(text, hints)
    later = [] if hints.decimal else _later_rows(text, table, lines)
    seen = replace(table, rows=table.rows + later) if later else table
    return _layout(table, lines, hints.decimal or _decimal(seen), _doubt(text, hints, seen))


def _find_table(text: Text, hints: Hints) -> tuple[_Table, list[str]]:
    lines = sample_lines(text)
    tables = [
        table for separator in _wanted(text, hints) if (table := _table(lines, separator, _signs(separator, hints)))
    ]
    table = _chosen([table for table in tables if table.top >= 0 and max(table.width, len(table.names)) > 1])
    if table is None:
        raise ReaderError(_why_none(text, hints, lines, tables))
    if max(len(table.names), table.width) > _MOST_COLUMNS:
        raise ReaderError(
            f"{text.name}, line {table.rows[table.top].line}: found {max(len(table.names), table.width)} columns; "
            f"expected at most {_MOST_COLUMNS}; check that the file is a table of one row a sample"
        )
    return table, lines


def _wanted(text: Text, hints: Hints) -> tuple[str, ...]:
    """Name the separators to try."""
    separator = hints.separator
    if separator is None:
        return tuple(each for each in _SEPARATORS if each != "," or hints.decimal != ",")
    if len(separator) != 1 or not separator.isascii() or separator.isalnum() or separator in '"+-.\r\n\0':
        raise ReaderError(
            f"{text.name}: found the separator {separator!r} in run.toml; expected one character such as "
            '";" or "\\t", or " " for runs of blanks; correct it'
        )
    if separator == hints.decimal:
        raise ReaderError(
            f"{text.name}: found {separator!r} as separator and as decimal sign in run.toml; expected two "
            "different signs; correct one of them"
        )
    return (separator,)


def _signs(separator: str, hints: Hints) -> str:
    return hints.decimal or ("." if separator == "," else ".,")


def _table(lines: list[str], separator: str, signs: str) -> _Table | None:
    """Find the table that a separator makes of the sample, where it makes one."""
    rows = _sampled(lines, separator)
    counts = [_count(row, signs) for row in rows]
    last = max((index for index, count in enumerate(counts) if count), default=-1)
    named = [index for index in range(last) if not counts[index] and _looks_like_names(rows[index])]
    # Below the last row that could be names, rows with numbers are samples for certain.
    below = range(max(named, default=-1) + 1, last + 1)
    certain = [rows[index] for index in below if counts[index]]
    if certain and _is_unit_row(certain[0].cells):  # the unit 1 looks like a number
        del certain[0]
    if not certain:
        return None
    width = _usual_width(certain, signs)
    certain = [row for row in certain if len(row.cells) == width]
    columns = [[row.cells[column] for row in certain] for column in range(width)]
    numeric = frozenset(column for column, cells in enumerate(columns) if _is_numeric(cells, signs))
    filled = frozenset(column for column, cells in enumerate(columns) if not set(cells) <= set(_MISSING))
    table = _Table(separator, signs, rows, rows.index(certain[0]), width, numeric, filled - numeric)
    table = replace(table, body=next((i for i, row in enumerate(rows) if table.has_sample(row)), table.body))
    return _with_header(table, lines, [index for index in named if index < table.body][-20:])


def _usual_width(rows: list[Row], signs: str) -> int:
    weights: Counter[int] = Counter()
    for row in rows:
        weights[len(row.cells)] += _count(row, signs)
    return max(weights, key=lambda width: (weights[width], width))


def _is_numeric(cells: list[str], signs: str) -> bool:
    numbers = sum(_is_number(cell, signs) for cell in cells)
    return 2 * numbers > sum(cell not in _MISSING for cell in cells)


def _with_header(table: _Table, lines: list[str], named: list[int]) -> _Table:
    """Add names and units from the rows above the numbers; ``named`` are those that could be names."""
    filled = 1 + max(table.numeric | table.textual)
    split = {index: _header_cells(table, lines, index) for index in named}
    enough = [i for i in named if filled <= len(split[i]) and filled <= 2 * sum(map(bool, split[i]))]
    if not named:
        return _with_numbered_names(table)
    top = max(enough or named)
    units, body = _below_names(table, top)
    if not units and top - 1 in enough and _is_unit_row(split[top]):
        units, top = split[top], top - 1
    elif not units and top > 0 and filled <= len(table.rows[top - 1].cells):
        above = table.rows[top - 1].cells
        units = above if _is_unit_row(above) else []
    names = _trimmed(split[top])
    padded = [len(row.cells) for row in table.rows[body:] if not any(row.cells[len(names) :])]
    return replace(
        table,
        top=top,
        body=body,
        names=tuple(split[top]),
        units=tuple(units),
        width=max(table.width, len(names), *padded, 0),
        fits=top in enough and len(names) <= table.width,
    )


def _below_names(table: _Table, top: int) -> tuple[list[str], int]:
    """Find a row of units and the first sample between the names and what is a sample for certain."""
    units: list[str] = []
    for index in range(top + 1, table.body):
        row = table.rows[index]
        if not units and _is_unit_row(row.cells):
            units = row.cells
        elif _count(row, table.signs) or (len(row.cells) > 1 and set(row.cells) <= set(_MISSING)):
            return units, index
    return units, table.body


def _with_numbered_names(table: _Table) -> _Table:
    """Take the row above the numbers as names although it holds numbers, unless it holds nothing else."""
    above = table.rows[table.body - 1].cells if table.body else []
    if len(above) != table.width or all(cell in _MISSING or _is_number(cell, table.signs) for cell in above):
        return table
    return replace(table, names=tuple(above), top=table.body - 1, fits=True)


def _header_cells(table: _Table, lines: list[str], index: int) -> list[str]:
    """Split a header row; between blanks, a unit belongs to the name before it."""
    row = table.rows[index]
    if table.separator != BLANKS:
        cells = [re.sub(r"\s*[\r\n]+\s*", " ", cell) for cell in row.cells]
        return [cells[0].removeprefix("#").strip() or cells[0], *cells[1:]]
    line = lines[row.line - 1].strip(" \t\r\n")
    for text in (line, line.removeprefix("#").strip(" \t")):
        for cells in (text.split(), _NAME_AMONG_BLANKS.findall(text), re.split(r" {2,}|\t+", text)):
            if len(cells) == table.width:
                return cells
    return row.cells


def _chosen(tables: list[_Table]) -> _Table | None:
    """Choose among separators: the stronger ones first, then by how much stands in numbers."""

    def rank(table: _Table) -> tuple[bool, bool, bool, float]:
        return table.fits, table.regularity >= 0.5, table.separator in _STRONG_SEPARATORS, table.coverage

    return max(tables, key=rank, default=None)


def _layout(table: _Table, lines: list[str], decimal: Decimal, doubt: str | None) -> Layout:
    body = table.rows[table.body :]
    cells = ((column, cell) for row in body for column, cell in enumerate(row.cells))
    return Layout(
        separator=table.separator,
        decimal=decimal,
        names=table.names,
        line=body[0].line,
        header="".join(lines[: body[0].line - 1]),
        width=table.width,
        least=len(_trimmed(table.names)),
        units=table.units,
        textual=frozenset(c for c, cell in cells if cell not in _MISSING and not _is_number(cell, decimal)),
        doubt=doubt,
    )


def _why_none(text: Text, hints: Hints, lines: list[str], tables: list[_Table]) -> str:
    """Say what a file without a table lacks."""
    number, line = next(((n, line.strip()) for n, line in enumerate(lines, 1) if not line.isspace()), (1, ""))
    where = f"{text.name}, line {number}"
    if not tables and (not hints.separator or any(hints.separator in line for line in lines)):
        found = line if len(line) <= 40 else f"{line[:39]}…"
        below = "below" if len(lines) < _SAMPLE_LINES else f"in the first {_SAMPLE_LINES} lines"
        return (
            f"{where}: found {found!r} and no row of numbers {below}; expected a row of names and rows of numbers; "
            "export the file again with its data"
        )
    if any(table.width > 1 for table in tables):
        table = max(tables, key=lambda table: (table.width > 1, table.coverage))
        where = f"{text.name}, line {table.rows[table.body].line}"
        return (
            f"{where}: found numbers without a row of names above; expected one such as 'Time [s]', 'Depth [um]' "
            "with the same separators; add it"
        )
    under = f"with the separator {hints.separator!r}" if hints.separator else "with any known separator"
    return (
        f"{where}: found a single column {under}; expected at least two, one of them time or sliding distance; "
        "name the file's separator and decimal in run.toml"
    )


# --- can it be read in another way? ---


def _later_rows(text: Text, table: _Table, lines: list[str]) -> list[Row]:
    """Give rows from the first decimal sign on, where the sample of a longer file shows none."""
    if table.separator == "," or any(not _INTEGER.fullmatch(number) for _, _, number in table.numbers):
        return []
    behind = text.start + len("".join(lines).encode())
    found = [at for sign in (b".", b",") if (at := text.content.find(sign, behind)) >= 0]
    if not found:
        return []
    start = max(text.content.rfind(end, 0, min(found)) for end in (b"\r", b"\n")) + 1
    before = len(_LINE_END.findall(text.content, text.start, start))
    later, _ = _lines_from(text, start)
    return [Row(before + row.line, row.cells) for row in _sampled(later, table.separator)]


def _decimal(table: _Table) -> Decimal:
    signs = Counter(sign for _, _, number in table.numbers for sign in ".," if sign in number)
    return "," if signs[","] > signs["."] else "."


def _doubt(text: Text, hints: Hints, table: _Table) -> str | None:
    """Say what makes the table ambiguous, where something does."""
    doubt = _second_table(table)
    if doubt is None and hints.separator is None and table.separator == ",":
        doubt = _comma_doubt(table)
    if doubt is None and hints.decimal is None:
        doubt = _two_signs(table) or _maybe_thousands(table)
    if doubt is None and text.unterminated:
        doubt = _cut_number(text, table)
    return doubt and f"{text.name}, {doubt}"


def _second_table(table: _Table) -> str | None:
    above = [
        row
        for row in table.rows[: table.top]
        if _is_number(row.cells[0], table.signs) and 2 * _count(row, table.signs) > len(_trimmed(row.cells))
    ]
    for row, following in pairwise(above):
        if len(row.cells) == len(following.cells) > 1 and following.line == row.line + 1:
            return (
                f"line {row.line}: found rows of numbers above the names in line {table.rows[table.top].line}; "
                "expected one table in a file; split it"
            )
    return None


def _comma_doubt(table: _Table) -> str | None:
    """Doubt a comma as separator where it may as well stand inside numbers."""
    for row in table.rows[table.body :]:
        for cell in row.cells:
            parts = cell.split()
            if len(parts) > 1 and all(_is_number(part, ".") for part in parts):
                return f"line {row.line}: found {cell!r} between commas; {_ASK_FOR_SEPARATOR}"
    pointed = any(not _INTEGER.fullmatch(number) for _, _, number in table.numbers)
    names = table.names
    if pointed or len(names) % 2 or not all(unit and is_unit(unit) for unit in names[1::2]):
        return None
    return f"line {table.rows[table.top].line}: found '{', '.join(names)}' above integers; {_ASK_FOR_SEPARATOR}"


def _two_signs(table: _Table) -> str | None:
    """Doubt the decimal sign where numbers are written with both."""
    first: dict[str, tuple[int, str]] = {}
    for line, _, number in table.numbers:
        for sign in ".,":
            if sign in number:
                first.setdefault(sign, (line, number))
    if len(first) < 2:
        return None
    (line, number), (other_line, other) = sorted(first.values())
    return (
        f"line {other_line}: found {other!r}, while line {line} writes {number!r}; expected one decimal sign; mend "
        "the lines that differ, or name decimal in run.toml"
    )


def _maybe_thousands(table: _Table) -> str | None:
    """Doubt numbers such as 1,234 in a column with plain integers, where no other shows the decimal sign."""
    if table.separator == ",":
        return None
    signed = [entry for entry in table.numbers if not _INTEGER.fullmatch(entry[2])]
    plain = {column for _, column, number in table.numbers if _INTEGER.fullmatch(number)}
    if not all(_MAYBE_THOUSANDS.fullmatch(number) for _, _, number in signed):
        return None
    for line, column, number in signed:
        if column in plain:
            return (
                f"line {line}: found {number!r} among integers; expected to see whether it is a decimal number or "
                "thousands; name decimal in run.toml, and leave out signs between thousands"
            )
    return None


def _cut_number(text: Text, table: _Table) -> str | None:
    """Doubt a last number without a line end that has fewer decimals than every one above it."""
    column = table.width - 1
    rows = [row for row in table.rows[table.body :] if len(row.cells) == table.width and row.cells[column]]
    final = re.split(r"[\r\n]", text.content[-_LONGEST_LINE:].decode(errors="ignore"))[-1]
    last = next(iter(_sampled([final], table.separator)), None)
    if last is None or len(last.cells) != table.width or column not in table.numeric:
        return None
    above = rows[:-1] if rows and rows[-1].cells == last.cells else rows
    decimals = {_decimals(row.cells[column]) for row in above}
    found = last.cells[column]
    if len(above) < 2 or len(decimals) != 1 or not found or _decimals(found) >= decimals.pop():
        return None
    return (
        f"last line: found {found!r} with fewer decimals than above and without a line end; expected whole rows; "
        "the file ends in the middle of a row: copy it again from the instrument, or delete that line"
    )


def _decimals(number: str) -> int:
    return len(re.split(r"[.,]", f"{number}.")[1])


# --- the body ---


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
    below = _without_brackets(layout.units[column]) if column < len(layout.units) else ""
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
    ends = [*starts[1:], len(text.content)]
    with ThreadPoolExecutor(max_workers=min(_THREADS, os.cpu_count() or 1)) as pool:
        spans = zip(starts, ends, strict=True)
        pieces = list(pool.map(lambda span: _read_csv(text, layout, textual, *span), spans))
        if len(pieces) == 1:
            return [pieces[0][number].to_numpy() for number in range(layout.width)]
        columns = ([piece[number].to_numpy() for piece in pieces] for number in range(layout.width))
        return list(pool.map(np.concatenate, columns))


def _pieces(text: Text, layout: Layout) -> list[int]:
    """Find where to divide the body: between rows, so nowhere if quotes may hold line ends.

    Raises ``ReaderError`` where the first row of a piece is too long, which pandas would shorten without a word.
    """
    starts = [_body_start(text, layout)]
    if text.content.find(b'"', starts[0]) < 0:
        while (end := _LINE_END.search(text.content, starts[-1] + _PIECE_BYTES)) and end.end() < len(text.content):
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
        "na_values": dict.fromkeys(numeric, _MISSING),
        "quoting": csv.QUOTE_NONE if blanks else csv.QUOTE_MINIMAL,
        "skipinitialspace": text.content.find(b" ", start, end) >= 0,  # slow, so only where needed
    }
    if [int(part) for part in pd.__version__.split(".")[:2]] < [3, 1]:
        options["float_precision"] = "round_trip"  # later versions read so anyway
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
            # Piece by piece, columns in which something is no number could get several types.
            low_memory=False,
            **options,
        )
    except pd.errors.ParserError:
        raise _too_wide(text, layout) from None


def _from_texts(fields: list[str], decimal: Decimal) -> _Parsed:
    """Turn fields into numbers, or leave all as they are where one is none."""
    numbers = np.full(len(fields), nan)
    for row, field in enumerate(fields):
        if field in _MISSING:
            continue
        if not _is_number(field, decimal) or not isfinite(number := float(field.replace(decimal, "."))):
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
