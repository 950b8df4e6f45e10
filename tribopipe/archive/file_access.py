"""HDF5 files of the archive, opened for reading after all checks, and for writing to a disk that may be full.

A file is read once it is known to be whole and to hold nothing but what is ours.

``check_adopted`` looks through a file from elsewhere that is to take its place in the archive.

HDF5 2.0 ends the process with a segmentation fault where a write fails, as on a full disk. So it is made to see no
error, and the error is raised once it has closed the file.
"""

import errno
import json
import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from io import FileIO
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

import h5py
from pydantic import ValidationError

from tribopipe.archive import nexus
from tribopipe.archive.formats import FORMAT_TEXT, RUN_FORMAT, STUDY_FORMAT, Format, check_format, format_of
from tribopipe.archive.hdf5_guard import check_parts, own_datasets, was_looked_through
from tribopipe.archive.remote import readable
from tribopipe.archive.remote_blocks import BlockFile
from tribopipe.archive.seal import SEAL_SIZE, check_beginning, check_seal, is_sealed
from tribopipe.base.errors import ArchiveError
from tribopipe.base.failures import number_of, unreadable
from tribopipe.base.process_lifecycle import undone_by

if TYPE_CHECKING:
    from _typeshed import ReadableBuffer, WriteableBuffer


NOT_READ = (ArithmeticError, AttributeError, LookupError, MemoryError, OSError, RuntimeError, TypeError, ValueError)
"""Exceptions of reading a file whose content differs from what tribopipe writes."""
_LONGEST = 300
"""Characters of what is stated about it."""


@contextmanager
def opened(path: Path, parts: Sequence[str] | None = None) -> Iterator[h5py.File]:
    """Open a file of the archive for reading.

    It is looked through before; where no more than some datasets are wanted, these alone are looked at.

    Raises ``ArchiveError`` where a byte of it is not as it was written, it has no seal, it holds what tribopipe never
    writes, or it cannot be read.
    """
    source = readable(path)
    try:
        sealed = _check_beginning(path, source) if isinstance(source, BlockFile) else _check_whole(path)
        file = h5py.File(source, "r", locking=False)
    except OSError as error:
        raise _fetching_failed(source) or ArchiveError(f"{path}: {_why_not_opened(error)}") from error
    with file:
        try:
            if not was_looked_through(file):
                check_parts(file, [FORMAT_TEXT, *(parts or ())])
                if parts is None and format_of(file) is not None:
                    own_datasets(file)
            if not sealed:
                _refuse_unsealed(file, path)
            yield file
        except NOT_READ as error:
            if failed := _fetching_failed(source):
                raise failed from error
            if number := number_of(error):
                raise ArchiveError(f"{path}: {unreadable(number)}") from error
            raise ArchiveError(
                f"{path}: found a damaged file ({_why(error)}); expected an unmodified tribopipe file; restore it "
                "from a backup"
            ) from error


def _check_whole(path: Path) -> bool:
    """Check every byte of a sealed file; return whether it is one."""
    if sealed := is_sealed(path):
        check_seal(path)
    return sealed


def _check_beginning(path: Path, source: BlockFile) -> bool:
    """Check the length of a file that is read in blocks; return whether it is sealed."""
    return check_beginning(path, source.blocks.read_at(0, 2 * SEAL_SIZE), source.blocks.size)


def _fetching_failed(source: Path | BlockFile) -> ArchiveError | None:
    return source.failed if isinstance(source, BlockFile) else None


def _why(error: Exception) -> str:
    """State in a line what could not be read, and of a record which of its fields."""
    if isinstance(error, ValidationError):
        first = error.errors(include_url=False)[0]
        return f"{'.'.join(map(str, first['loc']))}: {first['msg']}".removeprefix(": ")[:_LONGEST]
    return (str(error).splitlines() or [type(error).__name__])[0][:_LONGEST]


def _why_not_opened(error: OSError) -> str:
    if number := number_of(error):
        return unreadable(number)
    return (
        "found a file that is damaged or not HDF5; expected a file archived by tribopipe; restore it from a "
        "backup, or move it out of the archive"
    )


def _refuse_unsealed(file: h5py.File, path: Path) -> NoReturn:
    """Report what a file without a seal is: one of an earlier format, one that lost it, or a foreign one."""
    found = format_of(file)
    check_format(file, path, STUDY_FORMAT if found is not None and found.kind == STUDY_FORMAT.kind else RUN_FORMAT)
    raise ArchiveError(
        f"{path}: found no seal (file checksum), possibly because another program rewrote the file; expected an "
        "unmodified tribopipe file; restore it from a backup, or save its intact source files with `tribopipe rescue`"
    )


def check_adopted(part: Path, path: Path, form: Format) -> None:
    """Look through a file that is to have the name ``path``.

    Raises ``ArchiveError`` where it is damaged, hostile, of another format, or not the run or study of that name.
    """
    try:
        with opened(part) as file:
            check_format(file, path, form)
            document = "study" if form == STUDY_FORMAT else "manifest"
            held = json.loads(nexus.text(file, f"entry/{document}/data"))["id"]
    except ArchiveError as error:
        said = str(error).replace(str(part), path.name)
        raise ArchiveError(f"{path}: cannot be added to the archive; {said}") from None
    if held != path.stem:
        raise ArchiveError(
            f"{path}: found the ID {held!r} in the file; expected {path.stem!r}, as in the file name; rename the "
            "file, and import it only if you trust its source"
        )


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
