"""What lies in an archive's folder next to its runs and studies."""

from collections import defaultdict
from collections.abc import Iterator, Set
from contextlib import suppress
from pathlib import Path

from tribopipe.archive.catalog.database import FILE_NAME
from tribopipe.archive.file_signature import FIGURES, STUDIES, SUFFIX, stamps
from tribopipe.archive.history.entry import FILE_NAME as HISTORY
from tribopipe.archive.lock import writers_lock
from tribopipe.archive.removal import REMOVED
from tribopipe.base.errors import ArchiveError
from tribopipe.base.files import is_old, leftovers
from tribopipe.pipeline.last_pass import FILE_NAME as LAST_PASS
from tribopipe.pipeline.verify.look import Look

_OURS = {FILE_NAME, f"{FILE_NAME}-journal", HISTORY, LAST_PASS, REMOVED, STUDIES, FIGURES}


def look_around(archive: Path) -> list[Look]:
    """Look at everything in the archive's folder that is no run and no study."""
    return [*_left_over(archive), *_others(archive), *_colliding(archive)]


def _left_over(archive: Path) -> Iterator[Look]:
    """Find temporary files whose writer has ended."""
    for folder in (archive, archive / STUDIES, archive / FIGURES):
        for part in leftovers(folder):
            if _is_abandoned(archive, part):
                look = Look(_inside(archive, part))
                message = "found a temporary file of a process that was killed; the file it was to replace is unchanged"
                look.note("folder", message, "the next command that writes removes it")
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
            look.error("folder", "found a link that leads nowhere; expected the file", "restore its target")
        else:
            look.note("folder", "found a file not written by tribopipe; expected runs and studies", "move it elsewhere")
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
        message = f"found {', '.join(names[1:])}, which differs only in upper and lower case; expected different ids"
        look.warning("folder", message, "keep one of them elsewhere: on Windows and macOS one would replace the other")
        yield look
