"""A command in a process of its own, and what it took."""

import json
import subprocess
import sys
from collections.abc import Sequence
from typing import NamedTuple


class Taken(NamedTuple):
    """What a command took."""

    seconds: float
    peak: float | None
    """Resident memory, bytes, the largest of those of its processes; none where the system does not tell."""


_RUN = """
import json, subprocess, sys, time
begun = time.perf_counter()
subprocess.run(sys.argv[1:], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
seconds, peak = time.perf_counter() - begun, None
if sys.platform == "linux":
    import resource
    peak = 1024 * resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
print(json.dumps([seconds, peak]))
"""


def taken(words: Sequence[str]) -> Taken:
    """Run a command, its output thrown away. Raises ``CalledProcessError`` where it fails.

    It is started by an interpreter that holds next to nothing, since a process inherits the peak of the one that
    started it.
    """
    said = subprocess.run([sys.executable, "-ISc", _RUN, *words], check=True, capture_output=True, text=True)
    return Taken(*json.loads(said.stdout))
