"""Files of the archive opened for reading, once they are known to be whole and to hold nothing but what is ours."""

import errno
import os
import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import NoReturn

import h5py
from pydantic import ValidationError

from tribopipe.archive.formats import FORMAT_TEXT, RUN_FORMAT, STUDY_FORMAT, check_format, format_of
from tribopipe.archive.own_content import check_parts, own_datasets, was_looked_through
from tribopipe.archive.seal import check_seal, is_sealed
from tribopipe.errors import ArchiveError
from tribopipe.faults import mended_by

_DAMAGED = (ArithmeticError, AttributeError, LookupError, MemoryError, OSError, RuntimeError, TypeError, ValueError)
"""What reading raises where a file holds something else than tribopipe writes."""
_HIDDEN = re.compile(r"\berrno = (\d{1,4})\b")
_LONGEST = 300
"""Characters of what is said of it."""


@contextmanager
def opened(path: Path, parts: Sequence[str] | None = None) -> Iterator[h5py.File]:
    """Open a file of the archive for reading, all of it or some datasets alone.

    Raises ``ArchiveError`` where a byte of it is not as it was written, it has no seal, or it cannot be read.
    """
    with of_any_format(path, parts) as file:
        if not is_sealed(path):
            _refuse_unsealed(file, path)
        yield file


@contextmanager
def of_any_format(path: Path, parts: Sequence[str] | None = None) -> Iterator[h5py.File]:
    """Open a file for reading that may be of a format without a seal.

    One of ours is looked through before; where no more than some datasets are wanted, these alone are looked at.

    Raises ``ArchiveError`` where a byte of a sealed file is not as it was written, it holds what tribopipe never
    writes, or it cannot be read.
    """
    try:
        if is_sealed(path):
            check_seal(path)
        file = h5py.File(path, "r", locking=False)
    except OSError as error:
        raise ArchiveError(f"{path}: {_why_not_opened(error)}") from None
    with file:
        try:
            if not was_looked_through(file):
                check_parts(file, [FORMAT_TEXT, *(parts or ())])
                if parts is None and format_of(file) is not None:
                    own_datasets(file)
            yield file
        except _DAMAGED as error:
            if number := _of_the_system(error):
                raise ArchiveError(f"{path}: {_unreadable(number)}") from error
            raise ArchiveError(
                f"{path}: found a damaged file ({_why(error)}); expected what tribopipe wrote; restore it from a copy"
            ) from error


def _of_the_system(error: Exception) -> int:
    """Return the number of the system's error where reading failed by it, not by the file; HDF5 hides it in a text."""
    if isinstance(error, MemoryError):
        return errno.ENOMEM
    if not isinstance(error, OSError):
        return 0
    hidden = _HIDDEN.search(str(error))
    return error.errno or (int(hidden[1]) if hidden else 0)


def _unreadable(number: int) -> str:
    return f"cannot be read ({os.strerror(number)}); expected a file that can be; {mended_by(number)}"


def _why(error: Exception) -> str:
    """Say in a line what could not be read, and of a record which of its fields."""
    if isinstance(error, ValidationError):
        first = error.errors(include_url=False)[0]
        return f"{'.'.join(map(str, first['loc']))}: {first['msg']}".removeprefix(": ")[:_LONGEST]
    return (str(error).splitlines() or [type(error).__name__])[0][:_LONGEST]


def _why_not_opened(error: OSError) -> str:
    if number := _of_the_system(error):
        return _unreadable(number)
    return (
        "found a file that is not HDF5, or is damaged; expected one archived by tribopipe; restore it from a copy, or "
        "move it out of the archive"
    )


def _refuse_unsealed(file: h5py.File, path: Path) -> NoReturn:
    """Say what a file without a seal is: one of an older format, one that lost it, or none of ours."""
    found = format_of(file)
    check_format(file, path, STUDY_FORMAT if found is not None and found.kind == STUDY_FORMAT.kind else RUN_FORMAT)
    raise ArchiveError(
        f"{path}: found no seal in front of it, as if another program had written it anew; expected the file as "
        "tribopipe wrote it; restore it from a copy, or save what is whole in it with `tribopipe rescue`"
    )
