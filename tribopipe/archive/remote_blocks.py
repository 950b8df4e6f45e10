"""A large file on remote storage, of which HDF5 reads a part: blocks are fetched by range requests, and kept.

Blocks in a row are fetched in ever larger groups, since each request waits for an answer.
"""

import errno
import os
from collections.abc import Callable
from io import SEEK_CUR, SEEK_END, SEEK_SET, RawIOBase
from pathlib import Path
from threading import Lock
from typing import TYPE_CHECKING
from weakref import WeakValueDictionary

from tribopipe.base.errors import ArchiveError

if TYPE_CHECKING:
    from _typeshed import WriteableBuffer

BLOCK = 1 << 18
"""Bytes of a block: the outline of a run of 100 MB is scattered over a dozen of them."""
_MOST_AHEAD = 16
"""Blocks fetched at once while a column is read."""
_known: "WeakValueDictionary[str, RemoteBlocks]" = WeakValueDictionary()


class RemoteBlocks:
    """The blocks of one file; any thread may ask. Raises ``ArchiveError`` where one cannot be fetched."""

    def __init__(self, where: str, size: int, fetch: Callable[[int, int], bytes], kept: Path) -> None:
        """Have blocks from ``fetch``, which is given the first byte and the one after the last, kept in a file."""
        self.where, self.size, self._fetch = where, size, fetch
        self._kept = kept.open("w+b")
        self._there: set[int] = set()
        self._lock, self._next, self._ahead = Lock(), -1, 1
        _known[where] = self

    def __del__(self) -> None:
        """Close the file of blocks."""
        self._kept.close()

    def read_at(self, place: int, size: int) -> bytes:
        """Return so many bytes, fewer at the end of the file."""
        end = min(place + size, self.size)
        if place >= end:
            return b""
        with self._lock:
            for block in range(place // BLOCK, -(-end // BLOCK)):
                if block not in self._there:
                    self._get(block, -(-end // BLOCK))
            self._kept.seek(place)
            return self._kept.read(end - place)

    def _get(self, block: int, wanted: int) -> None:
        """Fetch a block and those after it that are wanted, or will be if a column is read from start to end."""
        self._ahead = min(2 * self._ahead, _MOST_AHEAD) if block == self._next else 1
        last = min(max(wanted, block + self._ahead), -(-self.size // BLOCK))
        end = next((one for one in range(block, last) if one in self._there), last)
        start, stop = block * BLOCK, min(end * BLOCK, self.size)
        content = self._fetch(start, stop)
        if len(content) != stop - start:
            raise ArchiveError(
                f"{self.where}: found {len(content):,} bytes where {stop - start:,} were requested; expected an "
                "unchanged file; run the command again"
            )
        self._kept.seek(start)
        self._kept.write(content)
        self._there.update(range(block, end))
        self._next = end


def blocks_named(where: str) -> RemoteBlocks | None:
    """Return the blocks of a file that HDF5 has open under a name; none for a file on this computer."""
    return _known.get(where)


class BlockFile(RawIOBase):
    """A file of blocks as HDF5 reads it. It keeps its first error, since HDF5 has other words for it."""

    def __init__(self, blocks: RemoteBlocks) -> None:
        self.blocks, self._place = blocks, 0
        self.failed: ArchiveError | None = None

    def __repr__(self) -> str:
        """Return the address, which HDF5 takes for the name of the file."""
        return self.blocks.where

    def readable(self) -> bool:
        """Return that it can be read."""
        return True

    def seekable(self) -> bool:
        """Return that any part can be read."""
        return True

    def tell(self) -> int:
        """Return the place that is read next."""
        return self._place

    def seek(self, offset: int, whence: int = SEEK_SET) -> int:
        """Go to a place."""
        self._place = offset + {SEEK_SET: 0, SEEK_CUR: self._place, SEEK_END: self.blocks.size}[whence]
        return self._place

    def readinto(self, into: "WriteableBuffer") -> int:
        """Read as many bytes as there is room for. Raises ``OSError`` where they cannot be fetched."""
        room = memoryview(into).cast("B")
        try:
            found = self.blocks.read_at(self._place, len(room))
        except ArchiveError as error:
            self.failed = self.failed or error
            raise OSError(errno.EIO, os.strerror(errno.EIO)) from error
        room[: len(found)] = found
        self._place += len(found)
        return len(found)
