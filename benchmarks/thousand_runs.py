"""A thousand runs through `process -j 2`: all archived and sound, and memory as flat at the end as at the beginning.

    python benchmarks/thousand_runs.py --runs 1000

The memory of the command and of its workers together (resident, summed) is looked at ten times a second. Asked is that
its peak while the last hundred runs are archived is at most 1.1 times that of the first hundred, likewise while figures
are drawn, that all runs are archived, and that the archive verifies. Exits with 1 where that does not hold, of memory
from 400 runs on. Linux only.
"""

import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import psutil
from labs import Report, arguments

sys.path.append(str(Path(__file__).parent / "reliability"))

from short_runs import quick_recipe, short_runs

COMMAND = Path(sys.executable).with_name("tribopipe")
_LOOK_EVERY = 0.1
_MOST = 1.1
_MANY = 400
"""Runs from which on the memory of the last part of them tells of growth."""


class Look(NamedTuple):
    """What was seen at a moment."""

    archived: int
    """Runs."""
    drawn: int
    """Runs whose figure of wear is drawn."""
    memory: float
    """Of all processes, bytes."""


def processed(folder: Path, words: Sequence[str]) -> tuple[int, list[Look]]:
    """Process the runs of a folder; return the exit code and what was seen meanwhile."""
    archive, looks = folder / "archive", []
    command = [str(COMMAND), "process", str(folder / "runs"), "--archive", str(archive), *words]
    quiet = subprocess.DEVNULL
    with subprocess.Popen(command, stdout=quiet, stderr=quiet, start_new_session=True) as begun:
        while begun.poll() is None:
            drawn = _count(archive / "figures", "*-wear.png")
            looks.append(Look(_count(archive, "*.h5"), drawn, memory_of(begun.pid)))
            time.sleep(_LOOK_EVERY)
    return begun.returncode, looks


def memory_of(number: int) -> float:
    """Return the memory of a process and those that it began, bytes."""
    try:
        begun = psutil.Process(number)
        return float(sum(one.memory_info().rss for one in (begun, *begun.children(recursive=True))))
    except psutil.Error:  # one of them has just ended
        return 0.0


def _count(folder: Path, pattern: str) -> int:
    return sum(1 for _ in folder.glob(pattern))


def peaks(looks: Sequence[tuple[int, float]], runs: int) -> tuple[float, float]:
    """Return the peak memory while the first hundred runs were done and while the last were, of looks at both."""
    part = min(100, runs // 2)
    under_way = [(done, memory) for done, memory in looks if 0 < done < runs]
    first = max(memory for done, memory in under_way if done <= part)
    return first, max(memory for done, memory in under_way if done >= runs - part)


def main() -> int:
    """Process the runs, and tell what came of it; 1 where it is not all that is asked."""
    parser = arguments(__doc__ or "")
    parser.add_argument("--runs", type=int, default=1000, help="how many runs (%(default)s)")
    parser.add_argument("-j", "--jobs", type=int, default=2, help="processes (%(default)s)")
    options = parser.parse_args()
    report = Report("A thousand runs", options)
    with tempfile.TemporaryDirectory() as scratch:
        folder, start = Path(scratch), time.monotonic()
        short_runs(folder / "runs", options.runs)
        code, looks = processed(folder, ["-j", str(options.jobs), "--recipe", str(quick_recipe(folder))])
        seconds, archived = time.monotonic() - start, _count(folder / "archive", "*.h5")
        verify = subprocess.run([COMMAND, "verify", "--archive", folder / "archive"], capture_output=True, check=False)
    rows, flat = [], True
    for what, seen in (
        ("archiving", [(look.archived, look.memory) for look in looks]),
        ("figures", [(look.drawn, look.memory) for look in looks]),
    ):
        first, last = peaks(seen, options.runs)
        rows.append([what, f"{first / 1e6:.0f} MB", f"{last / 1e6:.0f} MB", f"{last / first:.3f}"])
        flat = flat and last / first <= _MOST
    report.table(["Step", "Peak memory, first hundred runs", "Peak memory, last hundred runs", "Ratio"], rows)
    found = "found no problems" if verify.returncode == 0 else "FOUND PROBLEMS"
    report.say(
        f"{options.jobs} workers archived {archived} of {options.runs} runs of 126 samples in {seconds:.0f} s (exit "
        f"code {code}); `tribopipe verify` {found}. The memory is that of the command and its workers together; the "
        f"ratio must not exceed {_MOST}."
    )
    report.finish()
    holds = code == 0 and archived == options.runs and verify.returncode == 0
    return 0 if holds and (flat or options.runs < _MANY) else 1


if __name__ == "__main__":
    sys.exit(main())
