"""Files that run.toml names, the columns in them, and columns in SI: with the errors that all of that can have."""

from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.base.errors import ReaderError, UnitError, did_you_mean
from tribopipe.base.files import beside, leads_out, read_file
from tribopipe.base.units import KINDS, is_unit_of, to_si
from tribopipe.documents.manifest import ColumnSource
from tribopipe.readers.column_names import bare_name
from tribopipe.readers.reader import ReadColumn, ReadTable
from tribopipe.readers.tables import is_number
from tribopipe.results.run import SourceFile

T = TypeVar("T")
_MOST = 1e60


def read_source(folder: Path, name: str, key: str = "signals.file", what: str = "signal file") -> SourceFile:
    """Read a file that a key of run.toml names. Raises ``ReaderError`` where that cannot be done."""
    return with_file(folder, name, lambda path: SourceFile(name, read_file(path)), key, what)


def with_file(
    folder: Path, name: str, read: Callable[[Path], T], key: str = "signals.file", what: str = "signal file"
) -> T:
    """Return what is read of a file that a key of run.toml names. Raises ``ReaderError`` where that cannot be done."""
    path = folder / name
    if leads_out(path, folder):
        raise ReaderError(
            f"{name}: found a link that leads out of the run folder; expected a {what} in it, since a run contains all "
            "its files; replace the link with a copy of the file"
        )
    try:
        if path.is_dir():
            raise ReaderError(f"{name}: found a folder; expected a {what}; name the file in run.toml, {key}")
        return read(path)
    except FileNotFoundError:
        raise ReaderError(
            f"{name}: no such file; expected the {what} that run.toml names; {did_you_mean(name, beside(path))}"
        ) from None
    except OSError as error:
        raise ReaderError(f"{name}: cannot be read ({error.strerror}); check it and its permissions") from None


def find_column(table: ReadTable, wanted: str, meaning: str, file: str) -> ReadColumn:
    """Return the column with a name, with or without unit. Raises ``ReaderError`` if there is none or more than one."""
    exact = [column for column in table.columns if column.name == wanted.strip()]
    found = exact or [column for column in table.columns if bare_name(column.name) == wanted.strip()]
    if len(found) == 1:
        return found[0]
    names = [column.name for column in table.columns]
    if len(found) > 1:
        raise ReaderError(
            f"{file}: found {len(found)} columns that could be {wanted!r} for {meaning}; expected one; "
            f"write the name with its unit: {', '.join(repr(column.name) for column in found)}"
        )
    raise ReaderError(
        f"{file}: found no column {wanted!r} for {meaning}; expected it in the header; {did_you_mean(wanted, names)}"
    )


def needs_unit(kind: str) -> bool:
    """Return whether numbers of a kind have no meaning without a unit; a percentage may as well be a share of 1."""
    return KINDS[kind].si != "1" or kind == "percentage"


def unit_of(column: ReadColumn, source: ColumnSource | None) -> str | None:
    """Return the unit of a column from the manifest, else from the file."""
    return (source.unit if source else None) or column.unit


def is_a_weight(column: ReadColumn, source: ColumnSource | None, kind: str) -> bool:
    """Return whether a force is given as a mass, which as a force can only be the weight of it."""
    unit = unit_of(column, source)
    return kind == "force" and unit is not None and is_unit_of(unit, "mass")


def column_in_si(
    column: ReadColumn, source: ColumnSource | None, meaning: str, kind: str, file: str, before: int = 0
) -> Column:
    """Return a column in SI, by the manifest's unit or the file's own; so many rows were read ``before`` it.

    Raises ``ReaderError`` where not all of it are numbers, or the unit is missing or of another kind.
    """
    if column.first_bad is not None:
        line, text = column.first_bad
        raise ReaderError(
            f"{file}, line {line}, column {column.name!r}: found {text!r}; expected a number for {meaning}"
            f"{' with the decimal sign of the others' if is_number(text, '.,') else ''}; correct that line, leave the "
            "field empty for a missing sample, or map another column"
        )
    unit = unit_of(column, source)
    if unit is None and needs_unit(kind):
        raise ReaderError(
            f"{file}, column {column.name!r}: found no unit; expected one for {meaning}; add it in run.toml: "
            f"{meaning} = {{ column = {column.name!r}, unit = … }}"
        )
    if is_a_weight(column, source, kind):
        unit = f"({unit})*g_0"
    values = np.asarray(column.values, dtype=float)
    _refuse_absurd(values, f"{file}, column {column.name!r}", meaning, before)
    try:
        return np.asarray(to_si(values, unit or "1", kind), dtype=float)
    except UnitError as error:
        raise ReaderError(f"{file}, column {column.name!r} for {meaning}: {error}") from None


def _refuse_absurd(values: Column, where: str, meaning: str, before: int) -> None:
    """Refuse numbers whose sums and squares would be none any more."""
    absurd = np.flatnonzero(np.abs(values) > _MOST)
    if len(absurd):
        raise ReaderError(
            f"{where}: found {values[absurd[0]]:g} in row {before + absurd[0] + 1} of the table; expected a value that "
            f"an instrument can record for {meaning}; correct that row, or leave the field empty"
        )
