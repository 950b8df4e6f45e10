"""Errors as one sentence each; the traceback of an unexpected error is saved in a file, to be reported.

It is kept at once, since a batch of hours may not run into the same again, and outside the archive, which may be what
is full.
"""

import errno
import os
import platform
import re
import sys
import tempfile
import traceback
from functools import cache
from pathlib import Path

from tribopipe.base.errors import InternalError, TribopipeError
from tribopipe.version import VERSION

_MENDED_BY = {
    errno.ENOSPC: "free space on the disk",
    errno.EDQUOT: "free space, or have the quota raised",
    errno.EACCES: "check its permissions",
    errno.EPERM: "check its permissions",
    errno.EROFS: "choose a writable folder",
    errno.ENOENT: "check whether it was moved or its drive is disconnected",
    errno.ENOTDIR: "check whether it was moved or its drive is disconnected",
    errno.EIO: "check its drive or network share",
    errno.ESTALE: "reconnect its network share",
    errno.EMFILE: "close files, or raise the limit of open files",
    errno.ENFILE: "close other programs",
    errno.ENOMEM: "close other programs",
}


_HIDDEN = re.compile(r"\berrno = (\d{1,4})\b")
_NOT_GIVEN = re.compile(r"\bfile (?:read|open) failed\b")


def number_of(error: BaseException) -> int:
    """Return the number of the system's error by which something failed; 0 where it failed otherwise.

    HDF5 hides it in a text, which h5py gives to whatever kind of exception it raises.
    """
    if isinstance(error, MemoryError):
        return errno.ENOMEM
    if isinstance(error, OSError) and error.errno:
        return error.errno
    said = str(error)
    hidden = _HIDDEN.search(said)
    return int(hidden[1]) if hidden else errno.EIO if _NOT_GIVEN.search(said) else 0


def unreadable(number: int) -> str:
    """Report for a file that the system does not read: nothing is known of what it holds."""
    return f"cannot be read ({os.strerror(number)}); expected a readable file; {mended_by(number)}"


def mended_by(number: int) -> str:
    """Report what to do about an error of the system, given by its number."""
    return _MENDED_BY.get(number, "check it")


def in_a_sentence(error: Exception, where: str = "") -> TribopipeError:
    """Return an error as people read it; ``where`` names what was being done, unless the error does."""
    if isinstance(error, TribopipeError):
        return error
    if isinstance(error, OSError):
        place, why = error.filename or where, error.strerror or error
        return TribopipeError(
            f"{_before(place)}cannot be read or written ({why}); expected read and write access; "
            f"{mended_by(error.errno or 0)}"
        )
    if isinstance(error, MemoryError):
        return TribopipeError(
            f"{_before(where)}found too little memory; expected enough memory for all samples of a run; close other "
            "programs, or split the run"
        )
    return InternalError(
        f"{_before(where)}found a bug in tribopipe ({type(error).__name__}: {_first_line(error)}); expected no "
        f"exception; please report it{_kept(error)}"
    )


def _before(place: object) -> str:
    return f"{place}: " if place else ""


def _first_line(error: Exception) -> str:
    return next(iter(str(error).splitlines()), "")


def _kept(error: Exception) -> str:
    """Add a traceback to those of this process, and report where they are."""
    try:
        path = _file()
        with path.open("a", encoding="utf-8", errors="backslashreplace") as file:
            file.writelines(traceback.format_exception(error))
    except OSError as why:
        return f"; its traceback could not be saved ({why.strerror})"
    return f" with the file {path}, which contains the traceback"


@cache
def _file() -> Path:
    """Begin the file of this process; it shows what was run."""
    with tempfile.NamedTemporaryFile(
        "w", prefix="tribopipe-fault-", suffix=".txt", delete=False, encoding="utf-8", errors="backslashreplace"
    ) as file:
        file.write(f"tribopipe {VERSION}, Python {platform.python_version()}, {platform.platform()}\n{sys.argv}\n\n")
    return Path(file.name)
