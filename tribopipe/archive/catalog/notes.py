"""What the catalog keeps of each file: how it looked, and what a run or a study states in it."""

import hashlib
import sqlite3
import time
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import NamedTuple

from tribopipe.archive.catalog.columns import COLUMNS, Cell
from tribopipe.archive.catalog.database import NOTED, sum_of
from tribopipe.archive.file_signature import STUDIES, Stamp
from tribopipe.base.errors import NotInstalledError, TribopipeError


class Known(NamedTuple):
    """How a file looked when it was last read."""

    stamp: str
    settled: bool
    """Whether no later change could have left the stamp as it is."""
    sha256: str

    def still_holds(self, stamp: Stamp) -> bool:
        """Return whether the file is certainly the same."""
        return self.settled and self.stamp == str(stamp)


class Note(NamedTuple):
    """What was found in a file that looked as it had not before."""

    name: str
    known: Known
    same: bool = False
    """Whether its content is what it was."""
    error: str | None = None
    """Why it cannot be read, without its path."""
    cells: Mapping[str, Cell] | None = None
    """What a run has in each column."""
    members: Iterable[tuple[str, str | None]] = ()
    """The runs of a study, and what it states about them."""


def noted(connection: sqlite3.Connection) -> dict[str, Known]:
    """Return how every file looked, by its path in the archive."""
    rows = connection.execute("SELECT name, stamp, settled, sha256 FROM files")
    return {name: Known(stamp, bool(settled), sha256) for name, stamp, settled, sha256 in rows}


def take_note(archive: Path, name: str, stamp: Stamp, before: Known | None) -> Note | None:
    """Look into a file; none where it has been removed meanwhile."""
    settled = stamp.settled(time.time_ns())
    path = archive / name
    try:
        with path.open("rb") as file:  # before it is read: if it changes in between, the next look sees that
            known = Known(str(stamp), settled, hashlib.file_digest(file, "sha256").hexdigest())
    except FileNotFoundError:
        return None
    except OSError as error:
        why = f"cannot be read ({error.strerror or error}); expected a file of the archive; check its permissions"
        return Note(name, Known(str(stamp), settled=False, sha256=""), error=why)
    if before is not None and before.sha256 == known.sha256:
        return Note(name, known, same=True)
    try:
        return _read(archive, name, known)
    except NotInstalledError as error:  # looked at anew each time, since the package may be installed by then
        why = str(error).removeprefix(f"{path}: ")
        return Note(name, Known(str(stamp), settled=False, sha256=""), error=why)
    except TribopipeError as error:
        return Note(name, known, error=str(error).removeprefix(f"{path}: ")) if path.exists() else None


def _read(archive: Path, name: str, known: Known) -> Note:
    from tribopipe.archive.catalog.reading import read_cells, read_verdicts
    from tribopipe.archive.store import Archive
    from tribopipe.base.errors import ArchiveError
    from tribopipe.base.failures import number_of, unreadable

    path, store = archive / name, Archive(archive)
    try:
        if name.startswith(f"{STUDIES}/"):
            return Note(name, known, members=read_verdicts(store, path.stem))
        return Note(name, known, cells=read_cells(store, path.stem))
    except (AttributeError, LookupError, TypeError) as error:
        if number := number_of(error):
            raise ArchiveError(f"{path}: {unreadable(number)}") from error
        raise ArchiveError(
            f"{path}: found a damaged file ({type(error).__name__}: {error}); expected what tribopipe wrote; restore "
            "it from a copy"
        ) from error


def keep(connection: sqlite3.Connection, notes: Iterable[Note]) -> None:
    """Write notes in the place of earlier ones."""
    for note in notes:
        if note.same:
            told = (note.known.stamp, note.known.settled, note.name)
            connection.execute("UPDATE files SET stamp = ?, settled = ? WHERE name = ?", told)
            continue
        forget(connection, [note.name])
        told_sum = sum_of((note.name, note.known.sha256, note.error))
        row = (note.name, *note.known, note.error, told_sum)
        connection.execute("INSERT INTO files VALUES (?, ?, ?, ?, ?, ?)", row)
        _keep_members(connection, note)
        if note.cells is not None:
            _keep_cells(connection, note.name, note.cells)


def forget(connection: sqlite3.Connection, names: Iterable[str]) -> None:
    """Drop all that is noted of some files."""
    connection.executemany("DELETE FROM files WHERE name = ?", ((name,) for name in names))


def _keep_members(connection: sqlite3.Connection, note: Note) -> None:
    study = Path(note.name).stem
    lines = ((note.name, study, run, verdict) for run, verdict in note.members)
    connection.executemany("INSERT INTO members VALUES (?, ?, ?, ?, ?)", ((*line, sum_of(line)) for line in lines))


def _keep_cells(connection: sqlite3.Connection, file: str, cells: Mapping[str, Cell]) -> None:
    values: list[float | str | None] = [file]
    for name in NOTED:
        cell = cells.get(name, Cell())
        if COLUMNS[name].kind == "number":
            values += [None if cell.value is None else float(cell.value), cell.standard_uncertainty, cell.shown]
        else:
            values.append(cell.value)
    places = ", ".join("?" * (len(values) + 1))
    connection.execute(f"INSERT INTO runs VALUES ({places})", [*values, sum_of(tuple(values))])  # noqa: S608
