"""Run a program next to this file within bounds. Arguments: bytes of memory, seconds of work, program, and its own.

What the system holds us to already stays as it is where it is less, as on nodes of a cluster. macOS bounds no memory
and Windows nothing: there a thread watches how much memory was taken, and the clock of whoever waits bounds the work.
"""

import os
import runpy
import sys
import threading
import time
from contextlib import suppress
from pathlib import Path

_LOOK_EVERY = 0.05
"""s."""
_TOO_MUCH = 3
"""Exit code of a process that took too much memory."""


def main() -> None:
    """Bound this process, and be the program."""
    memory, seconds, program, *arguments = sys.argv[1:]
    if sys.platform != "win32":
        import resource

        _bound(resource.RLIMIT_AS, int(memory))
        _bound(resource.RLIMIT_CPU, int(seconds))
    if sys.platform in ("darwin", "win32"):
        watch_memory(int(memory))
    sys.argv = [program, *arguments]
    runpy.run_path(str(Path(__file__).with_name(program)), run_name="__main__")


def watch_memory(most: int) -> None:
    """End this process soon after it has taken more bytes of memory at once."""

    def watch() -> None:
        while peak_memory() <= most:
            time.sleep(_LOOK_EVERY)
        os._exit(_TOO_MUCH)

    threading.Thread(target=watch, daemon=True).start()


def peak_memory() -> int:
    """Return the most memory that this process has held at once, bytes."""
    if sys.platform == "win32":
        return _windows_peak()
    import resource

    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == "darwin" else 1024)


def _windows_peak() -> int:
    """Return PeakWorkingSetSize of PROCESS_MEMORY_COUNTERS (Windows API, psapi.h)."""
    import ctypes

    sizes = ("PeakWorkingSetSize", "WorkingSetSize", "QuotaPeakPagedPoolUsage", "QuotaPagedPoolUsage")
    more = ("QuotaPeakNonPagedPoolUsage", "QuotaNonPagedPoolUsage", "PagefileUsage", "PeakPagefileUsage")
    fields = [("cb", ctypes.c_uint32), ("PageFaultCount", ctypes.c_uint32)]
    counters = type(
        "Counters", (ctypes.Structure,), {"_fields_": fields + [(name, ctypes.c_size_t) for name in (*sizes, *more)]}
    )()
    counters.cb = ctypes.sizeof(counters)
    kernel = ctypes.windll.kernel32  # type: ignore[attr-defined]
    kernel.GetCurrentProcess.restype = ctypes.c_void_p
    kernel.K32GetProcessMemoryInfo.argtypes = (ctypes.c_void_p, ctypes.c_void_p, ctypes.c_uint32)
    kernel.K32GetProcessMemoryInfo(kernel.GetCurrentProcess(), ctypes.byref(counters), counters.cb)
    return int(counters.PeakWorkingSetSize)


def _bound(which: int, most: int) -> None:
    import resource

    held = [limit for limit in resource.getrlimit(which) if limit != resource.RLIM_INFINITY]
    least = min([most, *held])
    with suppress(ValueError, OSError):
        resource.setrlimit(which, (least, least))


if __name__ == "__main__":
    main()
