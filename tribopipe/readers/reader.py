"""The interface of readers, and the registry of installed readers. A reader is a class that parses one file format.

Renaming, conversion to SI and everything that several formats have in common is done once, in
``tribopipe.readers.harmonize``. A package adds a format by an entry point in the group ``tribopipe.readers`` whose
value is a class with the shape of ``Reader``; tribopipe's own readers are declared the same way. Nothing is imported
before a reader is asked for.
"""

import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from importlib.metadata import EntryPoint
from operator import attrgetter
from typing import Any, Literal, NamedTuple, Protocol, runtime_checkable

from numpy.typing import NDArray

from tribopipe.base.errors import ReaderError, did_you_mean
from tribopipe.base.plugins import Plugins
from tribopipe.documents.signals import SignalName
from tribopipe.results.run import SourceFile

Holds = Literal["signals", "profile"]
"""Content of the files of a format: signals recorded during a test, or heights measured after it."""
Axis = Literal["x", "y", "z"]
"""Axis of a profile or map: x along the scan, y across scans, z the height, outward from the specimen."""


@dataclass(frozen=True)
class Hints:
    """Entries of the manifest about a file; they take precedence over anything a reader finds itself."""

    encoding: str | None = None
    separator: str | None = None
    decimal: Literal[".", ","] | None = None
    sheet: str | None = None
    """Sheet of a workbook."""


class Placeholders(NamedTuple):
    """Fields of a column that state that there is no number, such as OVL or ---; they are missing samples."""

    fields: int
    """How many there are."""
    line: int
    """Number of the line of the first one."""
    text: str
    """The first one."""


@dataclass(frozen=True)
class ReadColumn:
    """One column as it stands in the file, before any conversion."""

    name: str
    """Name as written in the header of the file, without surrounding spaces."""
    values: NDArray[Any]
    """float64 where every field is a number or empty (NaN), otherwise the texts."""
    unit: str | None = None
    """Unit by the file's own words or by the format's definition."""
    signal: SignalName | None = None
    """Signal of the column, if defined by the format itself."""
    axis: Axis | None = None
    """Which coordinate of a profile it is; a file may hold several columns of heights, one for each pass."""
    first_bad: tuple[int, str] | None = None
    """Line number and text of the first field that is no number, where there is one."""
    placeholders: Placeholders | None = None
    """Fields that were taken as missing samples, though something stands there."""


@dataclass(frozen=True)
class ReadTable:
    """Everything one file holds."""

    columns: tuple[ReadColumn, ...]
    header: str = ""
    """Text above the data, verbatim."""
    notes: tuple[str, ...] = field(default=())
    """Notes to the user about how the file was read."""
    facts: Mapping[str, str] = field(default_factory=dict)
    """Facts in the header about the run, by key of run.toml and as written in run.toml:
    {"conditions.normal_load": "5 N", "started": "2022-05-12T12:21:58", "instrument": "UMT TriboLab"}."""
    line_of: Callable[[int], int] | None = field(default=None, repr=False, compare=False)
    """Gives the line on which a row stands, the first row being 0; none where the file has no lines."""
    decimal: Literal[".", ","] | None = field(default=None, compare=False)
    """Decimal separator of the numbers in a text."""


@dataclass(frozen=True)
class Match:
    """How sure a reader is that a file is of its format, 0 to 1, and why."""

    confidence: float
    why: str
    known_as: str | None = None
    """Description of a known file without data to read, such as "a calibration file"."""


def refused(source: SourceFile, error: ReaderError) -> Match:
    """Report that a file is not of a format, for the reason why it cannot be read."""
    return Match(0.0, str(error).removeprefix(source.name).lstrip(":, "))


@runtime_checkable
class Reader(Protocol):
    """A file format."""

    name: str
    """Name for the key ``reader`` of the manifest."""
    title: str
    """One line for people."""
    holds: Holds
    """Signals of a test, or a profile."""

    def match(self, source: SourceFile) -> Match:
        """Judge by the content whether the file is of this format; never raises."""
        ...

    def read(self, source: SourceFile, hints: Hints) -> ReadTable:
        """Parse the file; ``ReaderError`` with file and line where it is broken."""
        ...


GROUP = "tribopipe.readers"
_CONFIDENT = 0.5
_PLAIN = "delimited"
"""Reader that takes what is a table at all, so that it knows best what is missing in a file."""
_KNOWN = (
    "; expected a format listed by `tribopipe formats list`; specify the reader, describe the format in a reader "
    "description, or export the file as a plain table"
)
_HOLD: dict[Holds, str] = {"signals": "signals of a test", "profile": "a profile"}
_MEND: dict[Holds, str] = {
    "signals": "specify it under [[signals]] in run.toml",
    "profile": "specify it as a profile under [end_values] in run.toml",
}


def readers() -> dict[str, Reader]:
    """Give all readers by name. One that cannot be loaded is left out, with a warning."""
    return dict(_loaded())


def reader_named(name: str) -> Reader:
    """Give the reader a manifest names; ``ReaderError`` names the nearest where there is none."""
    known = _loaded()
    found = dict(known).get(name)
    if found is None:
        raise ReaderError(
            f"found the unknown reader {name!r}; expected the name of an installed reader; "
            f"{did_you_mean(name, dict(known))}"
        )
    return found


class Judged(NamedTuple):
    """A reader and what it makes of a file."""

    reader: Reader
    match: Match


def candidates(source: SourceFile, holds: Holds | None = None) -> list[Judged]:
    """Give the readers, or those for what a file should hold, each with its match; the surest first."""
    asked = [reader for _, reader in _loaded() if holds is None or reader.holds == holds]
    return sorted((Judged(reader, _match(reader, source)) for reader in asked), key=lambda one: -one.match.confidence)


def is_sure(match: Match) -> bool:
    """Return whether a reader claims a file."""
    return match.confidence >= _CONFIDENT


def detect(source: SourceFile, holds: Holds | None = None) -> Reader:
    """Find the reader for a file by its content, among those for what it should hold.

    Raises ``ReaderError`` where no reader is confident, saying why, or where two are equally so.
    """
    found = candidates(source)
    right = [one for one in found if holds is None or one.reader.holds == holds]
    best = next(iter(found), None)
    if holds and best and best.reader.holds != holds and is_sure(best.match) and not any(is_sure(m) for _, m in right):
        raise ReaderError(
            f"{source.name}: found a file in the format {best.reader.title}, which contains "
            f"{_HOLD[best.reader.holds]}; expected a file with {_HOLD[holds]}; {_MEND[best.reader.holds]}"
        )
    return chosen(source, right)[0].reader


def chosen(source: SourceFile, found: Sequence[Judged]) -> list[Judged]:
    """Give those that claim a file, the surest first.

    Raises ``ReaderError`` where there is none, where two are equally sure, or where the file is known to hold nothing.
    """
    known_as = next((match.known_as for _, match in found if match.known_as), None)
    if known_as is not None:
        raise ReaderError(
            f"{source.name}: found {known_as}; expected a tribometer recording or a profile; omit this file"
        )
    sure = [one for one in found if is_sure(one.match)]
    if not sure:
        why = next((match.why for reader, match in found if reader.name == _PLAIN), "no reader recognizes it")
        remedy = "" if "; " in why else _KNOWN
        raise ReaderError(f"{source.name}: found no known format; read as a plain table: {why}{remedy}")
    best = [reader.name for reader, match in sure if match.confidence == sure[0].match.confidence]
    if len(best) > 1:
        raise ReaderError(
            f"{source.name}: found a file that the readers {' and '.join(best)} recognize with equal confidence; "
            f'expected exactly one matching reader; specify reader = "{best[0]}" in run.toml, or --reader {best[0]}'
        )
    return sure


@cache
def _loaded() -> tuple[tuple[str, Reader], ...]:
    return tuple(Plugins(GROUP, "reader", _made, attrgetter("name")).items())


def _made(entry: EntryPoint) -> Reader:
    reader = entry.load()()
    if not isinstance(reader, Reader):
        raise TypeError("has no name, title, holds, match or read")
    return reader


def _match(reader: Reader, source: SourceFile) -> Match:
    try:
        return reader.match(source)
    except Exception as error:  # noqa: BLE001 - somebody else's code may raise anything
        warnings.warn(f"reader {reader.name!r} failed on {source.name}: {error!r}", stacklevel=3)
        return Match(0.0, f"failed ({error!r})")
