"""Run archived by tribopipe (.h5): HDF5, laid out by NeXus.

    /entry/archived/format             "tribopipe.run/1", or one of before the first release
    /entry/raw/<signal>                numbers in SI; attributes units, origin ("measured", "derived from …")
    /entry/extra_columns/column_<n>    numbers or texts; attributes column_name, column_unit
    /entry/source_files/file_<n>       description: what stood above the numbers of that file
    /entry/manifest/data               run.toml as JSON, numbers in SI

* Measured signals and extra columns become columns; what was derived would be derived again, and is left out.
* What a run gained later (corrections, fits, marks) is not read, nor are profiles.
* Everything has to be in the file itself: links to other files, virtual datasets and external storage are refused.
"""

import json
import struct
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from tribopipe.base.errors import ReaderError
from tribopipe.base.units import is_unit
from tribopipe.documents.signals import SIGNALS
from tribopipe.readers.number_fields import text_column
from tribopipe.readers.reader import Hints, Holds, Match, ReadColumn, ReadTable
from tribopipe.readers.subprocess_readers import answer_of
from tribopipe.results.run import SourceFile

_MAGIC = b"\x89HDF\r\n\x1a\n"
_SUPERBLOCK = 48
_HEAD_BYTES = 1 << 16
_FORMATS = ("tribopipe.run/1", "tribopipe.archive/1", "tribopipe.archive/2", "tribopipe.archive/3")
_USER_BLOCKS = (0, 512)
"""Offsets of the HDF5 signature: after a user block, or 0 in the earliest files."""
_REMEDY = "copy the file again from the archive"
_FACTS = ("started", "title", "operator", "instrument", "comment", "contact", "conditions")


class NexusReader:
    """Files of an archive of tribopipe."""

    name = "tribopipe-hdf5"
    title = "Run archived by tribopipe (HDF5, NeXus)"
    holds: Holds = "signals"
    suffixes = (".h5",)

    def match(self, source: SourceFile) -> Match:
        """Judge by the magic of HDF5 and the creator, which stands near the start."""
        if _start(source) is None:
            return Match(0.0, "the file does not start with the HDF5 signature")
        if b"tribopipe" not in source.content[:_HEAD_BYTES]:
            return Match(0.2, "an HDF5 file not written by tribopipe")
        return Match(0.95, "an HDF5 file with tribopipe as its creator")

    def read(self, source: SourceFile, hints: Hints) -> ReadTable:  # noqa: ARG002 - nothing of a binary file is open
        """Parse the file; ``ReaderError`` where it is damaged or reaches into other files."""
        _refuse_cut(source)
        answer = answer_of("nexus_fields.py", source, remedy=_REMEDY)
        line, _, numbers = answer.partition(b"\n")
        said = json.loads(line)
        if said["format"] not in _FORMATS:
            raise _refused(source, f"the format {said['format']!r}, but only {', '.join(_FORMATS)} are supported")
        columns = tuple(_columns(said["columns"], np.frombuffer(numbers, "<f8")))
        _check(source, columns)
        return ReadTable(columns, "".join(said["headers"]), (), dict(_facts("", said["manifest"])))


def _refused(source: SourceFile, found: str) -> ReaderError:
    return ReaderError(f"{source.name}: found {found}; expected a run archived by tribopipe; {_REMEDY}")


def _start(source: SourceFile) -> int | None:
    """Return where HDF5 begins in a file; none where it does not."""
    return next((start for start in _USER_BLOCKS if source.content.startswith(_MAGIC, start)), None)


def _refuse_cut(source: SourceFile) -> None:
    """Refuse what is no HDF5, or shorter than the end of file that its superblock names."""
    start = _start(source)
    if start is None or len(source.content) < start + _SUPERBLOCK:
        raise _refused(source, "no HDF5 file, or only its first bytes")
    (end,) = struct.unpack_from("<Q", source.content, start + (40 if source.content[start + 8] < 2 else 28))
    if end > len(source.content):
        raise _refused(source, f"{len(source.content)} bytes of an HDF5 file of {end}")


def _columns(listed: list[dict[str, Any]], numbers: Any) -> Iterator[ReadColumn]:
    start = 0
    for column in listed:
        name, unit, texts = column["name"].strip(), column["unit"] or None, column["texts"]
        signal = next((signal for signal in SIGNALS if column["is_signal"] and signal == name), None)
        if texts is None:
            yield ReadColumn(name, numbers[start : start + column["rows"]].astype(np.float64), unit, signal)
            start += column["rows"]
        else:
            yield replace(text_column(name, texts, unit), signal=signal)


def _check(source: SourceFile, columns: tuple[ReadColumn, ...]) -> None:
    lengths = {len(column.values) for column in columns}
    if len(lengths) != 1 or not lengths.pop():
        raise _refused(source, "no samples, or signals of several lengths")
    if len({column.name for column in columns} - {""}) < len(columns):
        raise _refused(source, "columns with duplicate or missing names")
    unknown = next((column for column in columns if column.unit is not None and not is_unit(column.unit)), None)
    if unknown is not None:
        raise _refused(source, f"the unit {unknown.unit!r} of {unknown.name!r}, which is unknown")


def _facts(key: str, said: Any) -> Iterator[tuple[str, str]]:
    """Give what a manifest states by dotted keys; a quantity with its unit, as run.toml would hold it."""
    if isinstance(said, str) and key:
        yield key, said
    elif isinstance(said, Mapping) and {"value", "unit"} <= set(said):
        yield key, f"{said['value']!r} {said['unit']}".removesuffix(" 1")
    elif isinstance(said, Mapping):
        for name in said if key else _FACTS:
            yield from _facts(f"{key}.{name}" if key else name, said.get(name))
