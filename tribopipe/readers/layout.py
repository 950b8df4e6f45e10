"""Where the table stands in a text and how it is written."""

from collections import Counter
from dataclasses import dataclass, replace
from typing import Literal

from tribopipe.readers.ambiguity import find_doubt
from tribopipe.readers.column_names import INTEGER
from tribopipe.readers.placeholders import MISSING
from tribopipe.readers.reader import Hints
from tribopipe.readers.tables import Table, find_table, is_number
from tribopipe.readers.text import LINE_END, Row, Text, lines_from, sampled_rows, trimmed

Decimal = Literal[".", ","]
_NEARLY_ALL = 0.8


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
    """Give rows from the first decimal sign on, where the sample of a longer file shows none."""
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
