"""A file as the instrument wrote it: which format it is of, and what stands in it."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np

from tribopipe.errors import ReaderError, did_you_mean
from tribopipe.files import beside, read_file
from tribopipe.ingest.meanings import Meaning, meanings_of
from tribopipe.ingest.reader import Hints, Holds, Match, ReadColumn, Reader, ReadTable
from tribopipe.ingest.registry import Judged, candidates, chosen, reader_named
from tribopipe.records.manifest import is_described
from tribopipe.run import SourceFile


@dataclass(frozen=True)
class Export:
    """A file that a reader has read."""

    source: SourceFile
    reader: Reader
    match: Match
    others: tuple[Judged, ...]
    """Further readers that claim the file, the surest first."""
    table: ReadTable

    @property
    def name(self) -> str:
        """Name of the file."""
        return self.source.name

    @property
    def rows(self) -> int:
        """Number of rows."""
        return max((len(column.values) for column in self.table.columns), default=0)

    @cached_property
    def meanings(self) -> Mapping[str, Meaning]:
        """What columns mean, by their names; none for a profile."""
        return meanings_of(self.table.columns) if self.reader.holds == "signals" else {}


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
    source = open_export(path)
    if reader is None:
        best, *others = chosen(source, candidates(source, holds))
    else:
        best, others = Judged(reader, Match(1.0, "it was named")), []
    table = best.reader.read(source, hints or Hints())
    return Export(source, best.reader, best.match, tuple(others), table)


def open_export(path: Path) -> SourceFile:
    """Read the bytes of a file. Raises ``ReaderError`` where that cannot be done."""
    try:
        if path.is_dir():
            raise ReaderError(f"{path}: found a folder; expected a file that an instrument wrote; name its files")
        return SourceFile(path.name, read_file(path))
    except FileNotFoundError:
        raise ReaderError(
            f"{path}: no such file; expected one that an instrument wrote; {did_you_mean(path.name, beside(path))}"
        ) from None
    except OSError as error:
        raise ReaderError(f"{path}: cannot be read ({error.strerror}); check it and its permissions") from None


def chosen_reader(named: str, folder: Path = Path()) -> Reader:
    """Give the reader of a name, or the one that a file (our-rig.toml, beside the folder's) describes.

    Raises ``ReaderError`` or ``ManifestError`` where there is no such reader.
    """
    if not is_described(named):
        return reader_named(named)
    from tribopipe.ingest.described import described_reader, load_reader_profile

    return described_reader(load_reader_profile(folder / named))
