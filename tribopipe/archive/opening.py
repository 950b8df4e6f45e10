"""Files of the archive opened for reading, once they are known to be whole and to hold nothing but what is ours."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import NoReturn

import h5py
from pydantic import ValidationError

from tribopipe.archive.formats import FORMAT_TEXT, RUN_FORMAT, STUDY_FORMAT, check_format, format_of
from tribopipe.archive.hdf5_guard import check_parts, own_datasets, was_looked_through
from tribopipe.archive.seal import check_seal, is_sealed
from tribopipe.base.errors import ArchiveError
from tribopipe.base.failures import number_of, unreadable

_DAMAGED = (ArithmeticError, AttributeError, LookupError, MemoryError, OSError, RuntimeError, TypeError, ValueError)
"""What reading raises where a file holds something else than tribopipe writes."""
_LONGEST = 300
"""Characters of what is stated about it."""


@contextmanager
def opened(path: Path, parts: Sequence[str] | None = None) -> Iterator[h5py.File]:
    """Open a file of the archive for reading.

    It is looked through before; where no more than some datasets are wanted, these alone are looked at.

    Raises ``ArchiveError`` where a byte of it is not as it was written, it has no seal, it holds what tribopipe never
    writes, or it cannot be read.
    """
    try:
        if is_sealed(path):
            check_seal(path)
        file = h5py.File(path, "r", locking=False)
    except OSError as error:
        raise ArchiveError(f"{path}: {_why_not_opened(error)}") from error
    with file:
        try:
            if not was_looked_through(file):
                check_parts(file, [FORMAT_TEXT, *(parts or ())])
                if parts is None and format_of(file) is not None:
                    own_datasets(file)
            if not is_sealed(path):
                _refuse_unsealed(file, path)
            yield file
        except _DAMAGED as error:
            if number := number_of(error):
                raise ArchiveError(f"{path}: {unreadable(number)}") from error
            raise ArchiveError(
                f"{path}: found a damaged file ({_why(error)}); expected what tribopipe wrote; restore it from a copy"
            ) from error


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
        "found a file that is not HDF5, or is damaged; expected one archived by tribopipe; restore it from a copy, or "
        "move it out of the archive"
    )


def _refuse_unsealed(file: h5py.File, path: Path) -> NoReturn:
    """Report what a file without a seal is: one of an earlier format, one that lost it, or a foreign one."""
    found = format_of(file)
    check_format(file, path, STUDY_FORMAT if found is not None and found.kind == STUDY_FORMAT.kind else RUN_FORMAT)
    raise ArchiveError(
        f"{path}: found no seal at its start, as if another program had rewritten it; expected the file as "
        "tribopipe wrote it; restore it from a copy, or save what is whole in it with `tribopipe rescue`"
    )
