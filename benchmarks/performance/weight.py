"""Peak memory of a work in a process of its own; Linux alone tells it, elsewhere nothing is said.

A work is done in a fork of this process, which has prepared it: what counts is the most it held while at work, and how
much more that is than it held before. A command has told it already, when it was timed.
"""

import multiprocessing
import re
import sys
from multiprocessing.connection import Connection
from pathlib import Path
from typing import NamedTuple

from case import Command, Work
from clock import Times

_STATUS, _FORGET = Path("/proc/self/status"), Path("/proc/self/clear_refs")
_FORGET_PEAK = "5"


class Weight(NamedTuple):
    """Peak memory, bytes."""

    whole: float
    """Of the process, its interpreter and libraries among it."""
    more: float
    """Beyond what it held before; of a command, which held nothing, all of it."""

    def __str__(self) -> str:
        """Say both in MB, or one where they are the same."""
        of_it = "" if self.more == self.whole else f" ({self.more / 1e6:.0f} MB increase)"
        return f"{self.whole / 1e6:.0f} MB{of_it}"


def weighed(work: Work, times: Times) -> Weight | None:
    """Return what a work that took these times holds at most; none where the system does not tell."""
    if times.peak is not None:
        return Weight(times.peak, times.peak)
    if sys.platform != "linux" or isinstance(work, Command):
        return None
    context = multiprocessing.get_context("fork")
    here, there = context.Pipe()
    process = context.Process(target=_weigh, args=(work, there))
    process.start()
    there.close()
    try:
        before, peak = here.recv()
    finally:
        process.join()
    return Weight(peak, peak - before)


def _weigh(work: Work, there: Connection) -> None:
    _FORGET.write_text(_FORGET_PEAK, encoding="ascii")
    before = _peak()
    work()
    there.send((before, _peak()))


def _peak() -> float:
    (held,) = re.findall(r"^VmHWM:\s*(\d+) kB$", _STATUS.read_text(encoding="ascii"), re.MULTILINE)
    return 1024.0 * float(held)
