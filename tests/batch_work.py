"""Tasks for batches, which workers can import."""

import os
import signal
import time
from pathlib import Path

from tribopipe.base.errors import FitError


def squared(number: int) -> int:
    return number * number


def refuse_three(number: int) -> int:
    if number == 3:
        raise FitError("three: found 3; expected another number")
    if number == 5:
        raise ZeroDivisionError("five\nand more")
    return number


def linear_algebra_threads(_: int) -> str | None:
    return os.environ.get("OPENBLAS_NUM_THREADS")


def killed_at(number: int, bad: int) -> int:
    """Kill the worker over one of the tasks, whoever does it."""
    if number == bad:
        kill_this_process()
    return number


def killed_once(marker: Path) -> str:
    """Kill the worker that does it first."""
    if not marker.exists():
        marker.touch()
        kill_this_process()
    return marker.name


def kill_this_process() -> None:
    os.kill(os.getpid(), signal.SIGKILL if hasattr(signal, "SIGKILL") else signal.SIGTERM)


def process_number(_: int) -> int:
    time.sleep(0.05)
    return os.getpid()


def written_for_ever(path: Path) -> None:
    """Write a file that is never ready."""
    from tribopipe.base.files import replacing

    with replacing(path):
        path.with_suffix(".begun").touch()
        time.sleep(60)
