"""Files of several parts, such as sheets or groups: parts with the same columns are consecutive.

Where the sheets of a workbook each hold a test, one of them has to be chosen.
"""

from collections.abc import Mapping, Sequence
from itertools import chain
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tribopipe.base.errors import ReaderError, did_you_mean
from tribopipe.readers.number_fields import is_mostly_numbers, together
from tribopipe.readers.reader import ReadColumn, Reader, ReadTable
from tribopipe.readers.tables import bare_name


def refuse_sheet(sheet: str | None, reader: Reader, file: str) -> None:
    """Raise ``ReaderError`` where a sheet is named of a file that has none."""
    if sheet is not None and not hasattr(reader, "sheets"):
        raise ReaderError(
            f"{file}: found the sheet {sheet!r} specified for a file in the format {reader.name}, which has no sheets; "
            "expected a workbook or a MAT-file; remove the sheet"
        )


def unknown_sheet(file: str, sheet: str, names: Sequence[str]) -> ReaderError:
    """Return the error of a sheet that is not in the workbook."""
    return ReaderError(
        f"{file}: found no sheet {sheet!r}; expected one of {', '.join(map(repr, names))}; "
        f"{did_you_mean(sheet, list(names))}"
    )


def several_tests(file: str, names: Sequence[str]) -> ReaderError:
    """Return the error of a workbook whose sheets each hold a table like a test."""
    listed = " and ".join([", ".join(map(repr, names[:-1])), repr(names[-1])])
    return ReaderError(
        f"{file}: found a test table in each of the sheets {listed}; expected one test; choose one with "
        "`tribopipe new --sheet NAME` (in run.toml, sheet = NAME under [[signals]]), or create one run per sheet with "
        "`tribopipe new --each-sheet`"
    )


SEGMENT = "segment"
"""Name of the column that numbers the parts."""


def join_parts(file: str, kind: str, parts: Mapping[str, ReadTable]) -> ReadTable:
    """Put parts with the same columns one after the other; a list of settings next to them is left out with a note.

    Raises ``ReaderError`` that names the parts where they hold different tables.
    """
    shapes = [_shape(table) for table in parts.values() if _is_record(table)]
    tables = {name: table for name, table in parts.items() if not shapes or _shape(table) in shapes}
    left = [f"{kind} {name!r} contains no test data and is omitted" for name in parts if name not in tables]
    (first, table), *others = tables.items()
    for name, other in others:
        if _shape(other) != _shape(table):
            raise ReaderError(
                f"{file}: found different tables in the {kind}s {first!r} ({_listed(table)}) and {name!r} "
                f"({_listed(other)}); expected one table, or parts with the same columns; save the {kind} of the run "
                "in a separate file"
            )
    whole = list(tables.values())
    return ReadTable(
        _joined(whole) if others else table.columns,
        "".join(part.header for part in whole),
        (*dict.fromkeys(chain.from_iterable(part.notes for part in whole)), *left),
        table.facts,
    )


def tests_among(parts: Mapping[str, ReadTable]) -> dict[str, ReadTable]:
    """Return the parts that may each be the record of a test."""
    return {name: table for name, table in parts.items() if _is_record(table)}


def _is_record(table: ReadTable) -> bool:
    """Return whether a table may be a record of a test: two columns of numbers, two rows."""
    numeric = [column for column in table.columns if is_mostly_numbers(column)]
    return len(numeric) > 1 and len(numeric[0].values) > 1


def _shape(table: ReadTable) -> list[tuple[str, str | None]]:
    return [(column.name, column.unit) for column in table.columns]


def _listed(table: ReadTable) -> str:
    names = [column.name for column in table.columns]
    return ", ".join(names[:6]) + (", …" if len(names) > 6 else "")


def _joined(tables: Sequence[ReadTable]) -> tuple[ReadColumn, ...]:
    lengths = [len(table.columns[0].values) for table in tables]
    columns = tuple(column_below(same) for same in zip(*(table.columns for table in tables), strict=True))
    if any(column.name == SEGMENT for column in columns):
        return columns
    numbers = np.repeat(np.arange(1.0, len(tables) + 1), lengths)
    return (*columns, ReadColumn(SEGMENT, numbers, "1"))


def column_below(columns: Sequence[ReadColumn]) -> ReadColumn:
    """Put the parts of a column one below the other."""
    first = columns[0]
    bad = next((column.first_bad for column in columns if column.first_bad), None)
    values = below_each_other([column.values for column in columns], texts=bad is not None)
    return ReadColumn(first.name, values, first.unit, first.signal, first.axis, bad, together(columns))


def below_each_other(parts: Sequence[NDArray[Any]], *, texts: bool) -> NDArray[Any]:
    """Put the parts of a column together; numbers are texts again where another part holds ``texts``."""
    return np.concatenate([_as_texts(part) for part in parts] if texts else parts)


def _as_texts(values: NDArray[Any]) -> NDArray[Any]:
    if values.dtype.kind != "f":
        return values
    return np.array(["" if value != value else repr(value) for value in values.tolist()], dtype=object)


def is_time(column: ReadColumn) -> bool:
    """Return whether a column is the time, by the format's word or its own name."""
    return column.signal == "time" or bare_name(column.name).lower() == "time"


def seconds_since_first(stamps: NDArray[Any]) -> NDArray[np.float64]:
    """Turn dates with times of day into seconds since the first one; NaN where one is missing."""
    known = stamps[~np.isnat(stamps)]
    return np.asarray((stamps - known[0]) / np.timedelta64(1, "s"), dtype=np.float64)
