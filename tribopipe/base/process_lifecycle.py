"""What a process takes from the environment it starts in, and what is undone where it is asked to end.

The command line then ends at once, without unwinding.

No exception is raised at an interrupt, for much of what runs below Python code swallows one or reports it itself: the
start of extension modules, SQLite's functions, callbacks of HDF5.

Nothing but the standard library's lightest modules is imported here, since the command looks after Ctrl-C before it
loads anything else.
"""

import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress

ONE_THREAD = {
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
    "VECLIB_MAXIMUM_THREADS": "1",
}
"""One thread for linear algebra, read as it is loaded: with more of them sums come out other in their last bits."""


@contextmanager
def inherited(variables: Mapping[str, str]) -> Iterator[None]:
    """Have processes that begin meanwhile find these variables; for this one they are afterwards as they were."""
    before = {name: os.environ[name] for name in variables if name in os.environ}
    os.environ.update(variables)
    try:
        yield
    finally:
        for name in variables:
            del os.environ[name]
        os.environ.update(before)


_unfinished: list[Callable[[], object]] = []


@contextmanager
def undone_by(undo: Callable[[], object]) -> Iterator[None]:
    """Have something undone where what follows fails, or the process is asked to end meanwhile."""
    _unfinished.append(undo)
    try:
        yield
    except BaseException:
        undo()
        raise
    finally:
        _unfinished.remove(undo)


def undone_at_end(undo: Callable[[], object]) -> None:
    """Have something undone if the process is asked to end; where it ends otherwise, it is undone elsewhere."""
    _unfinished.append(undo)


def undo_all() -> None:
    """Undo what was begun and is not finished, the last first."""
    for undo in reversed(_unfinished):
        with suppress(OSError):
            undo()
