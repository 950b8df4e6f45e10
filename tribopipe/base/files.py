"""Files read fast, files written whole or not at all, and names in the order people expect."""

import errno
import hashlib
import os
import re
import stat
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import AbstractContextManager, contextmanager, nullcontext, suppress
from fnmatch import fnmatch
from functools import partial
from io import BytesIO
from itertools import islice
from pathlib import Path

from tribopipe.base.process_lifecycle import undone_by

_LARGE = 8 << 20
_THREADS = 2
_MOST_NAMED = 1000
_PART = ".part"
_ACCESS_LIST = "system.posix_acl_access"
_IS_WINDOWS = os.name == "nt"
_LONGEST_WRITE = 600.0
"""How long a file may take that is written without a lock, s."""
_WAITS = (0.05, 0.1, 0.2, 0.4, 0.8, 1.6, 3.2)
"""How long to wait for readers on Windows, s."""


def read_file(path: Path) -> bytes:
    """Return the bytes of a file; both halves of a large file are read in parallel because memory allocation is slow.

    Raises ``OSError`` where the file cannot be read, is a pipe or a device, or became shorter meanwhile.
    """
    seen = path.stat()
    _refuse_endless(seen)
    size = seen.st_size
    if size < _LARGE:
        return path.read_bytes()
    buffer = BytesIO(bytes(size))  # of memory not touched yet
    ends = [size * part // _THREADS for part in range(_THREADS + 1)]
    with buffer.getbuffer() as view, ThreadPoolExecutor(_THREADS) as pool:
        list(pool.map(lambda start, end: _fill(path, start, view[start:end]), ends[:-1], ends[1:]))
    return buffer.getvalue()


def pieces_of(path: Path, size: int) -> Iterator[bytes]:
    """Yield the bytes of a file in pieces of equal size, the last shorter. Raises ``OSError`` as ``read_file`` does."""
    _refuse_endless(path.stat())
    with path.open("rb") as file:
        while piece := file.read(size):
            yield piece


def sha256_of(path: Path) -> str:
    """Return the SHA-256 of a file, in hexadecimal digits. Raises ``OSError`` as ``read_file`` does."""
    _refuse_endless(path.stat())
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _refuse_endless(seen: os.stat_result) -> None:
    """Refuse what is no file: opening a pipe may wait for ever, and a device may have no end."""
    if not stat.S_ISREG(seen.st_mode):
        raise OSError(errno.EINVAL, "not a file, but a pipe or a device")


def stored_size(path: Path) -> int:
    """Return the bytes of a file that are in use: holes, which take no room on the disk, do not count.

    Raises ``OSError`` where there is no such file.
    """
    seen = path.stat()
    if not stat.S_ISREG(seen.st_mode):
        raise OSError(0, "not a regular file")
    return min(seen.st_size, 512 * getattr(seen, "st_blocks", seen.st_size))


def _fill(path: Path, start: int, part: memoryview) -> None:
    with part, path.open("rb") as file:
        file.seek(start)
        if file.readinto(part) < len(part):
            raise OSError(0, "the file became shorter while it was read")


def beside(path: Path) -> list[str]:
    """Name what stands in the folder of a path, up to a thousand entries; nothing where there is no such folder."""
    try:
        return [entry.name for entry in islice(path.parent.iterdir(), _MOST_NAMED)]
    except OSError:
        return []


def found_below(folder: Path, *patterns: str) -> list[Path]:
    """Return everything below a folder whose name matches one of the patterns.

    Folders that links lead to are not looked into, nor are those that cannot be read.
    """
    found: list[Path] = []
    left = [folder]
    while left:
        with suppress(OSError), os.scandir(left.pop()) as entries:
            for entry in entries:
                if any(fnmatch(entry.name, pattern) for pattern in patterns):
                    found.append(Path(entry.path))
                if entry.is_dir(follow_symlinks=False):
                    left.append(Path(entry.path))
    return found


def leads_out(path: Path, folder: Path) -> bool:
    """Return whether a path ends outside a folder once links are followed."""
    return not Path(os.path.realpath(path)).is_relative_to(os.path.realpath(folder))


Placing = Callable[[Path], AbstractContextManager[object]]
"""What is done around the moment at which a temporary file takes its place."""


@contextmanager
def replacing(path: Path, placing: Placing = nullcontext) -> Iterator[Path]:
    """Give the name of a temporary file next to ``path`` that takes its place on success and vanishes on failure.

    The content is on the disk before it is given its name, and the name before this returns, so that a crash leaves
    the old file or the new one, and what was reported as written is. A file that was there keeps its mode, group and
    access list; raises ``PermissionError`` where its owner has taken away the right to write. ``placing`` is given the
    temporary file once it is whole, and entered before it takes its name.
    """
    with _blamed_on(path):
        there = _writable(path)
        handle, name = tempfile.mkstemp(prefix=f".{path.name}.", suffix=_PART, dir=path.parent)
        os.close(handle)
        part = Path(name)
        with undone_by(partial(part.unlink, missing_ok=True)):
            yield part
            with part.open("rb+") as written:
                put_on_disk(written.fileno())
            _give_rights(part, path, there)
            with placing(part):
                _take_place(part, path)
                _sync_folder(path.parent)


def _writable(path: Path) -> os.stat_result | None:
    """Return what is known of a file; none where there is none."""
    try:
        there = path.stat()
    except FileNotFoundError:
        return None
    if not there.st_mode & stat.S_IWUSR:
        raise PermissionError(errno.EACCES, "the file is read-only", str(path))
    return there


def _give_rights(part: Path, path: Path, there: os.stat_result | None) -> None:
    """Let those read and write a new file who may the old one, as far as the system allows."""
    if there is None:
        part.chmod(0o666 & ~_umask())
        return
    if hasattr(os, "chown") and there.st_gid != part.stat().st_gid:
        with suppress(PermissionError):  # of a group that we are not in
            os.chown(part, -1, there.st_gid)
    part.chmod(stat.S_IMODE(there.st_mode))
    if hasattr(os, "getxattr"):
        with suppress(OSError):  # there is none, or the file system knows none
            os.setxattr(part, _ACCESS_LIST, os.getxattr(path, _ACCESS_LIST))


@contextmanager
def _blamed_on(path: Path) -> Iterator[None]:
    """Let errors name the file that was to be written: people know nothing of temporary ones."""
    try:
        yield
    except OSError as error:
        if error.filename is None or str(error.filename).endswith(_PART):
            error.filename = str(path)
        raise


def _take_place(part: Path, path: Path) -> None:
    """Give a temporary file or folder its name, if need be after some time.

    Windows refuses that while a reader has the old file open, or a file in the folder.
    """
    for wait in (*_WAITS, None):
        try:
            part.replace(path)
        except PermissionError:
            if wait is None or not _IS_WINDOWS:
                raise
            time.sleep(wait)
        else:
            return


def move(old: Path, new: Path) -> None:
    """Move a file or a folder to where there is none, on the same drive, into a folder that is made for it."""
    new.parent.mkdir(parents=True, exist_ok=True)
    _take_place(old, new)
    for folder in (new.parent, old.parent):
        _sync_folder(folder)


def put_on_disk(handle: int) -> None:
    """Return once what was written to an open file outlasts a power failure.

    On macOS, ``os.fsync`` leaves it in the cache of the drive, which has a request of its own; not every share knows
    it. Raises ``OSError`` where the disk is full or fails.
    """
    os.fsync(handle)
    if sys.platform == "darwin":
        import fcntl  # which Windows does not have

        try:
            fcntl.fcntl(handle, fcntl.F_FULLFSYNC)
        except OSError as error:
            if error.errno in (errno.EIO, errno.ENOSPC):
                raise


def _sync_folder(folder: Path) -> None:
    """Put the names in a folder on the disk. Windows opens no folders, and NTFS keeps a journal of names itself.

    A file that has its name is written: where a share cannot do this, or has an error of its own, nothing has failed,
    and whoever believed so would write it twice.
    """
    if _IS_WINDOWS:
        return
    with suppress(OSError):
        handle = os.open(folder, os.O_RDONLY)
        try:
            put_on_disk(handle)
        finally:
            os.close(handle)


def drive_of(folder: Path) -> int | None:
    """Return the number of the drive or share that a folder is on; none where there is no such folder."""
    try:
        return folder.stat().st_dev
    except OSError:
        return None


def leftovers(folder: Path) -> list[Path]:
    """Return the temporary files that writers left in a folder who could not end: they were killed, or still write."""
    try:
        names = os.listdir(folder)  # noqa: PTH208, since a path for each of 100,000 files takes long
    except (FileNotFoundError, NotADirectoryError):
        return []
    parts = (folder / name for name in names if name.startswith(".") and name.endswith(_PART))
    return sorted(part for part in parts if part.is_file())


def clear_leftovers_of(path: Path) -> None:
    """Remove the temporary files that killed writers of one file left; nobody may be writing it."""
    for part in leftovers(path.parent):
        if part.name[1:].removesuffix(_PART).rpartition(".")[0] == path.name:
            with suppress(OSError):
                part.unlink()


def is_old(part: Path) -> bool:
    """Return whether a temporary file was written to so long ago that its writer has ended. Raises ``OSError``."""
    return time.time() - part.stat().st_mtime > _LONGEST_WRITE


def write_file(path: Path, content: bytes | memoryview) -> None:
    """Write a file whole or not at all."""
    with replacing(path) as part:
        part.write_bytes(content)


def natural_order(name: str) -> list[tuple[str, int]]:
    """Return a key that sorts "400mN" before "1200mN"."""
    return [(text, int(digits or 0)) for text, digits in re.findall(r"(\D*)(\d{0,18})", name)]


def file_order(name: str) -> tuple[list[list[tuple[str, int]]], str]:
    """Return a key for names of files: natural order without the suffix, so that "run.csv" is before "run-1.csv"."""
    stem, _, suffix = name.rpartition(".")
    # Part by part, since "." sorts between the other signs that may follow a name.
    return [natural_order(part) for part in (stem or suffix).split(".")], suffix


def natural_key(name: str) -> bytes:
    """Return ``natural_order`` as bytes, which have the same order."""
    return b"".join(_key_of(text) + _key_of_number(number) for text, number in natural_order(name))


def _key_of(text: str) -> bytes:
    # Ends with what sorts before any further character.
    return text.encode("utf-8", "surrogatepass").replace(b"\0", b"\0\1") + b"\0\0"


def _key_of_number(number: int) -> bytes:
    length = (number.bit_length() + 7) // 8
    return bytes([length]) + number.to_bytes(length, "big")


def _umask() -> int:
    """Return the process's umask; a file made by mkstemp is private, one of this process is as any other."""
    mask = os.umask(0)
    os.umask(mask)
    return mask
