"""What is undone where the process is asked to end: the command line then ends at once, without unwinding.

No exception is raised at an interrupt, for much of what runs below Python code swallows one or reports it itself: the
start of extension modules, SQLite's functions, callbacks of HDF5.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress

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


def undo_all() -> None:
    """Undo what was begun and is not finished, the last first."""
    for undo in reversed(_unfinished):
        with suppress(OSError):
            undo()
