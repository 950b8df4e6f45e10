"""Where a command may write: over nothing that it did not make, and never into an archive or a run folder."""

import os
from collections.abc import Callable, Iterable
from pathlib import Path

from tribopipe.archive.catalog.database import FILE_NAME
from tribopipe.archive.file_signature import FIGURES
from tribopipe.archive.history import FILE_NAME as HISTORY
from tribopipe.archive.lock import LOCKS
from tribopipe.base.errors import OutputError
from tribopipe.documents.manifest import MANIFEST_NAME

_ARCHIVE, _RUN = "an archive", "a run folder"
MADE_BY = "tribopipe"
"""What files of tribopipe state about their maker."""
_SEEN = 8192
"""Bytes at either end of a file in which it may report it."""
Own = Callable[[Path], bool]
"""A function that returns whether an existing file was made by the same command."""


def made_here(path: Path) -> bool:
    """Return whether a picture or a schema states that tribopipe made it."""
    with path.open("rb") as file:
        start = file.read(_SEEN)
        file.seek(max(0, path.stat().st_size - _SEEN))
        return MADE_BY.encode() in start + file.read()


def require_free(
    paths: Iterable[Path], *, force: bool = False, own: Own | None = None, beside_run: bool = False
) -> None:
    """Refuse to write files where something else is, before any of them is written.

    Parameters
    ----------
    paths
        Files to be written.
    force
        Whether files that are there may be replaced.
    own
        Shows which of them the same command has made: these may be replaced, as may the figures of an archive.
    beside_run
        Whether they may lie in a run folder.

    Raises
    ------
    OutputError
        Where a file is there that must not be replaced, a folder, or a place inside an archive or a run folder.
    """
    for path in paths:
        if path.is_dir():
            raise OutputError(f"{path}: found a folder; expected the path of a file; add a file name")
        require_outside(path, beside_run=beside_run)
        ours = own is not None and (_in_own_figures(path) or (path.is_file() and own(path)))
        if os.path.lexists(path) and not (ours or force):
            remedy = "use --force to replace it" if own is None else "specify another file"
            raise OutputError(f"{path}: found an existing file; expected a new file; {remedy}")


def require_folder(folder: Path) -> None:
    """Refuse to write into a folder that is something else, or that lies in an archive or a run folder.

    Raises
    ------
    OutputError
        Where a file is there, or a link to nowhere, and where ``require_outside`` refuses what is in the folder.
    """
    if os.path.lexists(folder) and not folder.is_dir():
        raise OutputError(f"{folder}: found a file or a broken link; expected a folder; specify another folder")
    require_outside(folder / "any")


def require_outside(path: Path, *, beside_run: bool = False) -> None:
    """Raise ``OutputError`` where a path leads into an archive, but for its figures, or a run folder, links followed.

    ``beside_run`` allows the run folder.
    """
    if _in_own_figures(path):
        return
    for folder in Path(os.path.realpath(path)).parents:
        kind = _kind(folder)
        if kind == _ARCHIVE or (kind == _RUN and not beside_run):
            raise OutputError(
                f"{path}: found a path inside {kind}, {folder}, where only tribopipe writes; expected a path outside; "
                "choose a different folder"
            )


def _in_own_figures(path: Path) -> bool:
    """Return whether a file lies in the folder of figures of an archive, in which there is nothing else."""
    folder = Path(os.path.realpath(path.parent))
    return folder.name == FIGURES and _kind(folder.parent) == _ARCHIVE


def _kind(folder: Path) -> str | None:
    if (folder / MANIFEST_NAME).is_file():
        return _RUN
    ours = (folder / LOCKS).is_dir() or any((folder / name).is_file() for name in (FILE_NAME, HISTORY))
    return _ARCHIVE if ours else None
