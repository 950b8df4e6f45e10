"""The list of runs as CSV."""

import math
from collections.abc import Iterable, Iterator, Sequence

from tribopipe.archive.catalog.columns import COLUMNS, ListedColumn
from tribopipe.archive.catalog.listed import ListedRun
from tribopipe.views.csv_files import csv_lines


def runs_csv(runs: Iterable[ListedRun], columns: Sequence[ListedColumn] = tuple(COLUMNS.values())) -> bytes:
    """Return a list of runs as RFC 4180 has it, in UTF-8.

    Heads are names and units, "load [mN]"; beside each number stands its standard uncertainty, "load uncertainty [mN]".
    What is not known is an empty field.
    """
    heads = [head for column in columns for head in _heads(column)]
    return csv_lines([heads, *([field for column in columns for field in _fields(run, column)] for run in runs)])


def _heads(column: ListedColumn) -> Iterator[str]:
    unit = f" [{column.unit}]" if column.unit else ""
    yield column.name + unit
    if column.kind == "number":
        yield f"{column.name} uncertainty{unit}"


def _fields(run: ListedRun, column: ListedColumn) -> Iterator[float | str]:
    if column.kind != "number":
        yield run.text(column.name)
        return
    for number in (run.number(column.name), run.spread(column.name)):
        yield math.nan if number is None else number
