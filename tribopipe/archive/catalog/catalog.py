"""The catalog of an archive: what a list states about every run, found again without reading the runs.

It notes of each file how it looked, and what a run or a study states in it.
"""

import hashlib
import sqlite3
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import islice
from pathlib import Path
from threading import RLock
from typing import NamedTuple

from tribopipe.archive.catalog.database import NOTED, Database, sum_of, transaction
from tribopipe.archive.catalog.listing import COLUMNS, Cell, ListedRun, in_order
from tribopipe.archive.catalog.query import parse_where, where_clause
from tribopipe.archive.file_signature import STUDIES, Stamp, stamps
from tribopipe.archive.remote import RemotePath, stamps_of
from tribopipe.base.errors import NotInstalledError, TribopipeError


class Known(NamedTuple):
    """State of a file when it was last read."""

    stamp: str
    settled: bool
    """Whether no later change could have left the stamp as it is."""
    sha256: str

    def still_holds(self, stamp: Stamp) -> bool:
        """Return whether the file is certainly the same."""
        return self.settled and self.stamp == str(stamp)


class Note(NamedTuple):
    """Content of a new or changed file, as far as the catalog keeps it."""

    name: str
    known: Known
    same: bool = False
    """Whether the content of the file is unchanged."""
    error: str | None = None
    """Reason why the file cannot be read, without its path."""
    cells: Mapping[str, Cell] | None = None
    """Cells of a run by column."""
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
        why = f"cannot be read ({error.strerror or error}); expected a readable file; check its permissions"
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
    from tribopipe.archive.catalog.reading import read_agreement, read_cells
    from tribopipe.archive.store import Archive
    from tribopipe.base.errors import ArchiveError
    from tribopipe.base.failures import number_of, unreadable

    path, store = archive / name, Archive(archive)
    try:
        if name.startswith(f"{STUDIES}/"):
            return Note(name, known, members=read_agreement(store, path.stem))
        return Note(name, known, cells=read_cells(store, path.stem))
    except (AttributeError, LookupError, TypeError) as error:
        if number := number_of(error):
            raise ArchiveError(f"{path}: {unreadable(number)}") from error
        raise ArchiveError(
            f"{path}: found a damaged file ({type(error).__name__}: {error}); expected an unmodified tribopipe file; "
            "restore it from a backup"
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
    lines = ((note.name, study, run, agreement) for run, agreement in note.members)
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


Advance = Callable[[str], None]
_BATCH = 100
"""Files read before what they state is written, so that little is lost where somebody interrupts."""


class Catalogue:
    """The runs of an archive folder as a list gives them; any thread may ask.

    What it states is what was there at the last refresh.
    """

    def __init__(self, archive: Path) -> None:
        self.folder = archive
        self._database = Database(archive)
        self._lock = RLock()

    @property
    def revision(self) -> str:
        """A text that is another one whenever a file of the archive is; nothing but the folder is looked at."""
        seen = "\n".join(f"{name} {stamp}" for name, stamp in sorted(_stamps(self.folder).items()))
        return hashlib.sha256(seen.encode("utf-8", "surrogateescape")).hexdigest()[:16]

    def waiting(self) -> list[str]:
        """Return the files that the next refresh has to look into, or to forget."""
        with self._lock:
            return self._database.do(lambda connection: _changed(connection, _stamps(self.folder)))

    def refresh(self, advance: Advance | None = None) -> None:
        """Bring the catalog up to date; ``advance`` is given the name of each file that was looked into."""
        with self._lock:
            self._database.do(lambda connection: self._refresh(connection, advance))

    @property
    def unreadable(self) -> list[tuple[str, str]]:
        """Files that cannot be read, each with one sentence that states why and what to do."""
        rows = self._asked("SELECT name, error FROM files WHERE error IS NOT NULL ORDER BY name")
        return [(name, f"{self.folder / name}: {error}") for name, error in rows]

    @property
    def count(self) -> int:
        """Number of runs that can be read."""
        return int(self._asked("SELECT count(*) FROM listed")[0][0])

    def runs(self, where: str = "", sort: str = "id") -> list[ListedRun]:
        """Return the runs that match a query, sorted by columns such as "material,-k_d".

        Raises ``QueryError`` where query or order cannot be understood.
        """
        condition, values = where_clause(parse_where(where))
        rows = self._asked(f"SELECT * FROM listed WHERE {condition}", values)  # noqa: S608, of names of columns alone
        places = {name: place for place, name in enumerate(rows[0].keys())} if rows else {}
        return in_order((ListedRun(row, places) for row in rows), sort)

    def _asked(self, question: str, values: Sequence[float | str] = ()) -> list[sqlite3.Row]:
        with self._lock:
            return self._database.do(
                lambda connection: connection.execute(question, values).fetchall(), fill=self._refresh
            )

    def _refresh(self, connection: sqlite3.Connection, advance: Advance | None = None) -> None:
        seen = _stamps(self.folder)
        if gone := _gone(connection, seen):
            with transaction(connection):
                forget(connection, gone)
        waiting = iter(_to_look_into(connection, seen))
        while batch := list(islice(waiting, _BATCH)):
            self._look_into(connection, batch, advance)

    def _look_into(
        self, connection: sqlite3.Connection, batch: list[tuple[str, Stamp]], advance: Advance | None
    ) -> None:
        before, notes = noted(connection), []
        for name, stamp in batch:
            notes.append(take_note(self.folder, name, stamp, before.get(name)))
            if advance is not None:
                advance(name)
        with transaction(connection):
            keep(connection, [note for note in notes if note is not None])
            forget(connection, [name for (name, _), note in zip(batch, notes, strict=True) if note is None])


def _stamps(archive: Path) -> Mapping[str, Stamp]:
    return stamps_of(archive) if isinstance(archive, RemotePath) else stamps(archive)


def _changed(connection: sqlite3.Connection, seen: Mapping[str, Stamp]) -> list[str]:
    return [*(name for name, _ in _to_look_into(connection, seen)), *sorted(_gone(connection, seen))]


def _gone(connection: sqlite3.Connection, seen: Mapping[str, Stamp]) -> set[str]:
    return noted(connection).keys() - seen.keys()


def _to_look_into(connection: sqlite3.Connection, seen: Mapping[str, Stamp]) -> list[tuple[str, Stamp]]:
    known = noted(connection)
    return [
        (name, stamp) for name, stamp in sorted(seen.items()) if name not in known or not known[name].still_holds(stamp)
    ]
