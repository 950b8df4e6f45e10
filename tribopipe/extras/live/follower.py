"""Samples that an instrument has appended to the files of a run since the last update, in SI units.

Of one file of delimited text only new, whole lines are read, by the code that reads a whole file: a last line that is
half written waits. Any other format, and several files of one test, are read again as a whole where they have changed.
Time and sliding distance come out as if all samples had come at once.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.base.errors import ReaderError
from tribopipe.documents.manifest import RunManifest, SignalFile
from tribopipe.documents.signals import AXES, SignalName
from tribopipe.evaluation.derived_columns import derive_missing
from tribopipe.readers.clock_times import with_clock_times
from tribopipe.readers.column_mapping import Arms, Meanings, hints_of, meanings_in, part_of, with_file
from tribopipe.readers.delimited import has_rows, read_table, without_closing_words
from tribopipe.readers.harmonize import read_run
from tribopipe.readers.layout import Layout, find_layout
from tribopipe.readers.reader import detect
from tribopipe.readers.text import LONGEST_LINE, SAMPLE_BYTES, Text, decode
from tribopipe.results.run import Origin, SourceFile

_NEEDED: tuple[SignalName, ...] = (*AXES, "sliding_speed")


class Axes:
    """Current ends of the axes of a run."""

    def __init__(self, manifest: RunManifest) -> None:
        self._manifest = manifest
        self._recorded: dict[SignalName, Column] = {}
        """The last sample, as recorded."""
        self._reached: dict[SignalName, float] = {}
        """The axes there, derived ones among them."""

    def completed(self, columns: dict[SignalName, Column]) -> tuple[dict[SignalName, Column], dict[SignalName, Origin]]:
        """Return samples with the axes that were not recorded, and the origins of all; those not placed are left out.

        Raises ``ReaderError`` where an axis restarts, or nothing shows the sliding distance of the pin.
        """
        placed = np.logical_and.reduce([np.isfinite(columns[name]) for name in _NEEDED if name in columns])
        joined = {
            name: np.concatenate([self._recorded.get(name, []), values[placed]]) for name, values in columns.items()
        }
        self._refuse_restarts(joined)
        origins: dict[SignalName, Origin] = dict.fromkeys(joined, "measured")
        self._recorded = {name: values[-1:] for name, values in joined.items()}
        if len(next(iter(joined.values()))):
            derive_missing(joined, origins, self._manifest)
            self._refuse_unknown(origins)
        first = len(self._reached) > 0
        for name in AXES:
            if name in joined and name not in columns and first:
                joined[name] = joined[name] + (self._reached[name] - joined[name][0])
        self._reached = {name: float(joined[name][-1]) for name in AXES if name in joined and len(joined[name])}
        return {name: values[int(first) :] for name, values in joined.items()}, origins

    def _refuse_restarts(self, columns: dict[SignalName, Column]) -> None:
        for name in AXES:
            if name in columns and np.any(np.diff(columns[name]) < 0):
                raise ReaderError(
                    f"{self._manifest.id}: found a {name.replace('_', ' ')} that decreases; expected a single "
                    "continuous test; process the run after it has ended: the parts are then joined into one test"
                )

    def _refuse_unknown(self, origins: dict[SignalName, Origin]) -> None:
        if origins["sliding_distance"] == "unknown":
            raise ReaderError(
                f"{self._manifest.id}: found neither distance nor speed of the pin; expected a sliding distance, "
                'or a speed; add one to run.toml, such as conditions.sliding_speed = "400 mm/s"'
            )


_PIECE = 8 << 20
"""Bytes that are read at a time."""
_KNOWN_BY = 4096
"""Bytes at the beginning, and before where reading goes on, by which a file is known again."""
_FORMAT = "delimited"
_FEWEST_ROWS = 20
"""Number of rows from which the layout of a file is detected."""


class GrowingText:
    """The lines of a file so far, and the beginning of the next one."""

    def __init__(self, signals: SignalFile, arms: Arms) -> None:
        self._signals, self._name, self._arms = signals, signals.names[0], arms
        self.is_foreign = False
        """True if it is not a text file that can be read while it grows."""
        self._begin()

    def _begin(self) -> None:
        self._read = self._rows = self._lines = 0
        self._head = self._tail = self._waiting = b""
        self._layout: Layout | None = None
        self._meanings: Meanings = {}

    def begins_anew(self, path: Path) -> bool:
        """Return whether a file is another one than was read so far, or was cut; it is then read from its beginning."""
        with path.open("rb") as file:
            known = file.read(len(self._head)) == self._head
            file.seek(self._read - len(self._tail))
            known = known and file.read(len(self._tail)) == self._tail
        if not known:
            self._begin()
        return not known

    def appended(self, path: Path) -> Iterator[dict[SignalName, Column]]:
        """Give the signals of the lines that have come, in SI. Raises ``ReaderError`` where they are broken."""
        with path.open("rb") as file:
            file.seek(self._read)
            while (piece := file.read(_PIECE)) and not self.is_foreign:
                self._note(piece)
                yield from self._taken(piece)

    def _note(self, piece: bytes) -> None:
        self._read += len(piece)
        self._head += piece[: _KNOWN_BY - len(self._head)]
        self._tail = (self._tail + piece)[-_KNOWN_BY:]

    def _taken(self, piece: bytes) -> Iterator[dict[SignalName, Column]]:
        """Yield the signals of complete lines; incomplete lines, or lines before a known header, are kept for later."""
        self._waiting += piece
        whole = self._waiting[: self._waiting.rfind(b"\n") + 1]
        layout = self._layout or self._understood(whole)
        if layout is None or not whole:
            self.is_foreign = self.is_foreign or len(self._waiting) > len(whole) + LONGEST_LINE
            return
        text = decode(self._source(whole), self._signals.encoding)
        head = layout.header.encode()
        body = text.content[text.start + (len(head) if self._layout is None else 0) :]
        self._layout, self._waiting = layout, self._waiting[len(whole) :]
        rows = Text(self._name, head + body)
        if has_rows(rows, layout):
            yield self._signals_of(rows, replace(layout, line=layout.line + self._lines))
        self._lines += body.count(b"\n")

    def _signals_of(self, rows: Text, layout: Layout) -> dict[SignalName, Column]:
        table = read_table(without_closing_words(rows, layout)[0], layout)
        self._meanings = self._meanings or meanings_in(table, self._signals, self._name)
        columns = part_of(table, self._meanings, self._name, self._rows, self._arms).columns
        self._rows += len(next(iter(columns.values())))
        return columns

    def _understood(self, content: bytes) -> Layout | None:
        """Find the layout once there are enough rows for it; none before, and none of any other format."""
        try:
            text = decode(self._source(content), self._signals.encoding)
            layout = find_layout(text, hints_of(self._signals))
        except ReaderError:
            self.is_foreign = self._is_another(content) or len(content) > SAMPLE_BYTES
            return None
        if text.content.count(b"\n", text.start + len(layout.header.encode())) < _FEWEST_ROWS:
            return None
        self.is_foreign = b"\0" in content[:_KNOWN_BY] or self._is_another(content) or _has_times_of_day(text, layout)
        return None if self.is_foreign else layout

    def _is_another(self, content: bytes) -> bool:
        if self._signals.reader is not None or self._signals.separator is not None:
            return False
        try:
            return detect(self._source(content), holds="signals").name != _FORMAT
        except ReaderError:
            return False

    def _source(self, content: bytes) -> SourceFile:
        return SourceFile(self._name, content)


def _has_times_of_day(text: Text, layout: Layout) -> bool:
    """Return whether a file has times of day, which count from its first row: it is read as a whole."""
    table = read_table(without_closing_words(text, layout)[0], layout)
    return len(with_clock_times(table).notes) > len(table.notes)


_MOST_WHOLE = 64 << 20
"""Bytes of files that are read again as a whole at each look."""


@dataclass(frozen=True)
class Appended:
    """Samples that have come, in the order of the test."""

    columns: Mapping[SignalName, Column]
    """Columns in SI units, including time and sliding distance."""
    origins: Mapping[SignalName, Origin]
    anew: bool = False
    """True if the files were replaced or truncated, so that the samples start again."""


class Follower:
    """Reader of growing files of a run."""

    def __init__(self, manifest: RunManifest, folder: Path) -> None:
        self._manifest, self._folder = manifest, folder
        self._axes = Axes(manifest)
        signals = manifest.signals[0]
        one = len(manifest.signals) == 1 and len(signals.names) == 1 and signals.reader in (None, "delimited")
        self._text = GrowingText(signals, Arms.of(manifest)) if one else None
        self._seen: object = None
        self._broken: object = None
        """How long and how old files were that could be read, and that could not."""
        self._rows = 0

    def look(self) -> Iterator[Appended]:
        """Give what has come since the last look.

        Raises ``ReaderError`` where files cannot be understood, or a clock restarts.
        """
        if self._text is not None:
            name = self._manifest.signals[0].names[0]
            yield from self._of_text(with_file(self._folder, name, Path), self._text)
        if self._text is None:
            yield from self._as_a_whole()

    def _of_text(self, path: Path, text: GrowingText) -> Iterator[Appended]:
        anew = text.begins_anew(path)
        if anew:
            self._axes = Axes(self._manifest)
        for columns in text.appended(path):
            yield Appended(*self._axes.completed(columns), anew)
            anew = False
        if text.is_foreign:
            self._text = None

    def _as_a_whole(self) -> Iterator[Appended]:
        names = [name for signals in self._manifest.signals for name in signals.names]
        seen = [with_file(self._folder, name, lambda path: path.stat()) for name in names]
        state = [(one.st_size, one.st_mtime_ns) for one in seen]
        if state == self._seen:
            return
        size = sum(one.st_size for one in seen)
        if size > _MOST_WHOLE:
            raise ReaderError(
                f"{names[0]}: found {size / 2**20:.0f} MB that must be reread at each update; expected "
                f"one file of delimited text, or at most {_MOST_WHOLE >> 20} MB; process the run when it has ended"
            )
        try:
            run = read_run(self._folder)
        except ReaderError:
            if state == self._broken:  # else it may be half-way through a line
                raise
            self._broken = state
            return
        self._seen, before = state, self._rows
        anew = len(run) < before
        self._rows = len(run)
        since = slice(0 if anew else before, None)
        yield Appended({name: values[since] for name, values in run.columns.items()}, run.origins, anew)
