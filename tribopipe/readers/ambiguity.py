"""Ways in which a table may be read otherwise than meant: files that could give wrong numbers are refused."""

import re
from itertools import pairwise

from tribopipe.base.units import is_unit
from tribopipe.readers.column_names import INTEGER
from tribopipe.readers.reader import Hints
from tribopipe.readers.tables import Table, count_numbers, is_number
from tribopipe.readers.text import LONGEST_LINE, Text, sampled_rows, trimmed

_MAYBE_THOUSANDS = re.compile(r"[+-]?[1-9]\d{0,2}[.,]\d{3}", re.ASCII)
_ASK_FOR_SEPARATOR = (
    "expected commas to be clearly column separators or decimal signs; specify separator and decimal in run.toml"
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
                f"line {row.line}: found rows of numbers above the names in line {table.rows[table.top].line}; "
                "expected one table per file; split it"
            )
    return None


def _comma_doubt(table: Table) -> str | None:
    """Doubt a comma as separator where it may as well stand inside numbers."""
    for row in table.rows[table.body :]:
        for cell in row.cells:
            parts = cell.split()
            if len(parts) > 1 and all(is_number(part, ".") for part in parts):
                return f"line {row.line}: found {cell!r} between commas; {_ASK_FOR_SEPARATOR}"
    pointed = any(not INTEGER.fullmatch(number) for _, _, number in table.numbers)
    names = table.names
    if pointed or len(names) % 2 or not all(unit and is_unit(unit) for unit in names[1::2]):
        return None
    return f"line {table.rows[table.top].line}: found '{', '.join(names)}' above integers; {_ASK_FOR_SEPARATOR}"


def _two_signs(table: Table) -> str | None:
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
        f"line {other_line}: found {other!r}, while line {line} has {number!r}; expected one decimal sign; correct the "
        "lines that differ, or specify decimal in run.toml"
    )


def _maybe_thousands(table: Table) -> str | None:
    """Doubt numbers such as 1,234 in a column with plain integers, where no other shows the decimal sign.

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
                f"line {line}: found {number!r} among integers; expected a sign that is clearly a decimal sign or a "
                "thousands separator; specify decimal in run.toml, and remove thousands separators"
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
        f"last line: found {found!r} with fewer decimals than above and without a line end; expected complete rows; "
        "the file ends in the middle of a row: copy it again from the instrument, or delete that line"
    )


def _decimals(number: str) -> int:
    return len(re.split(r"[.,]", f"{number}.")[1])
