"""The seal of an archived file: a checksum of every byte, by which damage is known before HDF5 looks at it.

HDF5 keeps checksums of large columns only. A flipped bit elsewhere may change a number without a word, or lead the HDF5
library in circles. So each file begins with a user block, which HDF5 passes over, that holds the SHA-256 of all bytes
after it. The seal shows accidents; it is no signature, since anybody can compute it.
"""

import hashlib
import os
import re
import time
from pathlib import Path

from tribopipe.archive.file_signature import Stamp, stamp_of
from tribopipe.base.errors import ArchiveError
from tribopipe.base.files import sha256_of

SEAL_SIZE = 512
"""The least user block that HDF5 has, bytes."""
_FIRST = b"tribopipe archive file, sealed. HDF5 begins at byte 512; SHA-256 of all bytes from there:\n"
_DIGEST = re.compile(re.escape(_FIRST) + rb"([0-9a-f]{64})\s")
_SIGNATURE, _SUPERBLOCK = b"\x89HDF\r\n\x1a\n", 48
_PLACES_OF_LENGTH = {0: 40, 2: 28, 3: 28}
"""Where HDF5 states how long the file is, by the version that follows its signature."""
_MOST_KNOWN = 10_000
_whole: dict[Path, Stamp] = {}
"""Files that were found whole by this process, as they looked then."""


def seal_file(path: Path) -> None:
    """Seal a file on the disk again."""
    with path.open("rb+") as file:
        file.seek(SEAL_SIZE)
        written = _seal_of(hashlib.file_digest(file, "sha256").hexdigest())
        file.seek(0)
        file.write(written)


def is_sealed(path: Path) -> bool:
    """Return whether a file has a seal, whole or broken. Raises ``OSError`` where it cannot be read."""
    with path.open("rb") as file:
        return file.read(len(_FIRST)) == _FIRST


def state_of(path: Path) -> str | None:
    """Return the checksum that a file is sealed with, or of all its bytes where it has no seal; none without a file.

    Nothing states that a sealed file is whole. Raises ``OSError`` where it cannot be read.
    """
    if not path.is_file():
        return None
    with path.open("rb") as file:
        found = _DIGEST.match(file.read(SEAL_SIZE))
    return found[1].decode("ascii") if found else sha256_of(path)


def check_seal(path: Path) -> None:
    """Raise ``ArchiveError`` where any byte of a file is another than was written; ``OSError`` where it is unreadable.

    A file that was found whole is known again by its stamp, and not read a second time.
    """
    if _whole.get(path) != stamp_of(path.stat()):
        check_every_byte(path)


def check_beginning(path: Path, begins: bytes, size: int) -> bool:
    """Return whether a file has a seal by its first bytes. Raises ``ArchiveError`` where its length is another one.

    This is all that can be checked of a file that is not read whole.
    """
    if _length_said(begins[SEAL_SIZE:]) not in (None, size):
        raise _damaged(path, "its length differs from that in its header")
    return begins.startswith(_FIRST)


def check_every_byte(path: Path) -> None:
    """Read a file whole, whatever is known of it. Raises as ``check_seal`` does."""
    stamp = stamp_of(path.stat())
    settled = stamp.settled(time.time_ns())
    with path.open("rb") as file:
        written = file.read(SEAL_SIZE)
        size = os.fstat(file.fileno()).st_size  # of the file opened, for another may have taken its place meanwhile
        if _length_said(file.read(_SUPERBLOCK)) != size:  # a terabyte of nothing takes an hour to read
            raise _damaged(path, "its length differs from that in its header")
        file.seek(SEAL_SIZE)
        found = _seal_of(hashlib.file_digest(file, "sha256").hexdigest())
    if written != found:
        raise _damaged(path, "its checksum differs from that in its seal")
    if settled:
        know(path, stamp)


def know(path: Path, stamp: Stamp) -> None:
    """Take a file for whole as long as it bears a stamp: it was read, or written by this process and read back."""
    if len(_whole) >= _MOST_KNOWN:
        _whole.clear()
    _whole[path] = stamp


def _length_said(superblock: bytes) -> int | None:
    """Return how long a file is by what HDF5 begins with, bytes; none where that is not HDF5."""
    if superblock[: len(_SIGNATURE)] != _SIGNATURE or len(superblock) < _SUPERBLOCK:
        return None
    place = _PLACES_OF_LENGTH.get(superblock[len(_SIGNATURE)])
    return None if place is None else int.from_bytes(superblock[place : place + 8], "little")


def _damaged(path: Path, why: str) -> ArchiveError:
    return ArchiveError(
        f"{path}: found a damaged file ({why}); expected the file as tribopipe wrote it; restore it from a backup, or "
        "save its intact source files with `tribopipe rescue`"
    )


def _seal_of(digest: str) -> bytes:
    return (_FIRST + digest.encode("ascii")).ljust(SEAL_SIZE - 1) + b"\n"
