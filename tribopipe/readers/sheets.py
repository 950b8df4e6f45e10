"""Sheets of a workbook: which of them a run is made of."""

from collections.abc import Sequence

from tribopipe.base.errors import ReaderError, did_you_mean
from tribopipe.readers.reader import Reader

WORKBOOK = "workbook"
"""Name of the reader of files that have sheets."""


def refuse_sheet(sheet: str | None, reader: Reader, file: str) -> None:
    """Raise ``ReaderError`` where a sheet is named of a file that has none."""
    if sheet is not None and reader.name != WORKBOOK:
        raise ReaderError(
            f"{file}: found the sheet {sheet!r} specified for a file of the format {reader.name}, which has no sheets; "
            "expected a workbook; remove the sheet"
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
        f"{file}: found a table like that of a test in each of the sheets {listed}; expected one test; choose one with "
        "`tribopipe new --sheet NAME` (in run.toml, sheet = NAME under [[signals]]), or make a run of each with "
        "`tribopipe new --each-sheet`"
    )
