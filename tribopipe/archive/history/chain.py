"""Appending to the history of an archive, whoever else does at the same moment.

A write is announced before its file takes its place, and confirmed afterwards. Whoever is killed in between leaves the
old file or the new one, both of which the announcement names; any other is an exchange.

Each line is on the disk before the next step. A line that a killed process left half-written stays, and counts as one
that proves nothing. The hash of the last line is also kept next to the locks, so that a history that lost its end
is noticed.
"""

import os
import stat
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

from tribopipe.archive.file_signature import stamps
from tribopipe.archive.history.entry import (
    FILE_NAME,
    FIRST,
    LONGEST_LINE,
    Change,
    Entry,
    State,
    chained,
    entry,
    hash_of,
)
from tribopipe.archive.lock import LOCKS, history_lock
from tribopipe.archive.seal import state_of
from tribopipe.base.errors import ArchiveError
from tribopipe.base.files import replacing

_HEAD = "history.head"
"""File with the locks that holds the hash of the last line."""
_TAIL = 4096
"""Bytes at the end that are read first."""
_OTHERS_WRITE = stat.S_IWGRP | stat.S_IWOTH


@contextmanager
def placed(archive: Path, path: Path, event: Change) -> Iterator[Path]:
    """Yield a temporary file that replaces a file of the archive, recorded in the history before and after.

    Whoever calls it holds the lock of the file's writers. Raises ``OSError`` and ``ArchiveError`` where the file or the
    history cannot be written; the file is then as it was.
    """
    before = state_of(path)
    with replacing(path, lambda part: announced(archive, path, event, before, state_of(part))) as part:
        yield part


@contextmanager
def announced(
    archive: Path, path: Path, event: Change, before: State, after: State, by: str | None = None
) -> Iterator[None]:
    """Announce a change of a file, and confirm it once it is done; a done one fails no more."""
    name = path.relative_to(archive).as_posix()
    append(archive, [entry(event, name, before=before, after=after, by=by)])
    yield
    with suppress(OSError, ArchiveError):
        append(archive, [entry("done", name)])


def append(archive: Path, entries: Sequence[Entry]) -> None:
    """Add lines to the history, all or none; one that is lost or cut is gone on with, and a warning is given.

    Raises ``ArchiveError`` where another process holds its lock for minutes, or its end is no line of a history;
    ``OSError`` where it cannot be written.
    """
    with history_lock(archive):
        path = archive / FILE_NAME
        try:
            with _opened(path, archive) as file:
                head = _added(archive, file, entries)
        except PermissionError:
            # It belongs to another account, which lets us write into its folder.
            with replacing(path) as part, part.open("r+b") as copy, path.open("rb") as old:
                while piece := old.read(1 << 20):
                    copy.write(piece)
                head = _added(archive, copy, entries)
        _keep_head(archive, head)


def known_head(archive: Path) -> str | None:
    """Return the hash of the last line that is stored next to the history; none if there is none."""
    try:
        kept = (archive / LOCKS / _HEAD).read_bytes()[:64].decode("ascii", "replace")
    except OSError:
        return None
    return kept if len(kept) == len(FIRST) else None


def _keep_head(archive: Path, head: str) -> None:
    """Keep the hash of the last line in the place of the one before; it helps, so that nothing fails without it."""
    path = archive / LOCKS / _HEAD
    with suppress(OSError):
        try:
            with path.open("r+b") as file:
                file.write(head.encode("ascii"))
        except FileNotFoundError:
            path.write_bytes(head.encode("ascii"))
            path.chmod(0o666)  # as the locks are: all who may write into the archive use it


def _opened(path: Path, archive: Path) -> BinaryIO:
    """Open the history, which those may write who may write into the archive."""
    with suppress(FileNotFoundError):
        return path.open("r+b")
    file = path.open("x+b")
    with suppress(OSError):
        path.chmod(stat.S_IMODE(path.stat().st_mode) | archive.stat().st_mode & _OTHERS_WRITE)
    return file


def _added(archive: Path, file: BinaryIO, entries: Sequence[Entry]) -> str:
    """Append lines after the last one; return the hash of the new last one."""
    size, known = file.seek(0, os.SEEK_END), known_head(archive)
    last = _last_line(archive, file, size)
    previous = hash_of(last.rstrip(b"\n")) if size else FIRST
    ended = last.endswith(b"\n")
    if len(last) == size and not ended:  # there is nothing yet, or half of a first line
        entries = [entry("begun", files=len(stamps(archive)), lost=known or ""), *entries]
    elif known not in (None, previous) and not _has_line(file, known):
        entries = [entry("broken", lost=known), *entries]
    lines, head = chained(entries, previous)
    file.seek(size)
    try:
        file.write(lines if ended or not size else b"\n" + lines)
        file.flush()
        os.fsync(file.fileno())
    except OSError:
        with suppress(OSError):
            os.truncate(file.fileno(), size)
        raise
    return head


def _last_line(archive: Path, file: BinaryIO, size: int) -> bytes:
    """Return the last line, with its end if it has one; nothing of an empty file."""
    tail = min(_TAIL, LONGEST_LINE)
    while size:
        start = max(0, size - tail)
        file.seek(start)
        read = file.read(size - start)
        begins = read.rfind(b"\n", 0, -1) + 1
        if begins or not start:
            return read[begins:]
        if tail > LONGEST_LINE:
            raise ArchiveError(
                f"{archive / FILE_NAME}: found a last line of more than {LONGEST_LINE:,} bytes; expected lines as "
                "tribopipe writes them; restore the history from a copy"
            )
        tail *= 4
    return b""


def _has_line(file: BinaryIO, wanted: str | None) -> bool:
    """Return whether a line of a hash is there."""
    file.seek(0)
    return any(hash_of(line.rstrip(b"\n")) == wanted for line in file)
