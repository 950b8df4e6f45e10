"""What lies in an archive's folder next to its runs and studies: the catalog and other files.

The catalog is derived from the files and made again wherever it does not fit, so that nothing is lost with it. But
what it states about a file that has not changed since, by all that the file system shows, has to be what the file
states now; and a file that it knows should be there, also one that was put in by hand and is not in the history yet.
"""

import sqlite3
from collections import defaultdict
from collections.abc import Iterator, Set
from contextlib import closing, suppress
from pathlib import Path

from tribopipe.archive.catalog.catalog import keep, noted, take_note
from tribopipe.archive.catalog.database import FILE_NAME, in_memory, is_damage, read_only
from tribopipe.archive.file_signature import FIGURES, STUDIES, SUFFIX, Stamp, stamp_of, stamps
from tribopipe.archive.history import FILE_NAME as HISTORY
from tribopipe.archive.lock import writers_lock
from tribopipe.archive.removal import REMOVED
from tribopipe.base.errors import ArchiveError
from tribopipe.base.files import is_old, leftovers
from tribopipe.pipeline.last_pass import FILE_NAME as LAST_PASS
from tribopipe.pipeline.verify.file_findings import Look

_SAID = (
    "SELECT sha256, error FROM files WHERE name = ?",
    "SELECT * FROM runs WHERE file = ?",
    "SELECT study, run, agreement FROM members WHERE file = ? ORDER BY study, run, agreement",
)
_LS = "`tribopipe ls` creates it again"


def look_into_catalogue(archive: Path, sound: Set[str], recorded: Set[str] = frozenset()) -> list[Look]:
    """Compare the catalog of an archive with one made from its sound files, which is kept nowhere.

    Of files that are ``recorded`` the history shows whether they should be there.
    """
    look = Look(FILE_NAME)
    if not (archive / FILE_NAME).is_file():
        look.note("catalog", f"found no catalog; expected the file {FILE_NAME}", _LS)
        return [look]
    try:
        with closing(read_only(archive)) as kept, closing(in_memory()) as rebuilt:
            return [*_gone(archive, kept, recorded), *_different(archive, sound, kept, rebuilt)]
    except (sqlite3.DatabaseError, UnicodeDecodeError) as error:
        if not is_damage(error):
            look.error("catalog", f"cannot be read ({error}); expected a readable file", "verify again")
            return [look]
        look.note("catalog", f"found a damaged or outdated catalog ({error}); expected a catalog of this version", _LS)
        return [look]


def _gone(archive: Path, kept: sqlite3.Connection, recorded: Set[str]) -> Iterator[Look]:
    for name in sorted(noted(kept).keys() - stamps(archive).keys() - recorded):
        look = Look(name)
        message = "found no file of this name, although the catalog lists it; expected the archived file"
        look.warning("catalog", message, "restore it from a backup; if it was removed on purpose, run `tribopipe ls`")
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
            message = (
                "found content that differs from the catalog, without a recorded change; expected the cataloged content"
            )
            look.warning("catalog", message, f"restore it from a backup if it is damaged; otherwise remove {FILE_NAME}")
            yield look


def _looks(path: Path, stamp: Stamp) -> bool:
    """Return whether a file looks as it did before it was read."""
    try:
        return stamp_of(path.stat()) == stamp
    except FileNotFoundError:
        return False


def _said(connection: sqlite3.Connection, question: str, name: str) -> list[tuple[float | str | None, ...]]:
    return [tuple(row) for row in connection.execute(question, (name,))]


_OURS = {FILE_NAME, f"{FILE_NAME}-journal", HISTORY, LAST_PASS, REMOVED, STUDIES, FIGURES}


def look_around(archive: Path) -> list[Look]:
    """Look at everything in the archive's folder that is not a run or study."""
    return [*_left_over(archive), *_others(archive), *_colliding(archive)]


def _left_over(archive: Path) -> Iterator[Look]:
    """Find temporary files whose writer has ended."""
    for folder in (archive, archive / STUDIES, archive / FIGURES):
        for part in leftovers(folder):
            if _is_abandoned(archive, part):
                look = Look(_inside(archive, part))
                message = "found a temporary file of a process that was killed; the file it was to replace is unchanged"
                look.note("folder", message, "the next command that writes to the archive removes it")
                yield look


def _is_abandoned(archive: Path, part: Path) -> bool:
    """Return whether nobody writes a temporary file any more: whoever writes a run or a study holds its lock."""
    with suppress(OSError):  # where nobody can write, nobody does
        if part.parent.name == FIGURES:
            return is_old(part)
        try:
            with writers_lock(archive, part.name[1:].partition(SUFFIX)[0], wait=False):
                return part.exists()
        except ArchiveError:
            return False
    return part.exists()


def _others(archive: Path) -> Iterator[Look]:
    """Find what tribopipe has not put there, and what is called as a run or study but is no file."""
    for path in _entries(archive, stamps(archive).keys() | _OURS):
        look = Look(_inside(archive, path))
        if path.is_symlink() and not path.exists():
            look.error("folder", "found a broken link; expected the file itself", "restore its target")
        else:
            look.note(
                "folder", "found a file not written by tribopipe; expected only runs and studies", "move it elsewhere"
            )
        yield look


def _entries(archive: Path, known: Set[str]) -> list[Path]:
    """Return what is there with what is known, but for what is hidden."""
    folders = [folder for folder in (archive, archive / STUDIES) if folder.is_dir()]
    there = sorted(path for folder in folders for path in folder.iterdir())
    return [path for path in there if not path.name.startswith(".") and _inside(archive, path) not in known]


def _inside(archive: Path, path: Path) -> str:
    return path.relative_to(archive).as_posix()


def _colliding(archive: Path) -> Iterator[Look]:
    """Find names that are one and the same where a file system does not distinguish capitals."""
    alike = defaultdict(list)
    for name in stamps(archive):
        alike[name.casefold()].append(name)
    for names in (sorted(names) for names in alike.values() if len(names) > 1):
        look = Look(names[0])
        message = (
            f"found {', '.join(names[1:])}, identical to this name except for case; expected names that differ in more "
            "than case"
        )
        look.warning(
            "folder", message, "move one of them to another folder: on Windows and macOS, one would overwrite the other"
        )
        yield look
