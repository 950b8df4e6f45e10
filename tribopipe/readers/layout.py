"""Position and format of the table in a text.

Files that may be read otherwise than meant, and so could give wrong numbers, are refused: the layout states the
reason.
"""

import re
from collections import Counter
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Literal

from tribopipe.base.units import is_unit
from tribopipe.readers.reader import Hints
from tribopipe.readers.tables import INTEGER, MISSING, Table, count_numbers, find_table, is_number
from tribopipe.readers.text import LINE_END, LONGEST_LINE, Row, Text, lines_from, sampled_rows, trimmed

_MAYBE_THOUSANDS = re.compile(r"[+-]?[1-9]\d{0,2}[.,]\d{3}", re.ASCII)
_ASK_FOR_SEPARATOR = (
    "where the comma may be a column separator or a decimal comma; expected an unambiguous separator; specify "
    "separator and decimal in run.toml"
)


def find_doubt(text: Text, hints: Hints, table: Table) -> str | None:
    """Return the reason why a table is ambiguous, if it is."""
    doubt = _second_table(table)
    if doubt is None and hints.separator is None and table.separator == ",":
        doubt = _comma_doubt(table)
    if doubt is None and hints.decimal is None:
        doubt = _two_signs(table) or _maybe_thousands(table)
    if doubt is None and text.unterminated:
        doubt = _cut_number(text, table)
    return doubt and f"{text.name}, {doubt}"


def _second_table(table: Table) -> str | None:
    above = [
        row
        for row in table.rows[: table.top]
        if is_number(row.cells[0], table.signs) and 2 * count_numbers(row, table.signs) > len(trimmed(row.cells))
    ]
    for row, following in pairwise(above):
        if len(row.cells) == len(following.cells) > 1 and following.line == row.line + 1:
            return (
                f"line {row.line}: found data rows above the header in line {table.rows[table.top].line}; "
                "expected one table per file; split the file"
            )
    return None


def _comma_doubt(table: Table) -> str | None:
    """Doubt a comma as separator where it may as well stand inside numbers."""
    for row in table.rows[table.body :]:
        for cell in row.cells:
            parts = cell.split()
            if len(parts) > 1 and all(is_number(part, ".") for part in parts):
                return f"line {row.line}: found {cell!r} between commas, {_ASK_FOR_SEPARATOR}"
    pointed = any(not INTEGER.fullmatch(number) for _, _, number in table.numbers)
    names = table.names
    if pointed or len(names) % 2 or not all(unit and is_unit(unit) for unit in names[1::2]):
        return None
    return f"line {table.rows[table.top].line}: found '{', '.join(names)}' above integers, {_ASK_FOR_SEPARATOR}"


def _two_signs(table: Table) -> str | None:
    """Doubt the decimal separator where numbers are written with both."""
    first: dict[str, tuple[int, str]] = {}
    for line, _, number in table.numbers:
        for sign in ".,":
            if sign in number:
                first.setdefault(sign, (line, number))
    if len(first) < 2:
        return None
    (line, number), (other_line, other) = sorted(first.values())
    return (
        f"line {other_line}: found {other!r}, while line {line} contains {number!r}; expected one decimal separator; "
        "correct the lines that differ, or specify decimal in run.toml"
    )


def _maybe_thousands(table: Table) -> str | None:
    """Doubt numbers such as 1,234 in a column with plain integers, where no other shows the decimal separator.

    Between commas, where such a number stands in quotation marks, it is in doubt in any column.
    """
    if table.separator == "," and "," not in table.signs:
        return None
    signed = [entry for entry in table.numbers if not INTEGER.fullmatch(entry[2])]
    plain = {column for _, column, number in table.numbers if INTEGER.fullmatch(number)}
    if not all(_MAYBE_THOUSANDS.fullmatch(number) for _, _, number in signed):
        return None
    for line, column, number in signed:
        if column in plain or table.separator == ",":
            return (
                f"line {line}: found {number!r} among integers, where the separator may be a decimal or a thousands "
                "separator; "
                "expected an unambiguous decimal separator; specify decimal in run.toml, and remove thousands "
                "separators"
            )
    return None


def _cut_number(text: Text, table: Table) -> str | None:
    """Doubt a last number without a line end that has fewer decimals than every one above it."""
    column = table.width - 1
    rows = [row for row in table.rows[table.body :] if len(row.cells) == table.width and row.cells[column]]
    final = re.split(r"[\r\n]", text.content[-LONGEST_LINE:].decode(errors="ignore"))[-1]
    last = next(iter(sampled_rows([final], table.separator)), None)
    if last is None or len(last.cells) != table.width or column not in table.numeric:
        return None
    above = rows[:-1] if rows and rows[-1].cells == last.cells else rows
    decimals = {_decimals(row.cells[column]) for row in above}
    found = last.cells[column]
    if len(above) < 2 or len(decimals) != 1 or not found or _decimals(found) >= decimals.pop():
        return None
    return (
        f"last line: found {found!r} with fewer decimal places than the numbers above it and without a line ending; "
        "expected complete rows; "
        "the file ends in the middle of a row: copy it again from the instrument, or delete the last line"
    )


def _decimals(number: str) -> int:
    return len(re.split(r"[.,]", f"{number}.")[1])


Decimal = Literal[".", ","]
_NEARLY_ALL = 0.8


@dataclass(frozen=True)
class Layout:
    """Position and format of the table in a text."""

    separator: str
    decimal: Decimal
    names: tuple[str, ...]
    """Column names as written in the header; "" for a missing name."""
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
    words: frozenset[int] = frozenset()
    """Columns that stay texts even where all of these are numbers, as another part of the file has words there."""
    doubt: str | None = None
    """Why the numbers might be read in another way than meant."""


def find_layout(text: Text, hints: Hints) -> Layout:
    """Find the table in a text; where it is ambiguous, the layout states so.

    Raises ``ReaderError`` where there is none, saying what is missing.
    """
    table, lines = find_table(text, hints)
    later = [] if hints.decimal else _later_rows(text, table, lines)
    seen = replace(table, rows=table.rows + later) if later else table
    return _layout(table, lines, hints.decimal or _decimal(seen), find_doubt(text, hints, seen))


def _layout(table: Table, lines: list[str], decimal: Decimal, doubt: str | None) -> Layout:
    body = table.rows[table.body :]
    cells = ((column, cell) for row in body for column, cell in enumerate(row.cells))
    return Layout(
        separator=table.separator,
        decimal=decimal,
        names=table.names,
        line=body[0].line,
        header="".join(lines[: body[0].line - 1]),
        width=table.width,
        least=_least(table),
        units=table.units,
        textual=frozenset(c for c, cell in cells if cell not in MISSING and not is_number(cell, decimal)),
        doubt=doubt,
    )


def _least(table: Table) -> int:
    """Return the number of fields of a complete row: the named ones, and empty ones at the end of nearly every row."""
    named, body = len(trimmed(table.names)), table.rows[table.body :]
    padded = Counter(len(row.cells) for row in body if len(row.cells) > named and not any(row.cells[named:]))
    usual, times = padded.most_common(1)[0] if padded else (named, 0)
    return usual if times >= _NEARLY_ALL * len(body) else named


def _later_rows(text: Text, table: Table, lines: list[str]) -> list[Row]:
    """Give rows from the first decimal separator on, where the sample of a longer file shows none."""
    if table.separator == "," or any(not INTEGER.fullmatch(number) for _, _, number in table.numbers):
        return []
    behind = text.start + len("".join(lines).encode())
    found = [at for sign in (b".", b",") if (at := text.content.find(sign, behind)) >= 0]
    if not found:
        return []
    start = max(text.content.rfind(end, 0, min(found)) for end in (b"\r", b"\n")) + 1
    before = len(LINE_END.findall(text.content, text.start, start))
    later, _ = lines_from(text, start)
    return [Row(before + row.line, row.cells) for row in sampled_rows(later, table.separator)]


def _decimal(table: Table) -> Decimal:
    signs = Counter(sign for _, _, number in table.numbers for sign in ".," if sign in number)
    return "," if signs[","] > signs["."] else "."
