"""Run a program beside this file within bounds. Arguments: bytes of memory, seconds of work, program, and its own.

What the system holds us to already stays as it is where it is less, as on nodes of a cluster. macOS bounds no memory,
Windows nothing: there the clock of whoever waits is the bound.
"""

import runpy
import sys
from contextlib import suppress
from pathlib import Path


def main() -> None:
    """Bound this process, and be the program."""
    memory, seconds, program, *arguments = sys.argv[1:]
    if sys.platform != "win32":
        import resource

        _bound(resource.RLIMIT_AS, int(memory))
        _bound(resource.RLIMIT_CPU, int(seconds))
    sys.argv = [program, *arguments]
    runpy.run_path(str(Path(__file__).with_name(program)), run_name="__main__")


def _bound(which: int, most: int) -> None:
    import resource

    held = [limit for limit in resource.getrlimit(which) if limit != resource.RLIM_INFINITY]
    least = min([most, *held])
    with suppress(ValueError, OSError):
        resource.setrlimit(which, (least, least))


if __name__ == "__main__":
    main()
