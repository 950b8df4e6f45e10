"""What a reader is: one class for one file format, that parses and does nothing else.

Renaming, conversion to SI and everything that several formats have in common is done once, in
``tribopipe.ingest.harmonise``. A package adds a format by an entry point in the group
``tribopipe.readers`` whose value is a class with the shape of ``Reader``.
"""

from dataclasses import dataclass, field
from typing import Any, Literal, Protocol, runtime_checkable

from numpy.typing import NDArray

from tribopipe.records.signals import SignalName
from tribopipe.run import SourceFile


@dataclass(frozen=True)
class Hints:
    """What the manifest says about a file; it wins over anything a reader would guess."""

    encoding: str | None = None
    separator: str | None = None
    decimal: Literal[".", ","] | None = None


@dataclass(frozen=True)
class ReadColumn:
    """One column as it stands in the file, before any conversion."""

    name: str
    """As the file's header writes it, blanks around it stripped."""
    values: NDArray[Any]
    """float64 where every field is a number or empty (NaN), otherwise the texts."""
    unit: str | None = None
    """Unit by the file's own words or by the format's definition."""
    signal: SignalName | None = None
    """What the column means, where the format itself says so."""
    first_bad: tuple[int, str] | None = None
    """Line number and text of the first field that is no number, where there is one."""


@dataclass(frozen=True)
class ReadTable:
    """Everything one file holds."""

    columns: tuple[ReadColumn, ...]
    header: str = ""
    """What stands above the numbers, verbatim."""
    notes: tuple[str, ...] = field(default=())
    """What a person should know about how the file was read."""


@dataclass(frozen=True)
class Match:
    """How sure a reader is that a file is of its format, 0 to 1, and why."""

    confidence: float
    why: str


@runtime_checkable
class Reader(Protocol):
    """A file format."""

    name: str
    """As the manifest's key ``reader`` names it."""
    title: str
    """One line for people."""

    def match(self, source: SourceFile) -> Match:
        """Judge by the content whether the file is of this format; never raises."""
        ...

    def read(self, source: SourceFile, hints: Hints) -> ReadTable:
        """Parse the file; ``ReaderError`` with file and line where it is broken."""
        ...
