"""An HDF5 file written to a disk that may be full.

HDF5 2.0 ends the process with a segmentation fault where a write fails. So it is made to see no error, and the error
is raised once it has closed the file.
"""

import errno
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from io import FileIO
from pathlib import Path
from typing import TYPE_CHECKING

import h5py

from tribopipe.base.interrupts import undone_by

if TYPE_CHECKING:
    from _typeshed import ReadableBuffer, WriteableBuffer


@contextmanager
def written(path: Path, userblock_size: int) -> Iterator[h5py.File]:
    """Give an empty HDF5 file in the place of another file, written to the disk as it grows.

    Raises the first ``OSError`` that the disk gave, in the place of all that came of it.
    """
    with LateErrors(path, "w+") as image, undone_by(image.close):  # Windows removes no file that is open
        try:
            with h5py.File(image, "w", track_order=True, userblock_size=userblock_size) as file:
                yield file
        finally:
            if image.failed is not None:
                raise image.failed from None


class LateErrors(FileIO):
    """A file that keeps its first error to itself. From then on it takes all and writes nothing, and holds zeros."""

    failed: OSError | None = None

    def write(self, content: "ReadableBuffer") -> int:
        """Write all of the content."""
        whole = memoryview(content).cast("B")
        self._tried(lambda: self.write_all(whole))
        return len(whole)

    def write_all(self, content: memoryview) -> None:
        """Write all of the content, which the system may take in parts. Raises ``OSError`` where it does not."""
        while content:
            taken = super().write(content)
            if not taken:
                raise OSError(errno.EIO, os.strerror(errno.EIO))
            content = content[taken:]

    def readinto(self, into: "WriteableBuffer") -> int:
        """Read as many bytes as there is room for."""
        whole = memoryview(into).cast("B")
        found = self._tried(lambda: super(LateErrors, self).readinto(whole)) or 0
        whole[found:] = bytes(len(whole) - found)
        return len(whole)

    def truncate(self, size: int | None = None) -> int:
        """Cut the file off, or lengthen it."""
        return self._tried(lambda: super(LateErrors, self).truncate(size)) or size or 0

    def _tried(self, act: Callable[[], int | None]) -> int | None:
        """Return what a call of the system does; nothing where it fails, or one before it did."""
        if self.failed is not None:
            return None
        try:
            return act()
        except OSError as error:
            self.failed = error
            return None
