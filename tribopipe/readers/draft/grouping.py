"""Which files of a run continue each other, and which hold further channels over the same time base."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.base.errors import ReaderError
from tribopipe.base.files import natural_order
from tribopipe.readers.export_files import Export


@dataclass(frozen=True)
class Group:
    """Files of one format and the same columns, which continue each other: one [[signals]] of run.toml."""

    exports: tuple[Export, ...]

    @property
    def first(self) -> Export:
        """The file with which the test starts."""
        return self.exports[0]

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the files in the order of the test."""
        return tuple(export.name for export in self.exports)

    @property
    def rows(self) -> int:
        """Rows of all files."""
        return sum(export.rows for export in self.exports)

    @property
    def clocks_begin_anew(self) -> bool:
        """Whether time falls back from each file to the next, as it does between tests too."""
        times = [found[np.isfinite(found)] for export in self.exports if (found := _time(export)) is not None]
        known = len(times) == len(self.exports) > 1 and all(map(len, times))
        return known and all(later[0] < before[-1] for before, later in pairwise(times))

    def __str__(self) -> str:
        return self.names[0] if len(self.names) == 1 else f"{self.names[0]} … {self.names[-1]}"


def grouped(exports: Sequence[Export]) -> list[Group]:
    """Put files together that continue each other, in natural order.

    Raises ``ReaderError`` where what is left does not share its rows, so that it cannot be of one test.
    """
    alike: dict[object, list[Export]] = {}
    for export in exports:
        columns = tuple((column.name, column.unit) for column in export.table.columns)
        alike.setdefault((export.reader.name, columns), []).append(export)
    groups = [Group(tuple(sorted(found, key=lambda export: natural_order(export.name)))) for found in alike.values()]
    for group in groups[1:]:
        _refuse_another_base(groups[0], group)
    return groups


def _refuse_another_base(first: Group, other: Group) -> None:
    if other.rows != first.rows:
        raise ReaderError(
            f"{other}: found {other.rows} rows and columns that differ from {first}, which has {first.rows} rows; "
            "expected files that continue each other, with the same columns, or channels over the same time base, with "
            "the same number of rows; make one run per test"
        )
    before, found = _times(first), _times(other)
    if before is None or found is None:
        return
    seen = min(len(before), len(found))  # of long files the beginnings, which need not be as long
    if np.allclose(before[:seen], found[:seen], rtol=1e-9, atol=0, equal_nan=True):
        return
    raise ReaderError(
        f"{other}: found times that differ from {first}; expected channels over the same time base; make one run per "
        "test, or merge the files on one time base first"
    )


def _times(group: Group) -> Column | None:
    """Give the times of a group in s as far as all files write them so."""
    found = [times for export in group.exports if (times := _time(export)) is not None]
    return np.concatenate(found) if len(found) == len(group.exports) else None


def _time(export: Export) -> Column | None:
    """Give the times of a file in s if it writes them so."""
    for column in export.table.columns:
        meaning = export.meanings.get(column.name)
        if column.unit == "s" and meaning and meaning.signal == "time":
            return column.values
    return None
