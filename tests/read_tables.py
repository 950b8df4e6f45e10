"""Looking at what readers give, and at what they make of spoilt files."""

import numpy as np

from tribopipe.base.errors import ReaderError
from tribopipe.readers.reader import Hints, ReadColumn, Reader, ReadTable
from tribopipe.results.run import SourceFile


def column(table: ReadTable, name: str) -> ReadColumn:
    """Give the first column of a name."""
    return next(each for each in table.columns if each.name == name)


def values(table: ReadTable) -> np.ndarray:
    """Give all columns side by side."""
    return np.column_stack([each.values for each in table.columns])


def read_or_refused(reader: Reader, name: str, content: bytes) -> ReadTable | None:
    """Read what may be spoilt: whole rows come of it, or nothing where it is refused by an error that names it."""
    source = SourceFile(name, content)
    assert 0 <= reader.match(source).confidence <= 1
    try:
        table = reader.read(source, Hints())
    except ReaderError as error:
        assert str(error).startswith(name)  # noqa: PT017
        return None
    assert len({len(each.values) for each in table.columns}) == 1
    return table
