"""An archive of a thousand runs on a web server: the table and one run's plot, without downloading the archive.

    python benchmarks/remote.py --write docs/results/remote.md

The marks to hold: the table within 3 s and the plot of a run within 2 s, where each request takes the server 20 ms
before it answers. The server runs in this process. Pages are those of `tribopipe browse`, which fetches anew each time;
commands are timed with the start of Python. Nothing may be written to the folder that is served.
"""

import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import h5py
from browse import RUN, answer_time, long_archive
from catalogue import COMMAND, age
from fsspec import filesystem
from labs import Report, arguments
from many_runs import many_runs
from range_server import serving

from tribopipe.archive import remote
from tribopipe.archive.catalog.catalog import Catalogue
from tribopipe.archive.outline import read_outline
from tribopipe.archive.remote import archive_path
from tribopipe.archive.store import Archive
from tribopipe.browse.library import Library
from tribopipe.browse.plots import run_plots
from tribopipe.browse.server import running

DELAY = 0.02
"""What each request takes before its answer begins, s."""
REPEATS = 5
TABLE, PLOT = 3.0, 2.0
"""Marks, s."""
_BLOCKS = 1 << 16
"""Bytes of a block of fsspec in the comparison."""
_MB = 1e6


class Taken(NamedTuple):
    """What some work took."""

    time: float
    """Median over the repeats, s."""
    busy: float
    """Median of the time on a processor, that of the server in this process included, s."""
    requests: int
    sent: int
    """Bytes of the last repeat."""

    def row(self, what: str, limit: str = "–") -> list[str]:
        """Return a row of a table."""
        return [
            what,
            f"{self.time:.2f} s",
            f"{self.busy:.2f} s",
            limit,
            f"{self.requests}",
            f"{self.sent / _MB:.2f} MB",
        ]


HEAD = ["Measured", "Time", "CPU time", "Limit", "Requests", "Bytes read"]


def cpu_time() -> float:
    """Return the time that this process and those it started and waited for had on processors, s."""
    return sum(os.times()[:4])


def taken(folder: Path, work: Callable[[str], object], repeats: int) -> Taken:
    """Do some work several times with the address of a folder, another one each time, so that all is fetched anew."""
    times, busy, requests, sent = [], [], 0, 0
    for _ in range(repeats):
        with serving(folder, DELAY) as server:
            start, begun = time.perf_counter(), cpu_time()
            work(server.address)
            times.append(time.perf_counter() - start)
            busy.append(cpu_time() - begun)
            requests, sent = len(server.requests), server.sent
    return Taken(statistics.median(times), statistics.median(busy), requests, sent)


def command(*words: str) -> Callable[[str], None]:
    """Return what runs tribopipe with an archive, in a folder that goes with it."""

    def run(address: str) -> None:
        with tempfile.TemporaryDirectory() as here:
            line = [str(COMMAND), *words, "--archive", address]
            subprocess.run(line, check=True, cwd=here, stdout=subprocess.DEVNULL)

    return run


def page(target: str) -> Callable[[str], None]:
    """Return what starts a server of pages with an archive, and asks it."""

    def ask(address: str) -> None:
        with running(archive_path(address)) as site:
            answer_time(site, target)

    return ask


def state(folder: Path) -> dict[str, tuple[int, int]]:
    """Return size and time of change of all that is in a folder."""
    return {str(path): (path.stat().st_size, path.stat().st_mtime_ns) for path in folder.rglob("*")}


def time_table_and_plot(report: Report, folder: Path, repeats: int) -> bool:
    """Report on the table and the plot, and return whether their marks are held and nothing was written."""
    before, run_id = state(folder), Archive(folder).ids()[0]
    plotted = page(f"/api/runs/{run_id}/plots/wear?width=1200")
    taken(folder, plotted, 1)  # imports what is needed
    table, plot = (taken(folder, work, repeats) for work in (page("/api/runs?where="), plotted))
    commands = {
        "`tribopipe ls`": command("ls"),
        "`tribopipe show RUN`": command("show", run_id),
        "`tribopipe show RUN --plot`, all figures": command("show", run_id, "--plot"),
    }
    report.table(
        HEAD,
        [
            table.row("table, page", f"{TABLE:g} s"),
            plot.row("one run's plot, page", f"{PLOT:g} s"),
            *(taken(folder, work, repeats).row(what) for what, work in commands.items()),
        ],
    )
    unchanged, size = state(folder) == before, sum(size for size, _ in before.values())
    end = "Nothing was written to it." if unchanged else "It was CHANGED."
    report.say(f"The archive has {len(before):,} files and {size / _MB:.0f} MB. {end}")
    return table.time < TABLE and plot.time < PLOT and unchanged


def by_fsspec(name: str) -> Callable[[str], None]:
    """Return what reads the outline of a run through the block cache of fsspec, by nothing but range requests."""
    kept = {"block_size": _BLOCKS, "cache_type": "blockcache", "cache_options": {"maxblocks": 4096}}

    def read(address: str) -> None:
        with filesystem("http").open(f"{address}/{name}", **kept) as source, h5py.File(source, "r") as file:
            read_outline(file)

    return read


def by_tribopipe(name: str, largest_whole: int) -> Callable[[str], None]:
    """Return what reads the outline of a run as an archive is read, whole or in blocks."""

    def read(address: str) -> None:
        remote.LARGEST_WHOLE = largest_whole
        Archive(address).outline(name.removesuffix(".h5"))

    return read


def compare_ways(report: Report, folder: Path, run_id: str, what: str) -> None:
    """Report on the ways to read the outline of a run."""
    name, usual = f"{run_id}.h5", remote.LARGEST_WHOLE
    ways = {
        "whole": by_tribopipe(name, 1 << 40),
        "blocks of 256 kB": by_tribopipe(name, 1),
        "fsspec, blocks of 64 kB": by_fsspec(name),
    }
    rows = [taken(folder, way, 3).row(how) for how, way in ways.items()]
    remote.LARGEST_WHOLE = usual
    size = (folder / name).stat().st_size
    report.table([f"Outline of {what}, {size / _MB:.1f} MB", *HEAD[1:]], rows)


def time_long_run(report: Report, folder: Path) -> None:
    """Report on the page and the first plot of a run that is read in blocks."""

    def drawn(address: str) -> None:
        run_plots(Library(archive_path(address)).run(RUN))[0].drawing()

    report.table(HEAD, [taken(folder, drawn, 1).row("page and first plot of the long run")])


def main() -> None:
    """Make the archives, read them over HTTP, and hold the times against the marks."""
    parser = arguments(__doc__ or "")
    parser.add_argument("--runs", type=int, default=1000, help="runs in the table (%(default)s)")
    parser.add_argument("--repeats", type=int, default=REPEATS, help="times each is measured (%(default)s)")
    parser.add_argument("--samples", type=int, default=1_000_000, help="samples of the long run (%(default)s)")
    parser.add_argument("--keep", type=Path, default=None, help="folder in which the archives stay")
    options = parser.parse_args()
    report = Report("A remote archive", options)
    with tempfile.TemporaryDirectory() as scratch:
        folder: Path = options.keep or Path(scratch)
        many = folder / "many"
        if not many.exists():
            many_runs(many, options.runs)
            age(many)
        Catalogue(many).refresh()
        report.say(f"{options.runs} runs of 501 samples; {DELAY * 1e3:.0f} ms before each answer.")
        held = time_table_and_plot(report, many, options.repeats)
        sample, long = long_archive(folder / "sample", 12_500), long_archive(folder / "long", options.samples)
        compare_ways(report, many, Archive(many).ids()[0], "a short run")
        compare_ways(report, sample, RUN, "a sample run of 12,500 samples")
        compare_ways(report, long, RUN, f"a run of {options.samples:,} samples")
        time_long_run(report, long)
    report.say(
        "The rows of fsspec are without catalog, seal and the look for foreign content, so they are a lower bound."
    )
    report.say(f"Files of up to {remote.LARGEST_WHOLE / _MB:.0f} MB are read whole, larger ones in blocks.")
    report.say("All limits are met." if held else "A limit is NOT MET.")
    report.finish()
    if not held:
        sys.exit(1)


if __name__ == "__main__":
    main()
