"""Listing an archive of thousands of runs beside `tribopipe --version`, the least a command could take.

    python benchmarks/catalogue.py --write docs/results/catalogue.md

The mark to hold: `tribopipe ls` takes less than 1.5 times as long as `tribopipe --version` plus 0.5 s. Wall times are
medians over alternating runs in the order of the table, but for the first listing, which happens once.
"""

import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from labs import Report, arguments
from many_runs import many_runs

REPEATS = 7
COMMAND = Path(sys.executable).with_name("tribopipe.exe" if sys.platform == "win32" else "tribopipe")
QUERY = "material=Si3N4 load>300mN k_d<1e-8"


def wall_time(*words: str) -> float:
    """Run tribopipe and return how long it took, s."""
    start = time.perf_counter()
    subprocess.run([str(COMMAND), *words], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return time.perf_counter() - start


def age(folder: Path) -> None:
    """Give files the times of an archive that nobody has written to for an hour."""
    then = time.time() - 3600
    for path in folder.glob("*.h5"):
        os.utime(path, (then, then))


def main() -> None:
    """Make the archive, time the commands in turn, and hold them against the mark."""
    parser = arguments(__doc__ or "")
    parser.add_argument("--runs", type=int, default=5000, help="number of runs (%(default)s)")
    options = parser.parse_args()
    report = Report("Listing a large archive", options)
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch) / "archive"
        many_runs(folder, options.runs)
        age(folder)
        time.sleep(2.5)
        first = wall_time("ls", "--archive", str(folder))
        cases = {
            "`tribopipe --version`": ["--version"],
            "`tribopipe ls`": ["ls", "--archive", str(folder)],
            f'`tribopipe ls --where "{QUERY}" --sort -k_d`': [
                *("ls", "--archive", str(folder), "--where", QUERY, "--sort", "-k_d")
            ],
            "`tribopipe ls --json`": ["ls", "--archive", str(folder), "--json"],
        }
        times: dict[str, list[float]] = {name: [] for name in cases}
        for _ in range(REPEATS):
            for name, words in cases.items():
                times[name].append(wall_time(*words))
    medians = {name: statistics.median(taken) for name, taken in times.items()}
    once, listing, *_ = medians.values()
    mark = 1.5 * once + 0.5
    report.say(
        f"The archive contains {options.runs:,} runs. Each run is read once; after that, files that have not changed "
        "are not opened again."
    )
    rows = [[name, f"{median:.2f} s"] for name, median in medians.items()]
    each = f"first `tribopipe ls`, {first / options.runs * 1e3:.1f} ms per run"
    report.table(["Command", "Wall time"], [*rows, [each, f"{first:.1f} s"]])
    met = "met" if listing < mark else "NOT MET"
    report.say(f"Limit for `tribopipe ls`: {mark:.2f} s ({met}).")
    report.finish()


if __name__ == "__main__":
    main()
