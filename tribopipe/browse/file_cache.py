"""Files of the archive as they stood when they were asked for: what was read of them is kept until they change."""

from collections import OrderedDict
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from pathlib import Path
from threading import Lock
from typing import Any, TypeVar

import h5py
import numpy as np

from tribopipe.archive.file_access import opened
from tribopipe.archive.file_signature import SUFFIX, stamp_of
from tribopipe.archive.hdf5_compression import unpacked
from tribopipe.archive.hdf5_guard import own_datasets
from tribopipe.archive.outline import RunOutline
from tribopipe.archive.step_names import StepName
from tribopipe.archive.store import Archive
from tribopipe.archive.studyfile import StoredStudy
from tribopipe.base.arrays import Column
from tribopipe.base.errors import ArchiveError
from tribopipe.documents.record import Record
from tribopipe.documents.signals import SignalName

R = TypeVar("R", bound=Record)
T = TypeVar("T")
ROOM = 512 << 20
"""Bytes that are kept in memory."""
_LARGEST = 1 << 30
"""Bytes of a column that is read at all: 130 million samples."""
_SMALL = 1 << 16
"""Bytes that anything but an array is taken to fill."""


class Kept:
    """What was read of files lately, bounded in bytes. Threads that want the same wait for the first of them."""

    def __init__(self, room: int = ROOM) -> None:
        self._room = room
        self._used = 0
        self._found: OrderedDict[tuple[object, ...], Future[Any]] = OrderedDict()
        self._lock = Lock()

    def get(self, key: tuple[object, ...], read: Callable[[], T]) -> T:
        """Return the result of ``read`` for a key, from the cache if possible."""
        with self._lock:
            there = self._found.get(key)
            if there is None:
                mine: Future[Any] = Future()
                self._found[key] = mine
            else:
                self._found.move_to_end(key)
        if there is not None:
            found: T = there.result()
            return found
        try:
            value = read()
        except BaseException as error:
            with self._lock:
                self._found.pop(key, None)
            mine.set_exception(error)
            raise
        mine.set_result(value)
        self._make_room(_bytes(value))
        return value

    def _make_room(self, more: int) -> None:
        """Count what was added, and forget what was not asked for longest."""
        with self._lock:
            self._used += more
            for key, oldest in list(self._found.items())[:-1]:
                if self._used <= self._room:
                    break
                if oldest.done():
                    self._used -= _bytes(oldest.result())
                    del self._found[key]


def _bytes(value: object) -> int:
    if isinstance(value, bytes):
        return len(value)
    return value.nbytes if isinstance(value, np.ndarray) else _SMALL


class ArchivedFile:
    """One file of the archive. Raises ``OSError`` where there is none."""

    def __init__(self, path: Path, kept: Kept) -> None:
        self.path, self.stamp, self._kept = path, stamp_of(path.stat()), kept

    def keep(self, what: str, read: Callable[[], T]) -> T:
        """Return something made of this file, made now or earlier."""
        return self._kept.get((self.path, self.stamp, what), read)

    def refuse_foreign(self) -> None:
        """Raise ``ArchiveError`` where any of it lies outside the file; who reads it by other ways asks this first."""
        _ = self.datasets

    @property
    def datasets(self) -> Mapping[str, tuple[int, ...]]:
        """Shapes of all datasets by their paths. Raises ``ArchiveError`` where any of it lies outside the file."""

        def read() -> Mapping[str, tuple[int, ...]]:
            with opened(self.path) as file:
                return own_datasets(file)

        return self.keep("datasets", read)


class StudyFile(ArchivedFile):
    """One study of the archive."""

    def __init__(self, archive: Archive, study_id: str, kept: Kept) -> None:
        super().__init__(archive.study_folder / f"{study_id}{SUFFIX}", kept)
        self.archive, self.id = archive, study_id

    @property
    def stored(self) -> StoredStudy:
        """The study with its curves."""
        self.refuse_foreign()
        return self.keep("study", lambda: self.archive.study(self.id))


class RunFile(ArchivedFile):
    """One run of the archive."""

    def __init__(self, archive: Archive, run_id: str, kept: Kept) -> None:
        super().__init__(archive.path(run_id), kept)
        self.archive, self.id = archive, run_id

    @property
    def outline(self) -> RunOutline:
        """All that is known of the run but its columns and curves."""
        self.refuse_foreign()
        return self.keep("outline", lambda: self.archive.outline(self.id))

    def result(self, name: StepName, record: type[R]) -> R | None:
        """Return what a step found; none where the run has not been through it, or it is of another tribometer."""
        step = self.outline.steps.get(name)
        return step.result if step is not None and isinstance(step.result, record) else None

    def signal_path(self, name: SignalName) -> str | None:
        """Return the path of a preprocessed signal, else of the recorded one; none if the run has no such signal."""
        paths = (f"/entry/clean_up/data/{name}", f"/entry/raw/{name}")
        return next((path for path in paths if path in self.datasets), None)

    def signal(self, name: SignalName) -> Column | None:
        """Return a signal, SI; none where it was not recorded."""
        path = self.signal_path(name)
        return None if path is None else self.sampled(path)

    def curve(self, path: str) -> Column | None:
        """Return a value at each sample, or none where the run has no such."""
        return self.sampled(path) if path in self.datasets else None

    def sampled(self, path: str) -> Column:
        """Return one value per sample. Raises ``ArchiveError`` if the number of values differs from that of samples."""
        values, samples = self.column(path), self.outline.samples
        if len(values) != samples:
            raise ArchiveError(
                f"{self.path}: found {len(values):,} values in {path}; expected {samples:,}, one per sample; restore "
                "the file from a backup"
            )
        return values

    def column(self, path: str) -> Column:
        """Return a column in the unit it is stored in. Raises ``ArchiveError`` where it is too large to be read."""
        return self.keep(path, lambda: self._read(path))

    def _read(self, path: str) -> Column:
        with self.archive.open(self.id) as file:
            if stamp_of(self.path.stat()) != self.stamp:
                raise ArchiveError(
                    f"{self.path}: found that the file was replaced during reading; expected an unchanged file; "
                    "reload the page"
                )
            dataset: h5py.Dataset = file[path]
            if dataset.ndim != 1 or dataset.size * 8 > _LARGEST:
                raise ArchiveError(
                    f"{self.path}: found {dataset.size:,} values in {path}; expected at most "
                    f"{_LARGEST // 8:,} in a single column; open the file with another viewer"
                )
            return np.asarray(unpacked(dataset), dtype=np.float64)
