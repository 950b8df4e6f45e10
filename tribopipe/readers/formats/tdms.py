"""National Instruments TDMS (.tdms): what LabVIEW, DIAdem and FlexLogger save.

Binary; a chain of segments, each with a lead-in of 28 bytes:

    TDSm | contents, 4 bytes | version, 4 | length of the rest of the segment, 8 | length of its metadata, 8
    metadata: objects "/", "/'group'", "/'group'/'channel'" with their properties
    raw data of the channels, one channel after the other or interleaved

* The number of contents is little-endian; bit 6 of it states whether everything else is big-endian.
* A length of 2⁶⁴ − 1 marks a segment that was never finished, since the program stopped before. Such a segment, and
  one that is longer than the file, is read as far as all channels go, with a note. A file cut exactly between two
  segments cannot be distinguished from a shorter one.
* Channels of one group are columns; they must have one length. Groups of the same channels are segments of one test,
  in the order of the file. Scaling that the file describes (DAQmx) is applied.
* Units stand in the property unit_string or NI_UnitDescription, or in the channel's name.
* Time is a channel (of time stamps, which are given as seconds since the first one; or one called time), or it
  follows from wf_increment and wf_start_offset, in s unless wf_xunit_string states otherwise.
* wf_start_time is the start in UTC; of the file's properties, author, title and description are of use.

What a channel measures is not in the file. Reading takes the package npTDMS: pip install "tribopipe[tdms]".
"""

import logging
import math
import re
import struct
from collections.abc import Iterator
from importlib import import_module
from io import BytesIO
from typing import Any, NamedTuple

import numpy as np

from tribopipe.base.errors import ReaderError
from tribopipe.base.optional_packages import required
from tribopipe.base.units import is_unit
from tribopipe.documents.signals import SignalName
from tribopipe.readers.number_fields import text_column
from tribopipe.readers.reader import Hints, Holds, Match, ReadColumn, ReadTable
from tribopipe.readers.table_parts import is_time, join_parts, seconds_since_first
from tribopipe.readers.tables import split_name
from tribopipe.results.run import SourceFile

_MAGIC = b"TDSm"
_LEAD_IN = 28
_BIG_ENDIAN = 1 << 6
_UNFINISHED = (1 << 64) - 1
_UNIT_KEYS = ("unit_string", "NI_UnitDescription", "unit", "units", "Unit", "Units")
_NI_UNITS = {
    "Volts": "V",
    "Amps": "A",
    "Ohms": "ohm",
    "Seconds": "s",
    "Meters": "m",
    "Inches": "inch",
    "Newtons": "N",
    "Pounds": "lbf",
    "Pascals": "Pa",
    "Newton Meters": "N*m",
    "Deg C": "degC",
    "Deg F": "degF",
    "Kelvins": "K",
    "RPM": "rpm",
}
"""Units as National Instruments' drivers spell them out."""
_TIMES = ("s", "ms", "us", "ns", "min", "h")
_CLASS = re.compile(r"<class '(?:\w+\.)*(\w+)'>")
_EARLIEST = np.datetime64("1990-01-01")
"""Before this, a start is LabVIEW's zero of 1904 or an unset clock."""


class TdmsReader:
    """Files of LabVIEW, DIAdem and FlexLogger."""

    name = "ni-tdms"
    title = "National Instruments TDMS (.tdms)"
    holds: Holds = "signals"
    suffixes = (".tdms",)

    def match(self, source: SourceFile) -> Match:
        """Judge by the first four bytes."""
        if source.content.startswith(_MAGIC):
            return Match(0.98, "the file starts with TDSm, the signature of a TDMS segment")
        return Match(0.0, "the file does not start with TDSm")

    def read(self, source: SourceFile, hints: Hints) -> ReadTable:  # noqa: ARG002 - nothing of a binary file is open
        """Parse the file; ``ReaderError`` where it is damaged, or where npTDMS is not installed."""
        chain = _follow(source)
        library = _library(source)
        try:
            with library.TdmsFile.open(BytesIO(source.content)) as file:
                tables, properties = _tables(source, chain, file), dict(file.properties)
        except ReaderError:
            raise
        except Exception as error:  # noqa: BLE001 - npTDMS raises whatever a damaged file makes it stumble on
            said = _CLASS.sub(r"\1", str(error))
            raise _damaged(source, f"npTDMS cannot read it ({type(error).__name__}: {said})") from None
        joined = join_parts(source.name, "group", tables)
        facts = dict(_facts(properties)) | dict(joined.facts)
        notes = joined.notes if chain.note is None else (chain.note, *joined.notes)
        return ReadTable(joined.columns, _listed("/", properties) + joined.header, notes, facts)


def _library(source: SourceFile) -> Any:
    problem = f"{source.name}: found a TDMS file, but npTDMS is not installed"
    library = required("nptdms", "tdms", "reading TDMS files", problem=problem, error=ReaderError)
    import_module("nptdms.log").log_manager.set_level(logging.ERROR)  # what it would warn of, the notes say
    return library


class _Chain(NamedTuple):
    """Result of following the lead-ins of a file."""

    data: int
    """Bytes of raw data that the segments state they hold."""
    note: str | None = None
    """Note on what is missing at the end of the file."""


def _follow(source: SourceFile) -> _Chain:
    """Go from segment to segment; ``ReaderError`` where the chain is broken."""
    position, size, data = 0, len(source.content), 0
    while position + _LEAD_IN <= size:
        magic, contents = struct.unpack_from("<4sI", source.content, position)
        if magic != _MAGIC:
            raise _damaged(source, f"found no segment at byte {position}, where one should start")
        order = ">" if contents & _BIG_ENDIAN else "<"
        length, metadata = struct.unpack_from(f"{order}QQ", source.content, position + 12)
        if length == _UNFINISHED:
            return _Chain(
                data, "the recording program stopped before the file was complete; only complete rows are read"
            )
        position += _LEAD_IN + length
        data += length - metadata
    lacking = position - size if position >= size else position + _LEAD_IN - size
    note = f"at least {lacking} bytes are missing at the end of the file; only complete rows are read"
    return _Chain(data, note if lacking else None)


def _refuse_misfit(source: SourceFile, chain: _Chain, channels: list[Any]) -> None:
    """Refuse a file whose samples are more or fewer than its segments hold; for numbers of fixed size alone."""
    sizes = [getattr(channel.data_type, "size", None) for channel in channels]
    most = sum(len(channel) * (size or 1) for channel, size in zip(channels, sizes, strict=True))
    exact = chain.note is None and None not in sizes
    if most > len(source.content) or (exact and most != chain.data):
        raise _damaged(source, f"the channels contain {most} bytes in total, but the segments {chain.data}")


def _damaged(source: SourceFile, found: str) -> ReaderError:
    return ReaderError(
        f"{source.name}: found a damaged TDMS file: {found}; expected a chain of complete segments; copy it again from "
        "the instrument"
    )


def _tables(source: SourceFile, chain: _Chain, file: Any) -> dict[str, ReadTable]:
    """Read each group that holds samples, in the order in which they were written."""
    channels = [channel for group in file.groups() for channel in group.channels()]
    _refuse_misfit(source, chain, channels)
    # Groups may be listed in another order than their channels were written.
    channels.sort(key=lambda channel: source.content.find(channel.path.encode()))
    names = dict.fromkeys(channel.group_name for channel in channels)
    groups = {name: _Group(source, file[name], cut=chain.note is not None) for name in names}
    read = {name: group.table() for name, group in groups.items() if group.channels}
    tables = {name: table for name, table in read.items() if table.columns}
    if not tables:
        raise ReaderError(
            f"{source.name}: found no samples in any channel; expected at least one sample; record or copy the "
            "file again"
        )
    return tables


class _Group:
    """One group: its channels as columns."""

    def __init__(self, source: SourceFile, group: Any, *, cut: bool) -> None:
        self.source = source
        self.group = group
        self.channels = [channel for channel in group.channels() if len(channel)]
        # A channel that a cut file has nothing of would have had samples, too.
        counted = [channel for channel in group.channels() if len(channel) or (cut and channel.data_type)]
        self.rows = min(map(len, counted), default=0)
        if not cut:
            self._refuse_lengths()
        if cut and not self.rows:
            self.channels = []

    def _refuse_lengths(self) -> None:
        other = next((channel for channel in self.channels if len(channel) != self.rows), None)
        if other is not None:
            first = next(channel for channel in self.channels if len(channel) == self.rows)
            raise ReaderError(
                f"{self.source.name}: found {len(first)} samples of {first.name!r} and {len(other)} of {other.name!r} "
                f"in the group {self.group.name!r}; expected channels of equal length; export channels with the "
                "same sampling rate to a separate file"
            )

    def table(self) -> ReadTable:
        """Read the channels, and the time that follows from their waveform properties."""
        notes: list[str] = []
        columns = [column for channel in self.channels if (column := self._column(channel, notes))]
        if not any(map(is_time, columns)):
            columns[:0] = self._waveform_times()
        if len({column.name for column in columns} - {""}) < len(columns):
            raise _damaged(self.source, f"channels of the group {self.group.name!r} have duplicate or missing names")
        header = "".join(_listed(part.path, part.properties) for part in (self.group, *self.channels))
        return ReadTable(tuple(columns), header, tuple(notes), dict(self._started()))

    def _column(self, channel: Any, notes: list[str]) -> ReadColumn | None:
        values = np.asarray(channel[:])[: self.rows]
        name = _plain(channel.name)
        if values.dtype.kind in "fiub":
            return ReadColumn(name, values.astype(np.float64), _unit(channel, notes))
        if values.dtype.kind == "M":
            notes.append(f"channel {name!r} contains dates; they are converted to seconds since {_iso(values[0])} UTC")
            return ReadColumn(name, seconds_since_first(values), "s", "time")
        if values.dtype.kind in "OU":
            return text_column(name, [_plain(value) for value in values], _unit(channel, notes))
        notes.append(f"channel {name!r} contains neither numbers nor text and is omitted")
        return None

    def _waveform_times(self) -> Iterator[ReadColumn]:
        """Give the time that wf_increment and wf_start_offset state; ``ReaderError`` where channels disagree."""
        tracks = {_track(channel): channel.name for channel in self.channels if "wf_increment" in channel.properties}
        if len(tracks) > 1:
            raise ReaderError(
                f"{self.source.name}: found different sampling intervals in the channels "
                f"{' and '.join(map(repr, list(tracks.values())[:2]))}; expected one sampling rate per group; export "
                "channels with the same sampling rate to a separate file"
            )
        for increment, offset, name, unit in tracks:
            if math.isfinite(increment) and math.isfinite(offset) and increment > 0 and is_unit(unit):
                signal: SignalName | None = "time" if unit in _TIMES else None
                yield ReadColumn(name, offset + increment * np.arange(self.rows), unit, signal)

    def _started(self) -> Iterator[tuple[str, str]]:
        starts = [channel.properties.get("wf_start_time") for channel in self.channels]
        known = {start for start in starts if isinstance(start, np.datetime64) and start > _EARLIEST}
        if len(known) == 1:
            yield "started", f"{_iso(known.pop())}+00:00"


def _track(channel: Any) -> tuple[float, float, str, str]:
    """Give increment, start, name and unit of what a waveform runs along."""
    said = channel.properties
    name, unit = _plain(said.get("wf_xname")) or "Time", _plain(said.get("wf_xunit_string")) or "s"
    return float(said["wf_increment"]), float(said.get("wf_start_offset", 0)), name, _NI_UNITS.get(unit, unit)


def _unit(channel: Any, notes: list[str]) -> str | None:
    """Give the unit of a channel by its properties, or by its name; note one that is unknown."""
    written = next((said for key in _UNIT_KEYS if (said := _plain(channel.properties.get(key)))), "")
    if not written:
        return split_name(_plain(channel.name))[1]
    unit = _NI_UNITS.get(written, written)
    if is_unit(unit):
        return unit
    notes.append(f"channel {_plain(channel.name)!r} has the unknown unit {written!r}; specify its unit in run.toml")
    return None


def _plain(said: Any) -> str:
    """Write a name or value without the zero bytes that pad it, and blanks around it; "" for none."""
    return "" if said is None else str(said).replace("\0", "").strip()


def _iso(stamp: np.datetime64) -> str:
    return str(np.datetime_as_string(stamp, unit="s"))


def _facts(properties: dict[str, Any]) -> Iterator[tuple[str, str]]:
    for key, name in (("operator", "author"), ("title", "title"), ("comment", "description")):
        said = _plain(properties.get(name))
        if said:
            yield key, said


def _listed(path: str, properties: dict[str, Any]) -> str:
    """Write the properties of an object as lines: a TDMS file has no text of its own above the numbers."""
    return "".join(f"{path} {key} = {value}\n" for key, value in properties.items()).replace("\0", "")
