"""The catalog of an archive: what a list states about every run, found again without reading the runs."""

import hashlib
import sqlite3
from collections.abc import Callable, Sequence
from itertools import islice
from pathlib import Path
from threading import RLock

from tribopipe.archive.catalog.database import Database, transaction
from tribopipe.archive.catalog.listed import ListedRun, in_order
from tribopipe.archive.catalog.notes import forget, keep, noted, take_note
from tribopipe.archive.catalog.query import parse_where, where_clause
from tribopipe.archive.file_signature import Stamp, stamps

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
        seen = "\n".join(f"{name} {stamp}" for name, stamp in sorted(stamps(self.folder).items()))
        return hashlib.sha256(seen.encode("utf-8", "surrogateescape")).hexdigest()[:16]

    def waiting(self) -> list[str]:
        """Return the files that the next refresh has to look into, or to forget."""
        with self._lock:
            return self._database.do(lambda connection: _changed(connection, stamps(self.folder)))

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
        seen = stamps(self.folder)
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


def _changed(connection: sqlite3.Connection, seen: dict[str, Stamp]) -> list[str]:
    return [*(name for name, _ in _to_look_into(connection, seen)), *sorted(_gone(connection, seen))]


def _gone(connection: sqlite3.Connection, seen: dict[str, Stamp]) -> set[str]:
    return noted(connection).keys() - seen.keys()


def _to_look_into(connection: sqlite3.Connection, seen: dict[str, Stamp]) -> list[tuple[str, Stamp]]:
    known = noted(connection)
    return [
        (name, stamp) for name, stamp in sorted(seen.items()) if name not in known or not known[name].still_holds(stamp)
    ]
