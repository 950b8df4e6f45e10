"""One writer at a time for each file of an archive, among all processes and machines that share the folder.

The lock is the operating system's (flock, or its like on Windows), so that it ends with its holder, however that ends.
Where a file system has none, the library falls back to marker files, which it takes away when their holder is gone.
Readers take no lock: files are only ever replaced whole.
"""

import logging
import zlib
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, suppress
from pathlib import Path

from tribopipe.archive.remote import refuse_writing
from tribopipe.base.errors import ArchiveError, printable

LOCKS = ".locks"
_HISTORY = "history"
"""Lock of the history, which is taken within that of a file and never the other way round."""
_SHARES = 256
"""Files in the folder of locks: the archived files share them, so that there are not as many again."""
_WAIT = 300.0
"""How long another may write, s: the longest runs take some seconds."""
SILENT = 1.5
"""How long a wait needs no word, s."""
_LOOK_EVERY = 0.01
_log = logging.getLogger(__name__)


def say_waiting(folder: Path, name: str, seconds: float) -> None:
    """Inform people what is waited for, as a warning of the log, which goes to stderr unless somebody catches it."""
    where = printable(str(folder))
    _log.warning("%s: another tribopipe process is writing %s; waiting up to %.0f s", where, name, seconds)


def share_of(name: str) -> str:
    """Return which of the locks a file of a name has: several files share one."""
    # Names that differ in case alone may be one file.
    return f"{zlib.crc32(name.casefold().encode()) % _SHARES:03}"


def writers_lock(folder: Path, name: str, *, wait: bool = True) -> AbstractContextManager[None]:
    """Hold the lock of all writers of the file of a name; without ``wait`` only if it is free at once, or nearly so.

    Raises ``ArchiveError`` where another holds it for minutes, or at all where that is not waited for, ``OSError``
    where the folder cannot be written.
    """
    return _held(folder, share_of(name), name, wait=wait)


def history_lock(folder: Path) -> AbstractContextManager[None]:
    """Hold the lock of all who append to the history of an archive. Raises as ``writers_lock`` does."""
    return _held(folder, _HISTORY, "its history")


@contextmanager
def _held(folder: Path, share: str, name: str, *, wait: bool = True) -> Iterator[None]:
    from filelock import FileLock, Timeout

    refuse_writing(folder)
    locks = folder / LOCKS
    locks.mkdir(parents=True, exist_ok=True)
    lock = FileLock(locks / f"{share}.lock", timeout=SILENT, poll_interval=_LOOK_EVERY, mode=0o666)
    try:
        try:
            lock.acquire()
        except Timeout:
            if not wait:
                raise
            say_waiting(folder, name, _WAIT)
            lock.acquire(timeout=_WAIT)
    except Timeout:
        raise ArchiveError(
            f"{folder}: found another tribopipe process that has been writing {name} for more than {_WAIT:.0f} s; "
            "expected the process to end; check whether it is suspended, and run the command again"
        ) from None
    try:
        yield
    finally:
        with suppress(OSError):  # what was done is done; the lock ends with the process at the latest
            lock.release()
