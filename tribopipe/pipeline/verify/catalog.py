"""Whether the catalog states what the files state.

It is derived from them and made again wherever it does not fit, so that nothing is lost with it. But what it states
about a
file that has not changed since, by all that the file system shows, has to be what the file states now; and a file that
it knows should be there, also one that was put in by hand and is not in the history yet.
"""

import sqlite3
from collections.abc import Iterator, Set
from contextlib import closing
from pathlib import Path

from tribopipe.archive.catalog.database import FILE_NAME, in_memory, is_damage, read_only
from tribopipe.archive.catalog.notes import keep, noted, take_note
from tribopipe.archive.file_signature import Stamp, stamp_of, stamps
from tribopipe.pipeline.verify.look import Look

_SAID = (
    "SELECT sha256, error FROM files WHERE name = ?",
    "SELECT * FROM runs WHERE file = ?",
    "SELECT study, run, verdict FROM members WHERE file = ? ORDER BY study, run, verdict",
)
_LS = "`tribopipe ls` creates it again"


def look_into_catalogue(archive: Path, sound: Set[str], recorded: Set[str] = frozenset()) -> list[Look]:
    """Compare the catalog of an archive with one made from its sound files, which is kept nowhere.

    Of files that are ``recorded`` the history shows whether they should be there.
    """
    look = Look(FILE_NAME)
    if not (archive / FILE_NAME).is_file():
        look.note("catalogue", "found none; expected one", _LS)
        return [look]
    try:
        with closing(read_only(archive)) as kept, closing(in_memory()) as rebuilt:
            return [*_gone(archive, kept, recorded), *_different(archive, sound, kept, rebuilt)]
    except (sqlite3.DatabaseError, UnicodeDecodeError) as error:
        if not is_damage(error):
            look.error("catalogue", f"cannot be read ({error}); expected a readable file", "verify again")
            return [look]
        look.note("catalogue", f"found it damaged, or of another version ({error}); expected one of this version", _LS)
        return [look]


def _gone(archive: Path, kept: sqlite3.Connection, recorded: Set[str]) -> Iterator[Look]:
    for name in sorted(noted(kept).keys() - stamps(archive).keys() - recorded):
        look = Look(name)
        message = "found no such file, although the catalog lists it; expected it"
        look.warning("catalogue", message, "restore it from a copy; if it was removed on purpose, run `tribopipe ls`")
        yield look


def _different(archive: Path, sound: Set[str], kept: sqlite3.Connection, rebuilt: sqlite3.Connection) -> Iterator[Look]:
    """Find files that did not change, and of which the catalog states something else."""
    known = noted(kept)
    for name, stamp in sorted(stamps(archive).items()):
        if name not in sound or name not in known or not known[name].still_holds(stamp):
            continue
        note = take_note(archive, name, stamp, None)
        if note is None or not _looks(archive / name, stamp):
            continue
        keep(rebuilt, [note])
        if any(_said(kept, question, name) != _said(rebuilt, question, name) for question in _SAID):
            look = Look(name)
            message = "found content that differs from the catalog, without a recorded change; expected the same"
            look.warning("catalogue", message, f"restore it from a copy if it is damaged; else remove {FILE_NAME}")
            yield look


def _looks(path: Path, stamp: Stamp) -> bool:
    """Return whether a file looks as it did before it was read."""
    try:
        return stamp_of(path.stat()) == stamp
    except FileNotFoundError:
        return False


def _said(connection: sqlite3.Connection, question: str, name: str) -> list[tuple[float | str | None, ...]]:
    return [tuple(row) for row in connection.execute(question, (name,))]
