"""A file as the instrument wrote it: which format it is of, and what stands in it."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import NamedTuple, TypeVar

import numpy as np

from tribopipe.base.errors import ReaderError, did_you_mean
from tribopipe.base.files import beside, pieces_of, read_file
from tribopipe.documents.manifest import is_described
from tribopipe.readers import long_text
from tribopipe.readers.column_meanings import Meaning, OpenUnit, meanings_of, open_units, roles_of
from tribopipe.readers.header_facts import HeaderFacts, header_facts
from tribopipe.readers.long_text import LongText
from tribopipe.readers.number_fields import remarks
from tribopipe.readers.reader import (
    Hints,
    Holds,
    Judged,
    Match,
    ReadColumn,
    Reader,
    ReadTable,
    candidates,
    chosen,
    reader_named,
)
from tribopipe.readers.table_parts import refuse_sheet
from tribopipe.results.run import SourceFile

T = TypeVar("T")


@dataclass(frozen=True)
class Export:
    """A file that a reader has read."""

    source: SourceFile
    reader: Reader
    match: Match
    others: tuple[Judged, ...]
    """Further readers that claim the file, the surest first."""
    table: ReadTable
    """Table of the file; only its first rows if the file is too long for memory."""
    most_rows: int | None = None
    """Rows of such a file, or more where lines are blank."""

    @property
    def name(self) -> str:
        """Name of the file."""
        return self.source.name

    @property
    def rows(self) -> int:
        """Number of rows."""
        if self.most_rows is not None:
            return self.most_rows
        return max((len(column.values) for column in self.table.columns), default=0)

    @property
    def notes(self) -> tuple[str, ...]:
        """Return the notes to the user about how the file was read."""
        return (*remarks(self.table), *self.header.notes)

    @cached_property
    def header(self) -> HeaderFacts:
        """Return the facts in the header about the run, as defined by the format or else from free text lines."""
        if self.table.facts or self.reader.holds != "signals":
            return HeaderFacts(dict(self.table.facts), {})
        names = [column.name for column in self.table.columns]
        return header_facts(self.table.header, names, commas=self.table.decimal == ",")

    @cached_property
    def meanings(self) -> Mapping[str, Meaning]:
        """Return the meanings of the columns by column name; empty for a profile."""
        return meanings_of(self.table.columns) if self.reader.holds == "signals" else {}

    @property
    def friction(self) -> str | None:
        """Name of the column that is taken for the friction coefficient."""
        taken = (name for name, meant in self.meanings.items() if meant.signal == "friction_coefficient")
        return next((name for name in taken if not self.meanings[name].doubt), None)

    @cached_property
    def open_units(self) -> Mapping[str, OpenUnit]:
        """Units that the header leaves open, by the name of the column; as identities propose them."""
        if self.reader.holds != "signals":
            return {}
        roles = roles_of(self.table.columns)
        return {roles[role].name: unit for role, unit in open_units(roles).items()}


class Range(NamedTuple):
    """Least and largest value of a column, none where it holds no number, and how many are missing."""

    least: float | None
    largest: float | None
    missing: int


def range_of(column: ReadColumn) -> Range:
    """Give the range of a column as the file writes it."""
    if column.values.dtype.kind != "f":
        return Range(None, None, int(np.count_nonzero(column.values == "")))
    there = column.values[~np.isnan(column.values)]
    missing = len(column.values) - len(there)
    return Range(float(there.min()), float(there.max()), missing) if len(there) else Range(None, None, missing)


def read_export(
    path: Path, reader: Reader | None = None, hints: Hints | None = None, holds: Holds | None = None
) -> Export:
    """Read a file by the reader named, or the one that knows its content, among those for what it should hold.

    Raises ``ReaderError`` where there is no such file, no reader or several for it, or where it is broken.
    """
    hints = hints or Hints()
    if _opened(path, _size) > long_text.LARGE:
        long = _long_export(path, reader, hints, holds)
        if long is not None:
            return long
    source = open_export(path)
    best, *others = _judged(source, reader, holds)
    refuse_sheet(hints.sheet, best.reader, source.name)
    return Export(source, best.reader, best.match, tuple(others), best.reader.read(source, hints))


def _long_export(path: Path, reader: Reader | None, hints: Hints, holds: Holds | None) -> Export | None:
    """Read the beginning of a file that is too long to be held; none where it has to be read whole."""
    head = _opened(path, lambda path: SourceFile(path.name, next(pieces_of(path, long_text.HEAD))))
    best, *others = _judged(head, reader, holds)
    if best.reader.name != long_text.READER:
        return None
    text = _opened(path, lambda path: long_text.long_text(path, path.name, hints))
    if text is None:
        return None
    return Export(text.source, best.reader, best.match, tuple(others), _first_rows(text), text.most_rows)


def _size(path: Path) -> int:
    return path.stat().st_size


def _judged(source: SourceFile, reader: Reader | None, holds: Holds | None) -> list[Judged]:
    """Give the reader named, or those that claim a file. Raises ``ReaderError`` where none does."""
    if reader is not None:
        return [Judged(reader, Match(1.0, "specified by name"))]
    return chosen(source, candidates(source, holds))


def _first_rows(text: LongText) -> ReadTable:
    table = next(text.tables({}))
    rows = len(table.columns[0].values)
    note = f"too large to read at once: only the first {rows:,} of about {text.most_rows:,} rows were examined"
    return replace(table, notes=(*table.notes, note))


def open_export(path: Path) -> SourceFile:
    """Read the bytes of a file. Raises ``ReaderError`` where that cannot be done."""
    return _opened(path, lambda path: SourceFile(path.name, read_file(path)))


def _opened(path: Path, read: Callable[[Path], T]) -> T:
    try:
        if path.is_dir():
            raise ReaderError(f"{path}: found a folder; expected an instrument file; specify the files in the folder")
        return read(path)
    except FileNotFoundError:
        raise ReaderError(
            f"{path}: no such file; expected an instrument file; {did_you_mean(path.name, beside(path))}"
        ) from None
    except OSError as error:
        raise ReaderError(
            f"{path}: cannot be read ({error.strerror}); expected a readable file; check its permissions"
        ) from None


def chosen_reader(named: str) -> Reader:
    """Return the reader with a name, or the reader that a file describes (our-rig.toml, next to the run folder).

    Raises ``ReaderError`` or ``ManifestError`` where there is no such reader.
    """
    if not is_described(named):
        return reader_named(named)
    from tribopipe.readers.toml_reader import described_reader

    return described_reader(Path(named))
