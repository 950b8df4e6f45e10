"""Processes that begin with everything imported, so that a killed one has cost its work and no more. POSIX only."""

import os
import signal
import sys
import traceback
from collections.abc import Callable
from pathlib import Path

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before numpy: what has threads cannot be forked


def forked(work: Callable[[], object], said: Path) -> int:
    """Do some work in a process of its own, which writes what it says to a file; return its number."""
    sys.stdout.flush()
    sys.stderr.flush()
    child = os.fork()
    if child:
        return child
    code = 1
    try:
        handle = os.open(said, os.O_WRONLY | os.O_CREAT | os.O_APPEND)
        os.dup2(handle, 1)
        os.dup2(handle, 2)
        # What stood there before may lead elsewhere: whoever called may be catching what is said.
        sys.stdout = open(1, "w", encoding="utf-8", closefd=False)  # noqa: SIM115
        sys.stderr = open(2, "w", encoding="utf-8", closefd=False)  # noqa: SIM115
        work()
        code = 0
    except SystemExit as ending:
        code = int(ending.code or 0)
    except BaseException:  # noqa: BLE001 - nothing may get out of the child
        traceback.print_exc()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)


def ended(child: int) -> int:
    """Wait for a process of ours; return its exit code, less than zero where a signal ended it."""
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


def has_ended(child: int) -> bool:
    """Tell whether a process of ours has ended; it is asked for no more then."""
    return os.waitpid(child, os.WNOHANG)[0] == child


def killed(child: int) -> bool:
    """Kill a process of ours; tell whether that ended it, rather than it having ended before."""
    os.kill(child, signal.SIGKILL)
    return ended(child) == -signal.SIGKILL


def command(*words: object) -> Callable[[], None]:
    """Return what runs `tribopipe` with these words, as its console script does."""

    def run() -> None:
        from tribopipe.cli.app import main

        sys.argv = ["tribopipe", *map(str, words)]
        main()

    return run
