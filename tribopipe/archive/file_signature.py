"""How a file of the archive looks from outside, by which it is known again without being read."""

import os
import time
from pathlib import Path
from typing import NamedTuple

STUDIES, SUFFIX = "studies", ".h5"
FIGURES = "figures"
"""Folder of what is drawn of an archive, which may hold anything."""
_SETTLED_AFTER = 2_000_000_000
"""Age in ns from which a file cannot change any more without its time of change telling: the clocks of file systems
tick every 2 s at worst."""


class Stamp(NamedTuple):
    """Size, times and number of a file. Times are in ns since 1970; the number is 0 where the platform has none."""

    size: int
    modified: int
    changed: int
    number: int

    def __str__(self) -> str:
        return " ".join(map(str, self))

    def settled(self, now: int) -> bool:
        """Return whether a file read at a time, ns, would bear another stamp after any later change."""
        return max(self.modified, self.changed) < now - _SETTLED_AFTER


def stamps(archive: Path) -> dict[str, Stamp]:
    """Return the stamps of all runs and studies of an archive, by their path in it."""
    return _stamps(archive, "") | _stamps(archive / STUDIES, f"{STUDIES}/")


def folders_stamp(archive: Path) -> str | None:
    """Return a text that changes whenever a file is put into the folders of an archive, renamed or removed.

    None is returned where such a change may have just been made, so that a further one would not show.
    """
    now = time.time_ns()
    seen = [folder_stamp for folder in (archive, archive / STUDIES) if (folder_stamp := _folder_stamp(folder))]
    return " ".join(map(str, seen)) if all(stamp.settled(now) for stamp in seen) else None


def _folder_stamp(folder: Path) -> Stamp | None:
    try:
        return stamp_of(folder.stat())
    except OSError:
        return None


def _stamps(folder: Path, prefix: str) -> dict[str, Stamp]:
    try:
        with os.scandir(folder) as entries:
            seen = {prefix + entry.name: _stamp(entry) for entry in entries if _may_be_ours(entry.name)}
    except (FileNotFoundError, NotADirectoryError):
        return {}
    return {name: stamp for name, stamp in seen.items() if stamp is not None}


def _may_be_ours(name: str) -> bool:
    unicode = name.encode("utf-8", "ignore").decode() == name
    return unicode and name.endswith(SUFFIX) and not name.startswith(".")


def _stamp(entry: "os.DirEntry[str]") -> Stamp | None:
    """Return the stamp of a file; none for a folder, or for a file that has just been removed."""
    try:
        seen = entry.stat() if entry.is_file() else None
    except FileNotFoundError:
        return None
    return seen and stamp_of(seen)


def stamp_of(seen: os.stat_result) -> Stamp:
    """Return the stamp of a file by what the platform shows of it."""
    return Stamp(seen.st_size, seen.st_mtime_ns, seen.st_ctime_ns, seen.st_ino)
