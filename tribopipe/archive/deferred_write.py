"""An archive for the steps of one run that follow one another: its file is written once, after the last of them."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import h5py

from tribopipe.archive import nexus
from tribopipe.archive.runfile import (
    copy_except,
    dropped_by,
    left_out_with,
    read_cleaned,
    read_fingerprints,
    write_step,
)
from tribopipe.archive.step_names import Step
from tribopipe.archive.store import Archive
from tribopipe.results.run import RawRun


class OneRun(Archive):
    """An archive that shows one run with steps that are not in its file yet, until ``store`` puts them there.

    It keeps the cleaned run it gave last, and gives it again while it is that of the file.
    """

    def __init__(self, archive: Archive, run_id: str) -> None:
        super().__init__(archive.folder)
        self.__dict__.update(vars(archive))
        self.run_id = run_id
        self._shown: h5py.File | None = None
        """The file with the steps to come, in memory alone."""
        self._to_come: list[Step] = []
        self._made_of: object = None
        self._cleaned: RawRun | None = None

    @contextmanager
    def open(self, run_id: str, parts: Sequence[str] | None = None) -> Iterator[h5py.File]:
        """Open a run's file for reading, as ``Archive.open`` does; that of the one run with the steps to come."""
        if self._shown is not None and run_id == self.run_id:
            yield self._shown
            return
        with super().open(run_id, parts) as file:
            yield file

    def put_step(self, run_id: str, step: Step) -> None:
        """Add a step or replace it, to be stored later; one of another run at once."""
        if run_id != self.run_id:
            super().put_step(run_id, step)
            return
        if self._shown is None:
            self._shown = self._copied()
        entry = self._shown["entry"]
        for name in left_out_with(dropped_by(step, entry)):
            if name in entry:
                del entry[name]
        write_step(entry, step)
        self._to_come.append(step)

    def store(self) -> None:
        """Write the following steps to the file of the run. Raises ``ArchiveError`` as ``Archive.put_step`` does."""
        steps, self._to_come = self._to_come, []
        shown, self._shown = self._shown, None
        if shown is not None:
            with shown:
                self.put_steps(self.run_id, steps, shown["entry"])

    def _copied(self) -> h5py.File:
        # Its name is that of the file, which errors name and source files are read from; nothing is written there.
        copy = h5py.File(self.path(self.run_id), "w", driver="core", backing_store=False, track_order=True)
        with super().open(self.run_id) as file:
            copy_except(file, copy, set())
        return copy

    def cleaned(self, run_id: str) -> RawRun:
        """Return a run with its preprocessed signals, which cannot be written into."""
        with self.open(run_id) as file:
            entry = file["entry"]
            made_of = run_id, nexus.text(entry, "archived/raw_sha256"), read_fingerprints(entry, "clean_up")
            if self._cleaned is None or made_of != self._made_of:
                self._cleaned, self._made_of = read_cleaned(file), made_of
                for values in self._cleaned.columns.values():
                    values.flags.writeable = False
            return self._cleaned
