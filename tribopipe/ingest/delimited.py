"""Delimited text: a row of names, perhaps a row of units, and rows of numbers below.

What the reader finds by itself, and the manifest's word overrides:

* encoding: byte order marks, UTF-16 without one, strict UTF-8, then cp1252, then latin-1;
* separator: tab, semicolon, bar, comma, or runs of blanks. A comma separates only where nothing
  stronger does and numbers are written with a point;
* decimal sign: point or comma;
* line ends: LF, CRLF, lone CR, or a mixture; blank lines are skipped;
* lines above the table, kept verbatim; a row of units above or below the row of names, or units
  inside the names: "Depth [um]", "Fz (N)", "time / s".

Rows may end in separators that the header lacks. "", "NaN", "nan" and "NA" are missing samples;
anything else that is no plain finite number leaves its column as text. Where the head of a file can
be understood in two ways that give different numbers, it is refused rather than guessed.
"""

import codecs
import csv
import re
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cache
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
"""As a separator, this stands for runs of blanks and tabs."""
_SEPARATORS = ("\t", ";", "|", ",", BLANKS)
_SAMPLE_BYTES = 1 << 19
_SAMPLE_LINES = 1000
_LONGEST_LINE = 1 << 17
_MOST_COLUMNS = 1000
_MISSING = ("", "NaN", "nan", "NA")
_NUMBER: dict[str, re.Pattern[str]] = {
    ".": re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?", re.ASCII),
    ",": re.compile(r"[+-]?\d+(?:,\d+)?(?:[eE][+-]?\d+)?", re.ASCII),
}
_THOUSANDS = re.compile(r"[+-]?[1-9]\d{0,2}(?:[.,]\d{3})", re.ASCII)
_INTEGER = re.compile(r"[+-]?\d+", re.ASCII)
_UNIT_IN_NAME = (
    re.compile(r"(?P<bare>.*?)\s*\[(?P<unit>[^\[\]]*)\]", re.DOTALL),
    re.compile(r"(?P<bare>.*?)\s*\((?P<unit>(?:[^()]|\([^()]*\))*)\)", re.DOTALL),
    re.compile(r"(?P<bare>.*\S)\s+/\s+(?P<unit>\S+)", re.DOTALL),
    re.compile(r"(?P<bare>[^\s/]+)/(?P<unit>\S+)"),
)
_UNIT_ROW_LABELS = ("unit", "units", "einheit", "einheiten", "单位", "単位")
_NAME_MAYBE_WITH_UNIT = re.compile(r"\S+(?:[ \t]*(?:\[[^\]]*\]|\([^)]*\))|[ \t]+/[ \t]+\S+)?")


# --- names and units ------------------------------------------------------------------------------


def split_name(name: str) -> tuple[str, str | None]:
    """Split a column's name as a header writes it into name and unit: "Depth [um]", "time / s"."""
    for pattern in _UNIT_IN_NAME:
        matched = pattern.fullmatch(name)
        if matched is None:
            continue
        bare, unit = matched["bare"].rstrip(" /"), matched["unit"].strip()
        # "m/s" and "rev/min" alone are units, not names with one.
        if bare and is_unit(unit) and not (pattern is _UNIT_IN_NAME[-1] and is_unit(bare)):
            return bare, unit or None
    return name, None


def bare_name(name: str) -> str:
    """Strip the unit off a column's name: "Depth [um]" is "Depth"."""
    return split_name(name)[0]


def _in_brackets(cell: str) -> str:
    return cell[1:-1].strip() if cell[:1] + cell[-1:] in ("[]", "()") else cell


def _is_unit_row(cells: list[str]) -> bool:
    units = [_in_brackets(cell) for cell in cells if cell]
    if units and units[0].lower() in _UNIT_ROW_LABELS:
        del units[0]
    return any(not _INTEGER.fullmatch(unit) for unit in units) and all(map(is_unit, units))


# --- from bytes to text ---------------------------------------------------------------------------


@dataclass(frozen=True)
class Text:
    """A file as UTF-8, whatever it was before."""

    name: str
    content: bytes
    start: int = 0
    """Where the text starts, behind a byte order mark."""
    partial: bool = False
    """Whether this is only the beginning of the file."""
    notes: tuple[str, ...] = ()

    @property
    def unterminated(self) -> bool:
        """Whether the last line has no line end."""
        return not self.content.endswith((b"\r", b"\n"))


def decode(source: SourceFile, encoding: str | None = None, *, partial: bool = False) -> Text:
    """Decode a file by the encoding named, or find it.

    Raises ``ReaderError`` where the file is empty or binary, where the encoding is unknown, or where
    the file is not in it.
    """
    if not source.content:
        raise ReaderError(
            f"{source.name}: the file is empty; expected a row of names and rows of numbers below it; "
            "copy it again from the instrument"
        )
    text = _guessed(source, partial) if encoding is None else _as_named(source, encoding, partial)
    _refuse_binary(text)
    return text


def _guessed(source: SourceFile, partial: bool) -> Text:
    content = source.content
    wide = _utf16(content)
    if wide is not None:
        return _as_named(source, wide, partial)
    start = len(codecs.BOM_UTF8) if content.startswith(codecs.BOM_UTF8) else 0
    try:
        if not content.isascii():
            _strictly(content, "utf-8", partial)
    except UnicodeDecodeError as error:
        if start or (error.reason == "unexpected end of data" and not content[: error.start].isascii()):
            raise _undecodable(source.name, "utf-8", error) from None
        return _western(source, partial)
    return Text(source.name, content, start, partial)


def _utf16(content: bytes) -> str | None:
    if content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return "utf-16"
    head = content[:4096]
    for encoding, zeros in (("utf-16-le", head[1::2]), ("utf-16-be", head[::2])):
        if zeros and zeros.count(0) > 0.6 * len(zeros):
            return encoding
    return None


def _western(source: SourceFile, partial: bool) -> Text:
    try:
        encoding, text = "cp1252", _strictly(source.content, "cp1252", partial)
    except UnicodeDecodeError:
        encoding, text = "latin-1", _strictly(source.content, "latin-1", partial)
    note = (
        f"read as {encoding}, since it is no UTF-8; if letters come out wrong, name the right encoding "
        "in run.toml"
    )
    return Text(source.name, text.encode(), 0, partial, (note,))


def _as_named(source: SourceFile, encoding: str, partial: bool) -> Text:
    try:
        "".encode(encoding)
    except (LookupError, ValueError):
        raise ReaderError(
            f"{source.name}: found the encoding {encoding!r} in run.toml; expected one that Python "
            "knows, such as 'utf-8', 'cp1252' or 'shift_jis'; correct it"
        ) from None
    try:
        text = _strictly(source.content, encoding, partial).removeprefix("\ufeff")
        return Text(source.name, text.encode(), 0, partial)
    except UnicodeError as error:
        raise _undecodable(source.name, encoding, error) from None


def _strictly(content: bytes, encoding: str, partial: bool) -> str:
    return codecs.getincrementaldecoder(encoding)().decode(content, final=not partial)


def _undecodable(name: str, encoding: str, error: UnicodeError) -> ReaderError:
    where = f"byte {error.start}" if isinstance(error, UnicodeDecodeError) else "the text"
    return ReaderError(
        f"{name}: {where} cannot be read as {encoding}; expected the whole file in that encoding; copy "
        "it again from the instrument, or name another encoding in run.toml"
    )


def _refuse_binary(text: Text) -> None:
    zero = text.content.find(b"\0")
    if zero >= 0:
        found = f"found a zero byte at offset {zero}"
    else:
        head = text.content[: 1 << 16]
        strange = len(head) - len(head.translate(None, _CONTROLS))
        if strange <= len(head) // 100:
            return
        found = f"found {strange} control characters in the first {len(head)} bytes"
    raise ReaderError(
        f"{text.name}: {found}; expected text; export the table as text, or name the format's own "
        "reader in run.toml"
    )


_CONTROLS = bytes(set(range(32)) - set(b"\t\n\v\f\r\x1a\x1b"))


# --- lines and rows -------------------------------------------------------------------------------


class Row(NamedTuple):
    """One line of the file (more, where a quoted field holds line ends) split into fields."""

    line: int
    """Number of its first line, counted from 1."""
    cells: list[str]


def sample_lines(text: Text) -> list[str]:
    """Give the first lines with their ends, whole ones only, up to a thousand.

    Raises ``ReaderError`` where there is nothing but blanks, or where a line is too long for a table.
    """
    lines, whole = _lines_from(text, text.start)
    for number, line in enumerate(lines, 1):
        if len(line) > _LONGEST_LINE:
            raise ReaderError(
                f"{text.name}, line {number}: found more than {_LONGEST_LINE} characters in one line; "
                f"expected a table of at most {_MOST_COLUMNS} columns; check that the file is one, and "
                "that its line ends were not lost"
            )
    if not whole:
        del lines[-1]
    elif text.content[text.start :].isspace():
        raise ReaderError(
            f"{text.name}: found nothing but blanks; expected a row of names and rows of numbers below "
            "it; copy the file again from the instrument"
        )
    return lines[:_SAMPLE_LINES]


def _lines_from(text: Text, start: int) -> tuple[list[str], bool]:
    """Give the lines of a sample of the text, and whether it reaches the end of the file."""
    block = text.content[start : start + _SAMPLE_BYTES].decode(errors="ignore")
    lines = re.findall(r"[^\r\n]*(?:\r\n|\r|\n)|[^\r\n]+", block)
    return lines, not text.partial and start + _SAMPLE_BYTES >= len(text.content)


def split_rows(lines: Iterable[str], separator: str) -> Iterator[Row]:
    """Split lines into fields, leaving out blank lines.

    Raises ``csv.Error`` where a quoted field runs on without end.
    """
    if separator == BLANKS:
        for number, line in enumerate(lines, 1):
            if not line.isspace():
                yield Row(number, re.split(r"[ \t]+", line.strip(" \t\r\n")))
        return
    reader = csv.reader(lines, delimiter=separator, skipinitialspace=True)
    number = 1
    for cells in reader:
        if len(cells) > 1 or any(cell.strip() for cell in cells):
            yield Row(number, [cell.strip() for cell in cells])
        number = reader.line_num + 1


def _sampled(lines: list[str], separator: str) -> list[Row]:
    try:
        return list(split_rows(lines, separator))
    except csv.Error:
        return []


# --- the table in the head of the file ------------------------------------------------------------


@dataclass(frozen=True)
class Layout:
    """Where the table stands in a text, and how it is written."""

    separator: str
    decimal: Decimal
    names: tuple[str, ...]
    """As the header writes them, "" where it writes none."""
    line: int
    """Number of the first line of the body."""
    header: str
    """Everything above the body, verbatim."""
    width: int
    """Fields that a row has, trailing empty ones included."""
    least: int
    """Fewest fields of a row that is whole."""
    units: tuple[str, ...] = ()
    """The row of units, where there is one."""
    textual: frozenset[int] = frozenset()
    """Columns known to hold something other than numbers."""
    doubt: str | None = None
    """Why the numbers cannot be trusted to be read as meant."""


@dataclass(frozen=True)
class _Table:
    """The rows of the sample under one separator, and where the table is among them."""

    separator: str
    signs: str
    rows: list[Row]
    names: tuple[str, ...]
    units: tuple[str, ...]
    top: int
    """Index of the row of names; -1 where there is none."""
    body: int
    """Index of the first row below the header."""
    width: int
    numeric: frozenset[int]
    fits: bool
    """Whether there are as many names as columns."""

    def numbers(self) -> Iterator[tuple[int, int, str]]:
        """Give line, column and text of each number in the numeric columns."""
        for row in self.rows[self.body :]:
            for column, cell in enumerate(row.cells):
                if column in self.numeric and _is_number(cell, self.signs):
                    yield row.line, column, cell

    @property
    def coverage(self) -> float:
        """Share of the body's characters that stand in numbers."""
        cells = [cell for row in self.rows[self.body :] for cell in row.cells]
        inside = sum(len(cell) for cell in cells if _is_number(cell, self.signs))
        return inside / max(1, sum(map(len, cells)))


def _is_number(cell: str, signs: str) -> bool:
    return any(_NUMBER[sign].fullmatch(cell) for sign in signs)


def _is_names_row(row: Row, signs: str) -> bool:
    cells = [cell for cell in row.cells if cell]
    lettered = sum(any(map(str.isalpha, cell)) for cell in cells if cell not in _MISSING)
    return len(row.cells) > 1 and 2 * lettered >= max(1, len(cells)) and _count(row, signs) == 0


def _count(row: Row, signs: str) -> int:
    return sum(_is_number(cell, signs) for cell in row.cells)


def _table(lines: list[str], separator: str, signs: str) -> _Table | None:
    """Find the table that a separator makes of the sample, where it makes one."""
    rows = _sampled(lines, separator)
    counts = [_count(row, signs) for row in rows]
    last = max((index for index, count in enumerate(counts) if count), default=-1)
    names = [index for index in range(last) if _is_names_row(rows[index], signs)]
    # What stands below the last row of names are rows of numbers for certain, whatever is above.
    tail = max((index for index in names), default=-1) + 1
    sure = [row for row, count in zip(rows[tail:], counts[tail:], strict=True) if count]
    if not sure:
        return None
    width = _usual_width(sure, signs)
    sure = [row for row in sure if len(row.cells) == width]
    numeric = _numeric_columns(sure, width, signs)
    first = next(i for i, row in enumerate(rows) if _like(row, width, numeric, signs))
    draft = _Table(separator, signs, rows, (), (), -1, first, width, numeric, False)
    filled = max(len(_trimmed(row.cells)) for row in sure)
    return _with_header(draft, lines, [index for index in names if index < first], filled)


def _usual_width(rows: list[Row], signs: str) -> int:
    weights: Counter[int] = Counter()
    for row in rows:
        weights[len(row.cells)] += _count(row, signs)
    return max(weights, key=lambda width: (weights[width], width))


def _numeric_columns(rows: list[Row], width: int, signs: str) -> frozenset[int]:
    def is_numeric(column: int) -> bool:
        cells = [row.cells[column] for row in rows]
        numbers = sum(_is_number(cell, signs) for cell in cells)
        return numbers > sum(cell not in _MISSING for cell in cells) - numbers

    return frozenset(column for column in range(width) if is_numeric(column))


def _like(row: Row, width: int, numeric: frozenset[int], signs: str) -> bool:
    """Tell whether a row is one of numbers, of that many fields and with numbers in those columns."""
    if len(row.cells) != width or not _count(row, signs):
        return False
    cells = [row.cells[column] for column in numeric]
    return all(cell in _MISSING or _is_number(cell, signs) for cell in cells)


def _trimmed(cells: Iterable[str]) -> list[str]:
    kept = list(cells)
    while kept and not kept[-1]:
        del kept[-1]
    return kept


def _with_header(draft: _Table, lines: list[str], above: list[int], filled: int) -> _Table:
    """Add names and units, from the rows above the first one of numbers."""
    split = {index: _header_cells(draft, lines, index) for index in above[-20:]}

    def fits(index: int) -> bool:
        cells = split.get(index, [])
        return len(_trimmed(cells)) <= draft.width and filled <= len(cells)

    top = max((i for i in split if fits(i)), default=max(split, default=-1))
    if top < 0:
        return _with_numbered_names(draft)
    units: tuple[str, ...] = ()
    above_top = top - 1 if fits(top - 1) else -1
    between = range(top + 1, draft.body)
    body = next((i for i in between if not _is_rule(draft, i)), draft.body)
    if body < draft.body and _is_unit_row(draft.rows[body].cells):
        units, body = tuple(draft.rows[body].cells), body + 1
    elif above_top >= 0 and _is_unit_row(split[top]):
        units, top = tuple(split[top]), above_top
    elif above_top >= 0 and _is_unit_row(split[above_top]):
        units = tuple(split[above_top])
    found = replace(draft, top=top, body=body, units=units, fits=fits(top))
    return _with_names(found, split[top])


def _with_names(table: _Table, cells: list[str]) -> _Table:
    """Set the names, and widen the table where rows differ in empty fields behind the last name."""
    named = len(_trimmed(cells))
    padded = [len(row.cells) for row in table.rows[table.body :] if not any(row.cells[named:])]
    return replace(table, names=tuple(cells), width=max(table.width, named, *padded, 0))


def _with_numbered_names(table: _Table) -> _Table:
    """Take the row above the numbers as names although it holds a number, where it is a row at all."""
    above = table.rows[table.body - 1].cells if table.body else []
    if len(above) != table.width or all(_is_number(c, table.signs) or c in _MISSING for c in above):
        return table
    return replace(table, names=tuple(above), top=table.body - 1, fits=True)


def _is_rule(table: _Table, index: int) -> bool:
    """Tell whether a row between header and body is decoration, such as "-----"."""
    return not _count(table.rows[index], table.signs)


def _header_cells(draft: _Table, lines: list[str], index: int) -> list[str]:
    """Split a header row; between blanks, units belong to the name before them."""
    row = draft.rows[index]
    if draft.separator != BLANKS:
        cells = [re.sub(r"\s*[\r\n]+\s*", " ", cell) for cell in row.cells]
        return [cells[0].removeprefix("#").strip() or cells[0], *cells[1:]]
    line = lines[row.line - 1].strip(" \t\r\n")
    for text in (line, line.removeprefix("#").strip(" \t")):
        for cells in (text.split(), _NAME_MAYBE_WITH_UNIT.findall(text), re.split(r"\s{2,}|\t", text)):
            if len(cells) == draft.width:
                return cells
    return row.cells


def find_layout(text: Text, hints: Hints) -> Layout:
    """Find the table in a text.

    Raises ``ReaderError`` where there is none, saying what is missing.
    """
    lines = sample_lines(text)
    tables = [table for s in _wanted(text, hints) if (table := _table(lines, s, _signs(s, hints)))]
    wide = [table for table in tables if max(table.width, len(table.names)) > 1]
    chosen = _chosen([table for table in wide if table.top >= 0])
    if chosen is None:
        raise ReaderError(_why_none(text, hints, lines, tables))
    _refuse_too_many(text, chosen)
    later = [] if hints.decimal else _later_rows(text, lines, chosen)
    seen = replace(chosen, rows=[*chosen.rows, *later])
    decimal = hints.decimal or _decimal(seen)
    return _layout(chosen, lines, decimal, _doubt(text, hints, seen))


def _layout(table: _Table, lines: list[str], decimal: Decimal, doubt: str | None) -> Layout:
    body = table.rows[table.body :]
    good = _NUMBER[decimal].fullmatch
    return Layout(
        separator=table.separator,
        decimal=decimal,
        names=table.names,
        line=body[0].line,
        header="".join(lines[: body[0].line - 1]),
        width=table.width,
        least=len(_trimmed(table.names)),
        units=table.units,
        textual=frozenset(
            column
            for row in body
            for column, cell in enumerate(row.cells)
            if cell not in _MISSING and not good(cell)
        ),
        doubt=doubt,
    )


def _wanted(text: Text, hints: Hints) -> tuple[str, ...]:
    """Name the separators to try."""
    if hints.separator is None:
        return tuple(s for s in _SEPARATORS if not (s == "," and hints.decimal == ","))
    separator = hints.separator
    if len(separator) != 1 or separator.isalnum() or not separator.isascii() or separator in '"\r\n.+-':
        raise ReaderError(
            f"{text.name}: found the separator {separator!r} in run.toml; expected one character such as "
            '";", "\\t", or " " for runs of blanks; correct it'
        )
    if separator == hints.decimal:
        raise ReaderError(
            f"{text.name}: found {separator!r} as separator and as decimal sign in run.toml; expected "
            "two different signs; correct one of them"
        )
    return (separator,)


def _signs(separator: str, hints: Hints) -> str:
    """Name the decimal signs that numbers may have."""
    return hints.decimal or ("." if separator == "," else ".,")


def _chosen(tables: list[_Table]) -> _Table | None:
    """Choose among separators: the stronger ones first, then by how much is made up of numbers."""
    strong = [table for table in tables if table.fits and table.separator in "\t;|"]
    weak = [table for table in tables if table.fits]
    for group in (strong, weak, tables):
        if group:
            return max(group, key=lambda table: table.coverage)
    return None


def _why_none(text: Text, hints: Hints, lines: list[str], tables: list[_Table]) -> str:
    wide = [table for table in tables if table.width > 1]
    if not tables:
        number = next(n for n, line in enumerate(lines, 1) if not line.isspace())
        return (
            f"{text.name}, line {number}: found {_brief(lines[number - 1].strip())} and no row of numbers "
            "below; expected a row of names and rows of numbers; export the file again with its data"
        )
    if not wide:
        separator = f"the separator {hints.separator!r}" if hints.separator else "no known separator"
        table = tables[-1]
        return (
            f"{text.name}, line {table.rows[table.body].line}: found a single column under {separator}; "
            "expected at least two, of which one is time or sliding distance; name the file's separator "
            "and decimal sign in run.toml"
        )
    table = max(wide, key=lambda table: table.coverage)
    return (
        f"{text.name}, line {table.rows[table.body].line}: found numbers without a row of names above "
        "them; expected one, such as 'Time [s]', 'Depth [um]', with the file's own separator; add it"
    )


def _brief(text: str) -> str:
    return repr(text if len(text) <= 40 else text[:39] + "…")


def _refuse_too_many(text: Text, table: _Table) -> None:
    found = max(len(table.names), table.width)
    if found > _MOST_COLUMNS:
        raise ReaderError(
            f"{text.name}, line {table.rows[table.top].line}: found {found} columns; expected at most "
            f"{_MOST_COLUMNS}; check that the file is a table of signals, one row a sample"
        )


# --- is there a second way to read it? ------------------------------------------------------------


def _later_rows(text: Text, lines: list[str], table: _Table) -> list[Row]:
    """Give rows from the first decimal sign on, where the sample of a longer file shows none."""
    if table.separator == "," or any("." in n or "," in n for _, _, n in table.numbers()):
        return []
    behind = text.start + len("".join(lines).encode())
    found = [at for sign in (b".", b",") if (at := text.content.find(sign, behind)) >= 0]
    if not found or text.partial:
        return []
    start = max(text.content.rfind(end, 0, min(found)) for end in (b"\r", b"\n")) + 1
    later, whole = _lines_from(text, start)
    number = 1 + len(re.findall(rb"\r\n|\r|\n", text.content[text.start : start]))
    rows = _sampled(later[:_SAMPLE_LINES] if whole else later[:_SAMPLE_LINES][:-1], table.separator)
    return [Row(number + row.line - 1, row.cells) for row in rows]


def _decimal(table: _Table) -> Decimal:
    signs = Counter(sign for _, _, number in table.numbers() for sign in ".," if sign in number)
    return "," if signs[","] > signs["."] else "."


def _doubt(text: Text, hints: Hints, table: _Table) -> str | None:
    """Say what makes the table ambiguous, where something does."""
    doubt = _second_table(table)
    if doubt is None and hints.separator is None and table.separator == ",":
        doubt = _comma_doubt(table)
    if doubt is None and hints.decimal is None:
        doubt = _mixed_signs(table) or _thousands(table)
    if doubt is None and text.unterminated and not text.partial:
        doubt = _cut_number(text, table)
    return None if doubt is None else f"{text.name}, {doubt}"


def _second_table(table: _Table) -> str | None:
    above = table.rows[: table.top]
    for row, following in pairwise(above):
        if (
            len(row.cells) == len(following.cells) > 1
            and following.line == row.line + 1
            and all(2 * _count(r, table.signs) > len(_trimmed(r.cells)) for r in (row, following))
        ):
            return (
                f"line {row.line}: found rows of numbers above the names in line "
                f"{table.rows[table.top].line}; expected one table in a file; split it into one file each"
            )
    return None


def _comma_doubt(table: _Table) -> str | None:
    """Doubt a comma as separator where it may as well be a decimal or thousands sign."""
    for row in table.rows[table.body :]:
        for cell in row.cells:
            parts = cell.split()
            if len(parts) > 1 and all(_is_number(part, ".,") for part in parts):
                return f"line {row.line}: found {cell!r} between two commas; {_ASK}"
    pointed = any("." in number for _, _, number in table.numbers())
    second = table.names[1::2]
    if not pointed and len(table.names) % 2 == 0 and all(name and is_unit(name) for name in second):
        return (
            f"line {table.rows[table.top].line}: found {', '.join(table.names[:2])!r} above numbers "
            f"without a point; {_ASK}"
        )
    return None


_ASK = (
    "expected to see whether a comma separates columns or is a decimal sign; name separator and decimal "
    "in run.toml"
)


def _mixed_signs(table: _Table) -> str | None:
    """Doubt both decimal signs where numbers of both kinds occur."""
    seen: dict[str, tuple[int, str]] = {}
    for line, _, number in table.numbers():
        for sign in ".,":
            if sign in number:
                seen.setdefault(sign, (line, number))
    if len(seen) < 2:
        return None
    (_, usual), (line, odd) = sorted(seen.values())
    return (
        f"line {line}: found {odd!r} where line {seen['.' if usual == seen['.'][1] else ','][0]} writes "
        f"{usual!r}; expected one decimal sign; mend the line, or name decimal in run.toml"
    )


def _thousands(table: _Table) -> str | None:
    """Doubt numbers such as 1,234 in a column that also holds plain integers."""
    if table.separator == ",":
        return None
    columns: dict[int, list[tuple[int, str]]] = {}
    for line, column, number in table.numbers():
        columns.setdefault(column, []).append((line, number))
    grouped: tuple[int, str] | None = None
    for numbers in columns.values():
        signed = [entry for entry in numbers if not _INTEGER.fullmatch(entry[1])]
        if any(not _THOUSANDS.fullmatch(number) for _, number in signed):
            return None
        if signed and len(signed) < len(numbers):
            grouped = grouped or signed[0]
    if grouped is None:
        return None
    line, number = grouped
    return (
        f"line {line}: found {number!r} in a column of integers; expected to see whether it is a decimal "
        "number or thousands; name decimal in run.toml, and leave out signs between thousands"
    )


def _cut_number(text: Text, table: _Table) -> str | None:
    """Doubt a last number that has fewer decimals than all before, in a line without an end."""
    tail = text.content[-_LONGEST_LINE:].decode(errors="ignore")
    final = re.split(r"[\r\n]", tail)[-1]
    cells = next(iter(_sampled([final], table.separator)), Row(0, [])).cells
    column = table.width - 1
    bodies = [row.cells for row in table.rows[table.body :] if len(row.cells) == table.width]
    if text.content.endswith(final.encode()) and bodies and bodies[-1] == cells:
        del bodies[-1]
    decimals = {_decimals(row[column]) for row in bodies if row[column] not in _MISSING}
    if len(bodies) < 2 or len(decimals) != 1 or len(cells) != table.width:
        return None
    if not cells[column] or _decimals(cells[column]) >= decimals.pop():
        return None
    return (
        f"last line: found {cells[column]!r} without a line end, shorter than the numbers above; expected "
        "as many decimals; the file ends in the middle of a row: copy it again from the instrument, or "
        "delete that line"
    )


def _decimals(number: str) -> int:
    return len(re.split(r"[.,]", number, maxsplit=1)[-1]) if re.search(r"[.,]", number) else 0


# --- the body -------------------------------------------------------------------------------------


class _Parsed(NamedTuple):
    """One column, and row and text of its first field that is no number."""

    values: NDArray[Any]
    bad: tuple[int, str] | None = None

    @property
    def missing(self) -> NDArray[np.bool_]:
        """Where fields are empty."""
        kept = self.values == "" if self.values.dtype == object else np.isnan(self.values)
        return np.asarray(kept, dtype=bool)


def read_table(text: Text, layout: Layout) -> ReadTable:
    """Read the body of a table whose layout is known.

    Raises ``ReaderError`` with the line where a row has too many fields, or too few, or is cut.
    """
    if layout.doubt is not None:
        raise ReaderError(layout.doubt)
    _check_first_row(text, layout)
    parsed = _parsed(text, layout)
    _refuse_short_rows(text, layout, parsed[-1])
    if not all(column.missing.all() for column in parsed[len(layout.names) :]):
        raise _too_wide(text, layout)
    names, notes = _unique_names(layout.names)
    lines = _line_numbers(text, layout, {column.bad[0] for column in parsed if column.bad})
    columns = tuple(
        ReadColumn(
            name,
            column.values,
            _unit(layout, number),
            first_bad=column.bad and (lines[column.bad[0]], column.bad[1]),
        )
        for number, (name, column) in enumerate(zip(names, parsed, strict=False))
        if layout.names[number] or not column.missing.all()
    )
    if text.unterminated and layout.width == layout.least:
        notes.append("the last line has no line end; its last number may have been cut short")
    return ReadTable(columns, layout.header, (*text.notes, *notes))


def _unique_names(written: tuple[str, ...]) -> tuple[list[str], list[str]]:
    """Make names unique, and say what was done."""
    names: list[str] = []
    notes = []
    for number, name in enumerate(written, 1):
        wanted = unique = name or f"column {number}"
        count = 1
        while unique in names:
            count += 1
            unique = f"{wanted} ({count})"
        if count > 1:
            notes.append(f"the column name {wanted!r} stands more than once; column {number} is {unique!r}")
        names.append(unique)
    return names, notes


def _unit(layout: Layout, column: int) -> str | None:
    written = split_name(layout.names[column])[1]
    below = _in_brackets(layout.units[column]) if column < len(layout.units) else ""
    return written or (below if below and is_unit(below) else None)


def _body_start(text: Text, layout: Layout) -> int:
    return text.start + len(layout.header.encode())


def _body_rows(text: Text, layout: Layout) -> Iterator[Row]:
    """Go through the body field by field: slow, for finding the line of something known to be wrong."""
    stream = BytesIO(text.content)
    stream.seek(_body_start(text, layout))
    lines = TextIOWrapper(stream, encoding="utf-8", newline="")
    last = layout.line
    try:
        for row in split_rows(lines, layout.separator):
            last = row.line + layout.line - 1
            yield Row(last, row.cells)
    except csv.Error:
        raise ReaderError(
            f"{text.name}, after line {last}: found a field of more than {csv.field_size_limit()} "
            "characters; expected a number; a quotation mark may lack its partner: mend that line"
        ) from None


def _check_first_row(text: Text, layout: Layout) -> None:
    """Refuse what pandas would pass over in silence."""
    first = next(_body_rows(text, layout), None)
    if first is None:
        raise ReaderError(
            f"{text.name}, line {layout.line}: found no row of numbers below the names; expected at least "
            "one; export the file again with its data"
        )
    if len(first.cells) > layout.width:
        raise _too_wide(text, layout)


def _parsed(text: Text, layout: Layout) -> list[_Parsed]:
    frame, textual = _frame(text, layout)
    return [
        _from_texts([str(field).strip() for field in frame[number]], layout.decimal)
        if number in textual
        else _Parsed(frame[number].to_numpy())
        for number in range(layout.width)
    ]


def _frame(text: Text, layout: Layout) -> tuple[Any, set[int]]:
    """Parse the body, and name the columns that were read as text since they hold no plain numbers."""
    from pandas.errors import ParserError

    textual = set(layout.textual)
    try:
        frame = _read_csv(text, layout, textual)
    except ParserError:
        raise _too_wide(text, layout) from None
    except ValueError:
        guessed = _read_csv(text, layout, textual, guess=True)
        textual |= {n for n in range(layout.width) if guessed[n].dtype.kind not in "fiu"}
        frame = _read_csv(text, layout, textual)
    infinite = {n for n in range(layout.width) if n not in textual and np.isinf(frame[n]).any()}
    if infinite:
        textual |= infinite
        frame = _read_csv(text, layout, textual)
    return frame, textual


def _read_csv(text: Text, layout: Layout, textual: set[int], *, guess: bool = False) -> Any:
    import pandas as pd

    stream = BytesIO(text.content)
    stream.seek(_body_start(text, layout))
    numeric = [number for number in range(layout.width) if number not in textual]
    types: dict[int, Any] = dict.fromkeys(textual, object)
    blanks = layout.separator == BLANKS
    options: dict[str, Any] = {
        "dtype": types if guess else types | dict.fromkeys(numeric, np.float64),
        "na_values": dict.fromkeys(numeric, _MISSING),
        # Read at once, a column that turns out to be no numbers keeps the texts of all its fields.
        "low_memory": not guess,
        "quoting": csv.QUOTE_NONE if blanks else csv.QUOTE_MINIMAL,
    }
    if _version(pd.__version__) < (3, 1):
        options["float_precision"] = "round_trip"  # later versions do so anyway, and warn
    return pd.read_csv(
        stream,
        sep=r"\s+" if blanks else layout.separator,
        decimal=layout.decimal,
        header=None,
        names=range(layout.width),
        index_col=False,
        keep_default_na=False,
        skipinitialspace=True,
        encoding="utf-8",
        **options,
    )


def _version(text: str) -> tuple[int, ...]:
    return tuple(int(part) for part in text.split(".")[:2])


def _from_texts(fields: list[str], decimal: Decimal) -> _Parsed:
    """Turn fields into numbers, or leave all as they are where one is none."""
    good = _NUMBER[decimal].fullmatch
    numbers = np.empty(len(fields))
    for row, field in enumerate(fields):
        number = nan
        if field not in _MISSING:
            number = float(field.replace(decimal, ".")) if good(field) else nan
            if not isfinite(number):
                return _Parsed(np.array(fields, dtype=object), (row, field))
        numbers[row] = number
    return _Parsed(numbers)


def _line_numbers(text: Text, layout: Layout, wanted: set[int]) -> dict[int, int]:
    """Find the lines where rows of the body start."""
    rows = islice(_body_rows(text, layout), max(wanted, default=-1) + 1)
    return {index: row.line for index, row in enumerate(rows) if index in wanted}


def _refuse_short_rows(text: Text, layout: Layout, last: _Parsed) -> None:
    """Refuse rows that end early; pandas fills them up, so their last field is missing."""
    if not last.missing.any():
        return
    start = _body_start(text, layout)
    between = len(last.values) * (layout.width - 1)
    quoted = text.content.find(b'"', start) >= 0
    blanks = layout.separator == BLANKS
    if not (quoted or blanks) and text.content.count(layout.separator.encode(), start) == between:
        return
    row = Row(0, [])
    for row, following in pairwise(chain(_body_rows(text, layout), [None])):
        pass
