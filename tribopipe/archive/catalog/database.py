"""The SQLite file of the catalog: its tables, and how it restarts where it is lost, damaged or of another version.

It holds nothing that cannot be read from the archive again, so that nothing is lost with it.
"""

import marshal
import os
import sqlite3
import time
import zlib
from collections.abc import Callable, Iterable, Iterator
from contextlib import closing, contextmanager, suppress
from pathlib import Path
from typing import TypeVar

from tribopipe.archive.catalog.listing import COLUMNS, has_words, sort_key, steps_in_words
from tribopipe.archive.catalog.query import holds, matches
from tribopipe.archive.catalog.recent_checks import Check, CheckNote
from tribopipe.archive.file_signature import stamp_of
from tribopipe.archive.lock import SILENT, say_waiting
from tribopipe.version import VERSION

T = TypeVar("T")
Work = Callable[[sqlite3.Connection], T]
FILE_NAME = "catalogue.sqlite"
_EDITION = 6
"""Goes up when the same run is noted in another way."""
_WAIT = 20.0
"""How long another process may write, s."""
_PAUSE = 60.0
"""How long a file that the system refuses is left alone, s: each attempt may read runs in vain."""
_OF_STUDIES = ("studies", "agreement")
"""Columns that come from the studies, not from the run."""
NOTED = tuple(name for name in COLUMNS if name not in _OF_STUDIES)
"""Columns that come from the run."""
_TYPES = {"number": 'REAL, "{0}_uncertainty" REAL, "{0}_shown" TEXT', "text": "TEXT", "date": "TEXT"}
_CELLS = ", ".join(f'"{name}" {_TYPES[COLUMNS[name].kind].format(name)}' for name in NOTED)
_WIDE = ("title", "comment", "steps", "missing", "run_toml", "marked_bad", "notes")
"""Columns of long texts."""
_NARROW = ", ".join(f'"{name}"' for name in NOTED if name not in _WIDE)
"""Columns that most queries ask about: an index that holds them is read instead of the whole table."""
_SCHEMA = f"""
CREATE TABLE files (name TEXT PRIMARY KEY, stamp TEXT, settled INTEGER, sha256 TEXT, error TEXT, sum INTEGER);
CREATE TABLE runs (file TEXT PRIMARY KEY REFERENCES files ON DELETE CASCADE, {_CELLS}, id_key BLOB, sum INTEGER);
CREATE TABLE members (file TEXT REFERENCES files ON DELETE CASCADE, study TEXT, run TEXT, agreement TEXT, sum INTEGER);
CREATE INDEX files_unreadable ON files (name) WHERE error IS NOT NULL;
CREATE INDEX runs_in_order ON runs (id_key);
CREATE INDEX runs_narrow ON runs ({_NARROW}, id_key);
CREATE INDEX members_file ON members (file);
CREATE INDEX members_run ON members (run);
CREATE VIEW listed AS SELECT runs.rowid AS place, runs.*,
    (SELECT group_concat(study, char(10)) FROM
        (SELECT DISTINCT study FROM members WHERE run = id ORDER BY study)) AS studies,
    (SELECT group_concat(agreement, char(10)) FROM
        (SELECT agreement FROM members WHERE run = id ORDER BY study, agreement)) AS agreement
    FROM runs;
"""  # noqa: S608, of names of columns alone
_STATEMENTS = [statement.strip() for statement in _SCHEMA.split(";") if statement.strip()]
_SUMMED = ("SELECT name, sha256, error, sum FROM files", "SELECT * FROM runs", "SELECT * FROM members")
"""Rows that end in a sum of what stands before it, which SQLite itself does not keep."""
_THIS = zlib.crc32(f"{_SCHEMA}{_EDITION}{VERSION}".encode()) & 0x7FFFFFFF
_REFUSED = OSError, sqlite3.DatabaseError, UnicodeDecodeError
_SEEN_AT_ONCE = {sqlite3.SQLITE_BUSY, sqlite3.SQLITE_CANTOPEN}
"""Another process writes, or there is no folder yet: no run is read in vain."""
_DAMAGED = {sqlite3.SQLITE_CORRUPT, sqlite3.SQLITE_NOTADB, sqlite3.SQLITE_ERROR, sqlite3.SQLITE_CONSTRAINT}


class Database:
    """The database of one archive: a file in it, or in memory as long as that cannot be written."""

    def __init__(self, archive: Path) -> None:
        self._path = archive / FILE_NAME
        self._checked = CheckNote(archive, "catalogue")
        self._connection: sqlite3.Connection | None = None
        self._memory: sqlite3.Connection | None = None
        self._patience = SILENT
        self._again = 0.0
        """When the file is tried again, on the clock that only goes forward, s."""

    def __del__(self) -> None:
        """Close the database with the last that uses it, which Python from 3.13 on asks of everyone."""
        for connection in (self._connection, self._memory):
            if connection is not None:
                connection.close()

    def do(self, work: Work[T], fill: Work[None] | None = None) -> T:
        """Do some work; where the file is damaged do it on a new one, and where it cannot be used in memory.

        One that went on in memory looks each time whether the file can be used again. ``fill`` brings what was begun
        again up to date, for work that counts on that.
        """

        def filled_first(connection: sqlite3.Connection) -> T:
            if fill is not None:
                fill(connection)
            return work(connection)

        first = work
        if self._memory is not None:
            if not self._is_given_again():
                return work(self._memory)
            first = filled_first  # the file does not know what happened meanwhile
        for ready, task in ((self._kept, first), (self._anew, filled_first)):
            try:
                return self._done_after_others(ready, task)
            except _REFUSED as error:
                self._leave_alone(error)
                if isinstance(error, OSError) or not is_damage(error):
                    break
        return filled_first(self._in_memory())

    def _done_after_others(self, ready: Callable[[], sqlite3.Connection], task: Work[T]) -> T:
        """Do some work once no other process writes; people are informed of a longer wait."""
        try:
            return task(ready())
        except sqlite3.OperationalError as error:
            if not _is_busy(error):
                raise
        say_waiting(self._path.parent, FILE_NAME, _WAIT)
        self._close()  # it may not have its tables yet
        self._be_patient(_WAIT)
        try:
            return task(ready())
        finally:
            self._be_patient(SILENT)

    def _be_patient(self, seconds: float) -> None:
        """Set how long others are waited for."""
        self._patience = seconds
        if self._connection is not None:
            self._connection.execute(f"PRAGMA busy_timeout = {round(1e3 * seconds)}")

    def _leave_alone(self, error: Exception) -> None:
        """Set when the file is tried again: at once where that has no cost, else after a pause."""
        self._again = time.monotonic() + (0.0 if _code(error) in _SEEN_AT_ONCE else _PAUSE)

    def _is_given_again(self) -> bool:
        """Return whether the file can be written again, without waiting: whoever looks may look often."""
        if time.monotonic() < self._again:
            return False
        self._be_patient(0.0)
        try:
            with transaction(self._kept()):
                self._be_patient(SILENT)
        except _REFUSED as error:
            self._leave_alone(error)
            self._close()
            self._be_patient(SILENT)
            return False
        if self._memory is not None:
            self._memory.close()
            self._memory = None
        return True

    def _kept(self) -> sqlite3.Connection:
        """Return the connection there is, or open the file as it was kept."""
        if self._connection is None:
            state, start = self._state(), time.perf_counter()
            self._connection = _connected(os.fspath(self._path), self._patience)
            _make_tables(self._connection)
            self._check(self._connection, state, start)
        elif not _is_this_version(self._connection):
            raise sqlite3.DatabaseError("written by another version meanwhile")
        return self._connection

    def _check(self, connection: sqlite3.Connection, state: str, start: float) -> None:
        """Check the file, unless that was done lately and it has not changed since."""
        if self._checked.valid_for(state) is None:
            _refuse_damaged(connection)
            if self._state() == state:
                self._checked.keep(Check(state, time.time(), time.perf_counter() - start))

    def _state(self) -> str:
        """Return the stamp of the file; empty where there is none."""
        try:
            return str(stamp_of(self._path.stat()))
        except OSError:
            return ""

    @contextmanager
    def writing(self, connection: sqlite3.Connection) -> Iterator[None]:
        """Write all or nothing; a file that need not be checked again need not be after that either."""
        with transaction(connection):
            check = self._checked.valid_for(self._state()) if connection is self._connection else None
            yield
        if check is not None:
            self._checked.keep(check._replace(state=self._state()))

    def _anew(self) -> sqlite3.Connection:
        """Begin a new file. Raises ``OSError`` where the old one cannot be removed."""
        self._close()
        self._path.unlink(missing_ok=True)
        return self._kept()

    def _close(self) -> None:
        if self._connection is not None:
            self._connection.close()
            self._connection = None

    def _in_memory(self) -> sqlite3.Connection:
        """Go on in memory with what the file holds, as far as it can be read."""
        memory, kept = _connected(":memory:", 0.0), self._connection
        if kept is not None:
            with suppress(sqlite3.DatabaseError), closing(kept):
                kept.rollback()
                kept.execute("PRAGMA busy_timeout = 0")  # who still writes has been waited for
                kept.execute("BEGIN")
                kept.execute("SELECT name FROM files").fetchone()  # fails where backup would wait for ever
                kept.backup(memory)
        _make_tables(memory)
        _refuse_damaged(memory)
        self._connection, self._memory = None, memory
        return memory


def read_only(archive: Path) -> sqlite3.Connection:
    """Open the catalog of an archive as it was kept; nothing is changed, whatever is wrong with it.

    Raises ``DatabaseError`` where it cannot be read, is damaged, or of another version.
    """
    connection = _connected(f"{Path(os.fspath(archive / FILE_NAME)).absolute().as_uri()}?mode=ro", _WAIT, uri=True)
    try:
        if not _is_this_version(connection):
            raise sqlite3.DatabaseError("written by another version")
        _refuse_damaged(connection)
    except BaseException:
        connection.close()
        raise
    return connection


def in_memory() -> sqlite3.Connection:
    """Return an empty catalog that is kept nowhere."""
    connection = _connected(":memory:", 0.0)
    _make_tables(connection)
    return connection


def _is_busy(error: Exception) -> bool:
    """Return whether another process was writing."""
    return _code(error) == sqlite3.SQLITE_BUSY


def _code(error: Exception) -> int:
    return int(getattr(error, "sqlite_errorcode", 0)) & 0xFF


def is_damage(error: Exception) -> bool:
    """Return whether it is the file that is wrong, rather than the system that does not read it."""
    return getattr(error, "sqlite_errorcode", sqlite3.SQLITE_CORRUPT) & 0xFF in _DAMAGED


def _connected(name: str, patience: float, *, uri: bool = False) -> sqlite3.Connection:
    connection = sqlite3.connect(name, timeout=patience, isolation_level=None, check_same_thread=False, uri=uri)
    connection.row_factory = sqlite3.Row
    connection.create_function("matches", 2, matches, deterministic=True)
    connection.create_function("holds", 2, holds, deterministic=True)
    connection.create_function("steps_in_words", 1, steps_in_words, deterministic=True)
    connection.create_function("has_words", -1, has_words, deterministic=True)
    connection.create_function("sort_key", 2, sort_key, deterministic=True)
    connection.execute("PRAGMA foreign_keys = ON")
    return connection


def _make_tables(connection: sqlite3.Connection) -> None:
    """Give an empty database its tables. Raises ``DatabaseError`` where it is damaged, or of another version."""
    if not _is_this_version(connection):
        with transaction(connection):
            if not _is_this_version(connection):  # nor has another process made them meanwhile
                for statement in _STATEMENTS:
                    connection.execute(statement)
                connection.execute(f"PRAGMA user_version = {_THIS}")


def _refuse_damaged(connection: sqlite3.Connection) -> None:
    if connection.execute("PRAGMA integrity_check(1)").fetchone()[0] != "ok" or not _adds_up(connection):
        raise sqlite3.DatabaseError("damaged")


def _adds_up(connection: sqlite3.Connection) -> bool:
    """Return whether tables and rows are as they were written."""
    tables = {sql for (sql,) in connection.execute("SELECT sql FROM sqlite_master WHERE sql IS NOT NULL")}
    if tables != set(_STATEMENTS):
        return False
    return all(are_intact(connection.execute(question)) for question in _SUMMED)


def are_intact(rows: Iterable[Iterable[float | str | bytes | None]]) -> bool:
    """Return whether rows are as they were written, by the sums that they end in."""
    return all(row[-1] == sum_of(row[:-1]) for row in map(tuple, rows))


def sum_of(values: tuple[float | str | bytes | None, ...]) -> int:
    """Return the sum that is kept with a row."""
    return zlib.crc32(marshal.dumps(values, 2))


def _is_this_version(connection: sqlite3.Connection) -> bool:
    return bool(connection.execute("PRAGMA user_version").fetchone()[0] == _THIS)


@contextmanager
def transaction(connection: sqlite3.Connection) -> Iterator[None]:
    """Write all or nothing."""
    connection.execute("BEGIN IMMEDIATE")
    try:
        yield
        connection.execute("COMMIT")
    except BaseException:
        if connection.in_transaction:
            connection.execute("ROLLBACK")
        raise


@contextmanager
def snapshot(connection: sqlite3.Connection) -> Iterator[None]:
    """Read what was there at one moment in several questions."""
    connection.execute("BEGIN")
    try:
        yield
    finally:
        if connection.in_transaction:
            connection.execute("ROLLBACK")
