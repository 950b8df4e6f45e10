"""Fields of a column as numbers: which are missing, which are placeholders, and which should not be there."""

import math
from collections.abc import Iterable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tribopipe.readers.reader import Placeholders, ReadColumn, ReadTable
from tribopipe.readers.tables import MISSING, is_gap, is_number, is_placeholder

_MOST_LOOKED_AT = 10_000
"""Fields, evenly spread, by which a column of texts is judged."""


class Parsed(NamedTuple):
    """One column; rows are counted from 0."""

    values: NDArray[Any]
    """float64, NaN where a sample is missing; the texts where one of them is neither number nor placeholder."""
    bad: tuple[int, str] | None = None
    """Row and text of that first one."""
    placeholders: tuple[int, int, str] | None = None
    """How many placeholders there are, with row and text of the first."""

    @property
    def missing(self) -> NDArray[np.bool_]:
        """Whether each field is empty."""
        return np.isnan(self.values) if self.values.dtype != object else np.asarray(self.values == "", dtype=bool)


def parse_fields(fields: Sequence[str], decimal: str) -> Parsed:
    """Turn the fields of a column into numbers, or leave all as they are where one is neither number nor gap."""
    numbers = np.full(len(fields), math.nan)
    gaps: list[int] = []
    for row, field in enumerate(fields):
        if field in MISSING:
            continue
        # A number may end in its decimal comma: "3600,".
        digits = field.removesuffix(",") if decimal == "," else field
        if is_number(digits, decimal) and math.isfinite(number := float(digits.replace(decimal, "."))):
            numbers[row] = number
        elif is_placeholder(digits):
            gaps.append(row)
        else:
            return Parsed(np.array(fields, dtype=object), (row, digits))
    return Parsed(numbers, None, (len(gaps), gaps[0], fields[gaps[0]]) if gaps else None)


def text_column(name: str, fields: Sequence[str], unit: str | None) -> ReadColumn:
    """Make a column of the texts of a binary file, which are numbers where all of them are; lines are rows from 1."""
    found = parse_fields([field.strip() for field in fields], ".")
    bad = found.bad and (found.bad[0] + 1, found.bad[1])
    gaps = found.placeholders and Placeholders(found.placeholders[0], found.placeholders[1] + 1, found.placeholders[2])
    return ReadColumn(name, np.array(fields, dtype=object) if bad else found.values, unit, None, None, bad, gaps)


def is_mostly_numbers(column: ReadColumn) -> bool:
    """Return whether a column is one of numbers, though some of its fields may be none."""
    if column.first_bad is None:
        return True
    some = column.values[:: 1 + len(column.values) // _MOST_LOOKED_AT].tolist()
    filled = [field for field in some if not is_gap(field)]
    return 2 * sum(is_number(field, ".,") for field in filled) > len(filled)


def together(columns: Iterable[ReadColumn]) -> Placeholders | None:
    """Count the placeholders of columns, or of parts of one, together; the first is that of the first one."""
    found = [column.placeholders for column in columns if column.placeholders]
    found.sort(key=lambda one: one.line)
    return found[0]._replace(fields=sum(one.fields for one in found)) if found else None


def remarks(table: ReadTable) -> tuple[str, ...]:
    """Report what to know about how a table was read: a reader's notes, placeholders, words among numbers."""
    return (*table.notes, *_placeholder_notes(table.columns), *_word_notes(table.columns))


def _placeholder_notes(columns: Iterable[ReadColumn]) -> Iterator[str]:
    for column in columns:
        if column.placeholders:
            count, line, text = column.placeholders
            fields = "field contains a placeholder" if count == 1 else "fields contain placeholders"
            yield f"column {column.name!r}: {count} {fields}, treated as missing; the first is {text!r} in line {line}"


def _word_notes(columns: Iterable[ReadColumn]) -> Iterator[str]:
    for column in columns:
        if column.first_bad and is_mostly_numbers(column):
            line, text = column.first_bad
            yield f"column {column.name!r}: kept as text, since line {line} contains {text!r}, which is not a number"
