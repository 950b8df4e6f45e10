"""What an instrument has appended to the files of a run since the last look, as samples in SI.

Of one file of delimited text only new, whole lines are read: a last line that is half written waits. Any other format,
and several files of one test, are read again as a whole where they have changed.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from tribopipe.base.arrays import Column
from tribopipe.base.errors import ReaderError
from tribopipe.documents.manifest import RunManifest
from tribopipe.documents.signals import SignalName
from tribopipe.extras.live.axes import Axes
from tribopipe.extras.live.growing_text import GrowingText
from tribopipe.readers.column_mapping import Arms
from tribopipe.readers.columns import with_file
from tribopipe.readers.harmonize import read_run
from tribopipe.results.run import Origin

_MOST_WHOLE = 64 << 20
"""Bytes of files that are read again as a whole at each look."""


@dataclass(frozen=True)
class Appended:
    """Samples that have come, in the order of the test."""

    columns: Mapping[SignalName, Column]
    """In SI, time and sliding distance among them."""
    origins: Mapping[SignalName, Origin]
    anew: bool = False
    """Whether the files were replaced or cut, so that these are the first samples again."""


class Follower:
    """What reads the files of a run again and again."""

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
                f"{names[0]}: found {size / 2**20:.0f} MB that have to be read again as a whole at each look; expected "
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
