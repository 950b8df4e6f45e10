"""Listing and browsing an archive of 100,000 runs beside one of 10,000, and adding a run to it beside one of 1,000.

    python benchmarks/large_catalog.py --write docs/results/large_catalog.md

The archives are those of large_archive.py. The marks to hold: a query for a few dozen runs and the first part of the
table in the browser take at most 2 times as long with 100,000 runs as with 10,000; `tribopipe ingest` takes at most 1.2
times as long with 100,000 runs as with 1,000. Times are processor times, user and system, the least of several, so that
other programs do not matter; Linux and macOS only. Exits with 1 where a mark is not held.
"""

import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

from catalogue import COMMAND
from labs import Report, arguments
from large_archive import large_archive

from tribopipe.archive.catalog.query import Asked
from tribopipe.browse.library import FIRST_ROWS, Library

sys.path.append(str(Path(__file__).parent / "reliability"))

from short_runs import short_runs

REPEATS = 3
MATCHES = 40
"""Runs that the query finds."""
_SETTLED = 2.5
"""Time after which a folder is trusted not to change unnoticed, s."""
_MOST, _MOST_ADDED = 2.0, 1.2


def command_time(*words: str) -> float:
    """Run tribopipe and return its processor time, s."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([str(COMMAND), *words], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def least(measure: Callable[[], float]) -> float:
    """Return the least of several times, s."""
    return min(measure() for _ in range(REPEATS))


def answer_time(folder: Path) -> float:
    """Return the processor time of the first part of the table, with the revision of the archive, s."""
    library = Library(folder)
    library.runs(Asked(), most=1)  # opens the catalog and looks at the files, as the server does when it starts
    start = time.process_time()
    library.runs(Asked(), most=FIRST_ROWS)
    return time.process_time() - start


def added(folder: Path, run: Path) -> tuple[float, float]:
    """Add a run to an archive and ask for it; return both times, s."""
    ingested = command_time("ingest", str(run), "--archive", str(folder))
    listed = command_time("ls", "--archive", str(folder), "--where", f"id={run.name}")
    (folder / f"{run.name}.h5").unlink()
    return ingested, listed


def main() -> int:
    """Make the archives, time what is done with them, and hold the times against the marks; 1 where one is missed."""
    parser = arguments(__doc__ or "")
    parser.add_argument("--sizes", type=int, nargs=3, default=[1000, 10_000, 100_000], help="numbers of runs")
    options = parser.parse_args()
    report = Report("An archive of 100,000 runs", options)
    rows: dict[int, list[float]] = {}
    with tempfile.TemporaryDirectory() as scratch:
        short_runs(Path(scratch) / "runs", 2)
        first, run = sorted((Path(scratch) / "runs").iterdir())
        for size in options.sizes:
            folder = Path(scratch) / f"{size}"
            coefficients = large_archive(folder, size)
            limit = coefficients[min(MATCHES, len(coefficients) - 1)] * 1e6
            where = f"material=Si3N4 load>300mN k_d<{limit:.9g}"
            added(folder, first)  # begins the history
            time.sleep(_SETTLED)
            for _ in range(2):  # forgets the run, then looks at everything once more
                command_time("ls", "--archive", str(folder))
                time.sleep(_SETTLED)
            ls = ["ls", "--archive", str(folder), "--where", where]
            query, table = least(partial(command_time, *ls)), least(partial(answer_time, folder))
            both = [added(folder, run) for _ in range(REPEATS)]
            rows[size] = [query, table, min(one for one, _ in both), min(one for _, one in both)]
    small, medium, large = (rows[size] for size in options.sizes)
    marks = [(large[0] / medium[0], _MOST), (large[1] / medium[1], _MOST), (large[2] / small[2], _MOST_ADDED)]
    names = (
        f"`tribopipe ls --where` of about {MATCHES} runs",
        f"first {FIRST_ROWS} rows of the table in the browser",
        "`tribopipe ingest` of a run",
        "`tribopipe ls --where` of this run after that",
    )
    report.table(
        ["Processor time, s", *(f"{size:,} runs" for size in options.sizes)],
        [[name, *(f"{rows[size][place]:.2f}" for size in options.sizes)] for place, name in enumerate(names)],
    )
    for name, (ratio, mark) in zip(names, marks, strict=False):
        report.say(f"{name}: {ratio:.2f} times as long (limit {mark:g}; {'met' if ratio <= mark else 'NOT MET'}).")
    report.finish()
    return 0 if all(ratio <= mark for ratio, mark in marks) else 1


if __name__ == "__main__":
    sys.exit(main())
