"""What a reader is: one class for one file format, that parses and does nothing else.

Renaming, conversion to SI and everything that several formats have in common is done once, in
``tribopipe.readers.harmonize``. A package adds a format by an entry point in the group
``tribopipe.readers`` whose value is a class with the shape of ``Reader``.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, NamedTuple, Protocol, runtime_checkable

from numpy.typing import NDArray

from tribopipe.documents.signals import SignalName
from tribopipe.results.run import SourceFile

Holds = Literal["signals", "profile"]
"""What a format's files hold: what a tribometer recorded during a test, or heights measured afterwards."""
Axis = Literal["x", "y", "z"]
"""Of a profile or map: x along the scan, y across scans, z the height, upwards out of the specimen."""


@dataclass(frozen=True)
class Hints:
    """What the manifest states about a file; it wins over anything a reader would guess."""

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
    """As the file's header writes it, blanks around it stripped."""
    values: NDArray[Any]
    """float64 where every field is a number or empty (NaN), otherwise the texts."""
    unit: str | None = None
    """Unit by the file's own words or by the format's definition."""
    signal: SignalName | None = None
    """What the column means, where the format itself states it."""
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
    """What stands above the numbers, verbatim."""
    notes: tuple[str, ...] = field(default=())
    """What a person should know about how the file was read."""
    facts: Mapping[str, str] = field(default_factory=dict)
    """What the header states about the run, by the keys of run.toml and as run.toml would hold it:
    {"conditions.normal_load": "5 N", "started": "2022-05-12T12:21:58", "instrument": "UMT TriboLab"}."""
    line_of: Callable[[int], int] | None = field(default=None, repr=False, compare=False)
    """Gives the line on which a row stands, the first row being 0; none where the file has no lines."""


@dataclass(frozen=True)
class Match:
    """How sure a reader is that a file is of its format, 0 to 1, and why."""

    confidence: float
    why: str
    known_as: str | None = None
    """What a file is that the reader knows and that holds nothing to read: "a calibration file"."""


@runtime_checkable
class Reader(Protocol):
    """A file format."""

    name: str
    """As the manifest's key ``reader`` names it."""
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
