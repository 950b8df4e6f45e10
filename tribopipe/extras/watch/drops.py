"""Content of a watched folder: exports of one test each, and run folders."""

import hashlib
import os
import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from tribopipe.base.files import natural_order
from tribopipe.documents.manifest import MANIFEST_NAME

_UNFINISHED = re.compile(r"^[.~]|~$|\.(tmp|temp|part|partial|filepart|crdownload|bak|lock)$", re.IGNORECASE)
_NO_EXPORT = re.compile(r"\.toml$|^(desktop\.ini|thumbs\.db)$", re.IGNORECASE)
"""Files next to exports that are ignored: templates, reader profiles and files written by Windows."""
_HELD = (32, 33)
"""Windows error codes of a file that another program has open or has locked in part."""


@dataclass(frozen=True)
class Drop:
    """The files of one test as they lie there now."""

    name: str
    """Path in the watched folder, of the file or the folder: "2026-11/test_07.csv"."""
    files: tuple[Path, ...]
    stamp: str
    """Another one whenever a name, a size or a time of change is."""
    is_run: bool = False
    """True for a run folder with a run.toml."""


def drops(folder: Path, *, together: bool = False, without: Collection[Path] = ()) -> list[Drop]:
    """Return what lies in a folder and below it, in natural order; each file is a test, but for run folders.

    With ``together`` the files of a folder within it are one test. Folders in ``without``, hidden ones, and those that
    links lead to are not looked into. What is empty is not written yet.

    Raises ``OSError`` where the folder itself cannot be listed.
    """
    files, left = _entries(folder)
    found = [drop for path in files for drop in _drop(folder, [path])]
    while left:
        here = left.pop()
        if here in without:
            continue
        with suppress(OSError):  # gone meanwhile, or not for us
            files, inner = _entries(here)
            left += inner
            found += _within(folder, here, files, together=together)
    return sorted(found, key=lambda drop: natural_order(drop.name))


def stamp_of(files: Iterable[Path]) -> str:
    """Return a text that is another one whenever a name, a size or a time of change is. Raises ``OSError``.

    Files are asked themselves: what Windows lists of a folder is old while a file is open.
    """
    return _stamp({path: path.stat() for path in files})


def _stamp(seen: Mapping[Path, os.stat_result]) -> str:
    told = [(path.name, one.st_size, one.st_mtime_ns) for path, one in seen.items()]
    return hashlib.sha256(repr(told).encode()).hexdigest()[:16]


def moves(drop: Drop) -> bool:
    """Return whether files were changed or removed since they were last read."""
    try:
        return stamp_of(drop.files) != drop.stamp
    except OSError:
        return True


def is_held(files: Iterable[Path]) -> bool:
    """Return whether another program still has one of the files to itself, as only Windows knows."""
    for path in files:
        try:
            path.open("rb").close()
        except PermissionError as error:
            if getattr(error, "winerror", None) in _HELD:
                return True
        except OSError:
            pass  # which whoever reads it will say better
    return False


def _entries(folder: Path) -> tuple[list[Path], list[Path]]:
    """Return the files and the folders in a folder, but for those with names of what is not finished."""
    with os.scandir(folder) as entries:
        there = sorted((one for one in entries if not _UNFINISHED.search(one.name)), key=lambda one: one.name)
    files = [Path(one.path) for one in there if one.is_file()]
    return files, [Path(one.path) for one in there if one.is_dir(follow_symlinks=False)]


def _within(root: Path, here: Path, files: list[Path], *, together: bool) -> Iterator[Drop]:
    """Return what a folder within the watched one holds."""
    if any(path.name == MANIFEST_NAME for path in files):
        yield from _drop(root, files, folder=here, is_run=True)
    elif together:
        yield from _drop(root, [path for path in files if not _NO_EXPORT.search(path.name)], folder=here)
    else:
        for path in files:
            yield from _drop(root, [path])


def _drop(root: Path, files: list[Path], folder: Path | None = None, *, is_run: bool = False) -> Iterator[Drop]:
    """Return files as one drop; None if one of them is empty or gone, or if a single file is no export."""
    if not files or (folder is None and _NO_EXPORT.search(files[0].name)):
        return
    with suppress(OSError):
        seen = {path: path.stat() for path in files}
        if all(one.st_size for one in seen.values()):
            yield Drop(_written(folder or files[0], root), tuple(files), _stamp(seen), is_run)


def _written(path: Path, root: Path) -> str:
    """Return a path in a folder as text: on Linux it may hold bytes that are no text."""
    return path.relative_to(root).as_posix().encode("utf-8", "backslashreplace").decode()
