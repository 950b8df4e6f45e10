"""The catalog of an archive: what a list states about every run, found again without reading the runs.

It notes of each file how it looked, and what a run or a study states in it.
"""

import hashlib
import json
import sqlite3
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from threading import RLock
from typing import NamedTuple, TypeVar

from tribopipe.archive.catalog.database import NOTED, Database, Work, are_intact, snapshot, sum_of
from tribopipe.archive.catalog.listing import COLUMNS, Cell, ListedRun, column_named, sort_key, texts_in
from tribopipe.archive.catalog.query import Asked, Selection, selection
from tribopipe.archive.catalog.recent_checks import Check, CheckNote
from tribopipe.archive.file_signature import STUDIES, Stamp, folders_stamp, stamps
from tribopipe.archive.remote import RemotePath, stamps_of
from tribopipe.base.errors import NotInstalledError, TribopipeError
from tribopipe.base.files import natural_key

T = TypeVar("T")


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


def _noted_of(connection: sqlite3.Connection, name: str) -> Known | None:
    row = connection.execute("SELECT stamp, settled, sha256 FROM files WHERE name = ?", [name]).fetchone()
    return None if row is None else Known(row["stamp"], bool(row["settled"]), row["sha256"])


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
    values: list[float | str | bytes | None] = [file]
    for name in NOTED:
        cell = cells.get(name, Cell())
        if COLUMNS[name].kind == "number":
            # SQLite keeps no minus zero, so that the sum of one would not be that of what is read.
            values += [None if cell.value is None else float(cell.value) + 0.0, cell.standard_uncertainty, cell.shown]
        else:
            values.append(cell.value)
    values.append(sort_key("id", str(cells.get("id", Cell()).value or "")))
    places = ", ".join("?" * (len(values) + 1))
    connection.execute(f"INSERT INTO runs VALUES ({places})", [*values, sum_of(tuple(values))])  # noqa: S608


Advance = Callable[[str], None]
_BATCH = 100
"""Files read before what they state is written, so that little is lost where somebody interrupts."""


@dataclass(frozen=True)
class Changes:
    """Files that are not as the catalog has them."""

    new: Sequence[tuple[str, Stamp]] = ()
    """Files to be read or compared, with their stamps."""
    gone: Sequence[str] = ()

    def __len__(self) -> int:
        return len(self.new) + len(self.gone)


class Listed(NamedTuple):
    """Some of the runs that match a query."""

    total: int
    """How many match."""
    runs: list[ListedRun]


class Catalogue:
    """The runs of an archive folder as a list gives them; any thread may ask.

    What it states is what was there at the last refresh.
    """

    def __init__(self, archive: Path) -> None:
        self.folder = archive
        self._database = Database(archive)
        self._looked = CheckNote(archive, "files")
        self._revised: tuple[Check, str] | None = None
        self._lock = RLock()

    @property
    def revision(self) -> str:
        """A text that is another one whenever a file of the archive is; nothing but the folder is looked at."""
        with self._lock:
            state, at, start = self._folders(), time.time(), time.perf_counter()
            if self._revised is not None and self._revised[0].is_valid_for(state):
                return self._revised[1]
            stamps_now = _stamps(self.folder)
            seen = "\n".join(f"{name} {stamp}" for name, stamp in sorted(stamps_now.items()))
            revision = hashlib.sha256(seen.encode("utf-8", "surrogateescape")).hexdigest()[:16]
            settled = bool(state) and all(stamp.settled(int(at * 1e9)) for stamp in stamps_now.values())
            self._revised = (Check(state, at, time.perf_counter() - start), revision) if settled else None
            return revision

    def changes(self) -> Changes:
        """Return the files that the next refresh has to look into, or to forget.

        A folder whose files were looked at lately, and took long, is taken as it was unless it has changed since.
        """
        with self._lock:
            return self._database.do(self._changes)

    def waiting(self) -> list[str]:
        """Return the names of the files that the next refresh has to look into, or to forget."""
        changes = self.changes()
        return [*(name for name, _ in changes.new), *changes.gone]

    def refresh(self, advance: Advance | None = None, changes: Changes | None = None) -> None:
        """Bring the catalog up to date.

        Parameters
        ----------
        advance
            Is given the name of each file that was looked into.
        changes
            What ``changes`` has just returned, so that the files are not looked at once more.
        """
        with self._lock:
            self._database.do(lambda connection: self._refresh(connection, advance, changes))

    @property
    def unreadable(self) -> list[tuple[str, str]]:
        """Files that cannot be read, each with one sentence that states why and what to do."""
        rows = self._asked(lambda connection: connection.execute(_UNREADABLE).fetchall())
        return [(name, f"{self.folder / name}: {error}") for name, error in rows]

    @property
    def count(self) -> int:
        """Number of runs that can be read."""
        return self.listed(Asked(), most=0).total

    def runs(self, where: str = "", sort: str = "id") -> list[ListedRun]:
        """Return the runs that match a query, sorted by columns such as "material,-k_d".

        Raises ``QueryError`` where query or order cannot be understood.
        """
        return self.listed(Asked(where, sort)).runs

    def listed(self, asked: Asked, start: int = 0, most: int | None = None) -> Listed:
        """Return some of the runs that match a query, and how many match.

        Raises ``QueryError`` where the query cannot be understood.

        Parameters
        ----------
        asked
            Which runs, and in what order.
        start
            How many runs are left out at the beginning.
        most
            How many are returned at most; all without it.
        """
        query = selection(asked)
        return self._asked(lambda connection: _listed(connection, query, start, most))

    def values(self, name: str, begins: str = "", most: int = 50) -> list[str]:
        """Return texts, or days, that runs have in a column and that begin with something, in any case.

        Raises ``QueryError`` where there is no such column.
        """
        column = column_named(name)
        if column.kind == "number":
            return []
        question = f'SELECT DISTINCT "{column.name}" FROM listed'  # noqa: S608, of a name of a column
        rows = self._asked(lambda connection: connection.execute(question).fetchall())
        known = {text for (held,) in rows for text in texts_in(column, held)}
        return sorted((text for text in known if text.lower().startswith(begins.lower())), key=natural_key)[:most]

    def _asked(self, work: Work[T]) -> T:
        with self._lock:
            return self._database.do(work, fill=self._refresh)

    def _folders(self) -> str:
        """Return the stamp of the folders; empty where a further change would not show in it."""
        return "" if isinstance(self.folder, RemotePath) else folders_stamp(self.folder) or ""

    def _changes(self, connection: sqlite3.Connection) -> Changes:
        folders, at, start = self._folders(), time.time(), time.perf_counter()
        if folders and self._looked.valid_for(folders) is not None:
            return Changes()
        changes = _compared(connection, _stamps(self.folder))
        if folders and not changes:
            self._looked.keep(Check(folders, at, time.perf_counter() - start))
        return changes

    def _refresh(
        self, connection: sqlite3.Connection, advance: Advance | None = None, changes: Changes | None = None
    ) -> None:
        changes = changes or self._changes(connection)
        if changes.gone:
            with self._database.writing(connection):
                forget(connection, changes.gone)
        waiting = iter(changes.new)
        while batch := list(islice(waiting, _BATCH)):
            self._look_into(connection, batch, advance)

    def _look_into(
        self, connection: sqlite3.Connection, batch: list[tuple[str, Stamp]], advance: Advance | None
    ) -> None:
        notes = []
        for name, stamp in batch:
            notes.append(take_note(self.folder, name, stamp, _noted_of(connection, name)))
            if advance is not None:
                advance(name)
        with self._database.writing(connection):
            keep(connection, [note for note in notes if note is not None])
            forget(connection, [name for (name, _), note in zip(batch, notes, strict=True) if note is None])


_UNREADABLE = "SELECT name, error FROM files WHERE error IS NOT NULL ORDER BY name"
_CHOSEN = """SELECT listed.* FROM json_each(?) AS wanted CROSS JOIN listed ON listed.place = wanted.value
ORDER BY wanted.key"""
_THEIR_STUDIES = "SELECT members.* FROM json_each(?) AS wanted CROSS JOIN members ON members.run = wanted.value"


def _listed(connection: sqlite3.Connection, query: Selection, start: int, most: int | None) -> Listed:
    window = [*query.values, -1 if most is None else most, start]
    with snapshot(connection):
        chosen = [place for (place,) in connection.execute(query.places, window)]
        total = len(chosen) if most is None else connection.execute(query.total, query.values).fetchone()[0]
        rows = connection.execute(_CHOSEN, [json.dumps(chosen)]).fetchall()
        their_studies = connection.execute(_THEIR_STUDIES, [json.dumps([row["id"] for row in rows])]).fetchall()
    columns = {name: number for number, name in enumerate(rows[0].keys())} if rows else {}
    noted_cells = (tuple(row)[columns["file"] : columns["sum"] + 1] for row in rows)
    if not are_intact(noted_cells) or not are_intact(their_studies):
        raise sqlite3.DatabaseError("damaged")
    return Listed(total, [ListedRun(row, columns) for row in rows])


def _stamps(archive: Path) -> Mapping[str, Stamp]:
    return stamps_of(archive) if isinstance(archive, RemotePath) else stamps(archive)


def _compared(connection: sqlite3.Connection, seen: Mapping[str, Stamp]) -> Changes:
    known = dict(connection.execute("SELECT name, CASE WHEN settled THEN stamp END FROM files"))
    new = [(name, stamp) for name, stamp in sorted(seen.items()) if known.get(name) != str(stamp)]
    return Changes(new, sorted(known.keys() - seen.keys()))
