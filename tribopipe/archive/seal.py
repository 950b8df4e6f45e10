"""The seal of an archived file: a checksum of every byte, by which damage is known before HDF5 looks at it.

HDF5 keeps checksums of large columns only. A flipped bit elsewhere may change a number without a word, or lead the HDF5
library in circles. So each file begins with a user block, which HDF5 passes over, that holds the SHA-256 of all bytes
after it. The seal tells accidents; it is no signature, since anybody can compute it.
"""

import hashlib
import time
from pathlib import Path

from tribopipe.archive.stamps import Stamp, stamp_of
from tribopipe.errors import ArchiveError

SEAL_SIZE = 512
"""The least user block that HDF5 has, bytes."""
_FIRST = b"tribopipe archive file, sealed. HDF5 begins at byte 512; SHA-256 of all bytes from there:\n"
_MOST_KNOWN = 10_000
_whole: dict[Path, Stamp] = {}
"""Files that were found whole by this process, as they looked then."""


def seal(image: memoryview) -> None:
    """Put the seal into the first 512 bytes of a file's content, which HDF5 has left free."""
    image[:SEAL_SIZE] = _seal_of(hashlib.sha256(image[SEAL_SIZE:]).hexdigest())


def seal_file(path: Path) -> None:
    """Seal a file on the disk anew."""
    with path.open("rb+") as file:
        file.seek(SEAL_SIZE)
        written = _seal_of(hashlib.file_digest(file, "sha256").hexdigest())
        file.seek(0)
        file.write(written)


def is_sealed(path: Path) -> bool:
    """Tell whether a file has a seal, whole or broken. Raises ``OSError`` where it cannot be read."""
    with path.open("rb") as file:
        return file.read(len(_FIRST)) == _FIRST


def check_seal(path: Path) -> None:
    """Raise ``ArchiveError`` where any byte of a file is another than was written; ``OSError`` where it is unreadable.

    A file that was found whole is known again by its stamp, and not read a second time.
    """
    stamp = stamp_of(path.stat())
    if _whole.get(path) == stamp:
        return
    settled = stamp.settled(time.time_ns())
    with path.open("rb") as file:
        written = file.read(SEAL_SIZE)
        found = _seal_of(hashlib.file_digest(file, "sha256").hexdigest())
    if written != found:
        raise ArchiveError(
            f"{path}: found a damaged file (its checksum is not the one it was sealed with); expected every byte as "
            "tribopipe wrote it; restore it from a copy, or save what is whole in it with `tribopipe rescue`"
        )
    if settled:
        if len(_whole) >= _MOST_KNOWN:
            _whole.clear()
        _whole[path] = stamp


def _seal_of(digest: str) -> bytes:
    return (_FIRST + digest.encode("ascii")).ljust(SEAL_SIZE - 1) + b"\n"
