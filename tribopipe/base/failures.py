"""Whatever goes wrong as one sentence; the traceback of what nobody foresaw is kept in a file, to be reported.

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
    errno.ENOSPC: "make room on the disk",
    errno.EDQUOT: "make room, or have the quota raised",
    errno.EACCES: "see to its permissions",
    errno.EPERM: "see to its permissions",
    errno.EROFS: "choose a folder that can be written",
    errno.ENOENT: "see whether it was moved, or its drive is gone",
    errno.ENOTDIR: "see whether it was moved, or its drive is gone",
    errno.EIO: "see whether its drive or share is sound",
    errno.ESTALE: "reconnect its network share",
    errno.EMFILE: "close files, or raise the limit of open ones",
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
    return f"cannot be read ({os.strerror(number)}); expected a file that can be; {mended_by(number)}"


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
            f"{_before(place)}cannot be read or written ({why}); expected it to be; {mended_by(error.errno or 0)}"
        )
    if isinstance(error, MemoryError):
        return TribopipeError(
            f"{_before(where)}found too little memory; expected enough for all samples of a run; close other programs, "
            "or split the run"
        )
    return InternalError(
        f"{_before(where)}found a fault of tribopipe itself ({type(error).__name__}: {_first_line(error)}); expected "
        f"none, whatever the run; please report it{_kept(error)}"
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
        return f"; its traceback could not be kept ({why.strerror})"
    return f" with the file {path}, which holds its traceback"


@cache
def _file() -> Path:
    """Begin the file of this process; it shows what was run."""
    with tempfile.NamedTemporaryFile(
        "w", prefix="tribopipe-fault-", suffix=".txt", delete=False, encoding="utf-8", errors="backslashreplace"
    ) as file:
        file.write(f"tribopipe {VERSION}, Python {platform.python_version()}, {platform.platform()}\n{sys.argv}\n\n")
    return Path(file.name)
