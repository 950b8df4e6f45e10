"""Eight processes that put 50 runs each into one archive, while the list of runs is kept up to date beside them.

    python benchmarks/reliability/many_writers.py --points 400

Each run is ingested and corrected for drift. Every process begins with a few runs of the next one, so that some are
worked on by two at once. In the end there are as many runs, sealed, with all steps, equal to those that one process
archived alone; and the catalogue that was kept meanwhile is equal to one made anew. POSIX only.
"""

import json
import sqlite3
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from forks import forked, has_ended
from held import content, differences, files
from short_runs import short_runs
from told import Row, asked, tell

from tribopipe.archive import lock, run_files
from tribopipe.archive.catalog.catalog import Catalogue
from tribopipe.archive.catalog.database import FILE_NAME
from tribopipe.archive.store import Archive
from tribopipe.documents.recipe import Recipe
from tribopipe.pipeline import stages
from tribopipe.pipeline.stages import Outcome, attempted

PROCESSES = 8
SHARED = 5
"""Runs that a process takes from the next one besides its own."""
ALONE = 20
"""Every so many runs, one is also archived by one process alone, for comparison."""
STEPS = ("clean_up", "drift_correction")
_PAUSE = 0.2
"""Between two refreshes of the catalogue, s."""


@dataclass(frozen=True)
class Found:
    """What was there in the end."""

    runs: int
    unsound: list[str]
    """Files that cannot be read or lack a step."""
    apart: list[str]
    """Fields other than where one process worked alone."""
    failed: list[str]
    """What went wrong in the processes."""
    listed_apart: list[str]
    """Runs of which the kept catalogue and the one made anew do not say the same."""
    waits: list[float]
    """How long each lock was waited for, s."""
    seconds: float
    refreshes: int


def work(runs: Sequence[Path], archive: Archive) -> Iterator[Outcome]:
    """Ingest and correct runs."""
    for run in runs:
        yield attempted(str(run), "ingest", partial(stages.ingest, run, archive))
        step = partial(stages.advance, archive, run.name, "drift_correction", Recipe())
        yield attempted(run.name, "drift_correction", step)


def write_together(folder: Path, count: int) -> Found:
    """Let processes write so many runs, and look at what came of it."""
    runs, archive = short_runs(folder / "runs", count), folder / "archive"
    sample = runs[::ALONE]
    list(work(sample, Archive(folder / "alone")))  # which makes this process warm
    start = time.monotonic()
    children = [
        forked(partial(_write, part, archive, folder / f"told-{number}"), folder / "said")
        for number, part in enumerate(parts(runs))
    ]
    refreshes = _keep_catalogue(archive, children)
    seconds = time.monotonic() - start
    told = [json.loads(path.read_text(encoding="utf-8")) for path in folder.glob("told-*")]
    alone = {path.stem: content(path) for path in files(folder / "alone")}
    together = {run.name: content(archive / f"{run.name}.h5") for run in sample}
    return Found(
        runs=len(files(archive)),
        unsound=[fault for run in runs for fault in _faults(archive / f"{run.name}.h5")],
        apart=differences(together, alone),
        failed=[*(error for one in told for error in one["failed"]), *["ended"] * (len(children) - len(told))],
        listed_apart=_listed_apart(archive),
        waits=sorted(wait for one in told for wait in one["waits"]),
        seconds=seconds,
        refreshes=refreshes,
    )


def parts(runs: Sequence[Path]) -> list[list[Path]]:
    """Share out the runs; the first few of each process are also among the first of another."""
    share = len(runs) // PROCESSES
    shares = [list(runs[at : at + share]) for at in range(0, len(runs), share)]
    return [
        [run for both in zip(own[:SHARED], other[:SHARED], strict=True) for run in both] + own[SHARED:]
        for own, other in zip(shares, [*shares[1:], shares[0]], strict=True)
    ]


def _write(runs: Sequence[Path], archive: Path, told: Path) -> None:
    """Do the work of a process, and write down what failed and how long it waited for locks."""
    waits: list[float] = []
    plain = lock.writers_lock

    @contextmanager
    def timed(folder: Path, name: str, *, wait: bool = True) -> Iterator[None]:
        start = time.perf_counter()
        with plain(folder, name, wait=wait):
            waits.append(time.perf_counter() - start)
            yield

    vars(run_files)["writers_lock"] = timed
    failed = [str(outcome.error) for outcome in work(runs, Archive(archive)) if outcome.error is not None]
    told.write_text(json.dumps({"failed": failed, "waits": waits}), encoding="utf-8")


def _keep_catalogue(archive: Path, children: Sequence[int]) -> int:
    """Bring the catalogue up to date until all processes have ended; return how often."""
    catalogue, times = Catalogue(archive), 0
    for child in children:
        while not has_ended(child):
            catalogue.refresh()
            times += 1
            time.sleep(_PAUSE)
    catalogue.refresh()  # which goes on with the file, even if it waited for others in vain before
    return times + 1


def _faults(path: Path) -> list[str]:
    try:
        there = content(path)
    except (OSError, KeyError, RuntimeError) as error:
        return [f"{path.name}: {error}"]
    done = [step for step in STEPS if f"entry/{step}/fingerprints/result_sha256" in there]
    return [] if len(done) == len(STEPS) else [f"{path.name}: has {', '.join(done) or 'no step'}"]


def _listed_apart(archive: Path) -> list[str]:
    """Hold the kept catalogue against one made anew."""
    kept = _listed(archive / FILE_NAME)
    (archive / FILE_NAME).unlink()
    Catalogue(archive).refresh()
    return sorted(str(row[0]) for row in kept ^ _listed(archive / FILE_NAME))


def _listed(database: Path) -> set[tuple[object, ...]]:
    with closing(sqlite3.connect(database)) as connection:
        return {tuple(row)[1:] for row in connection.execute("SELECT * FROM listed")}  # without the row number


def rows(found: Found, count: int) -> list[Row]:
    """Return what was found as rows of a table."""
    last = len(found.waits) - 1
    median, most = found.waits[last // 2], found.waits[-1]
    late = found.waits[round(0.99 * last)]
    return [
        Row("runs in the archive", str(found.runs), str(count), found.runs == count),
        Row(
            "files with a broken seal, unreadable files, missing steps", str(len(found.unsound)), "0", not found.unsound
        ),
        Row("steps that failed", str(len(found.failed)), "0", not found.failed),
        Row("values that differ from those of a single process", str(len(found.apart)), "0", not found.apart),
        Row(
            "catalog rows that differ from a rebuilt catalog", str(len(found.listed_apart)), "0", not found.listed_apart
        ),
        Row("catalog updates in the meantime", str(found.refreshes)),
        Row(
            "wait for a lock: median, 99th percentile, longest",
            f"{median * 1e3:.1f} ms, {late * 1e3:.1f} ms, {most * 1e3:.0f} ms",
        ),
        Row("locks acquired", str(len(found.waits))),
        Row("time", f"{found.seconds:.0f} s"),
    ]


def main() -> int:
    """Write, and tell what was found."""
    options = asked(__doc__, points=400).parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        found = write_together(Path(scratch), options.points)
    for wrong in (found.unsound, found.failed, found.apart, found.listed_apart):
        print(*wrong[:5], sep="\n", file=sys.stderr)
    return tell(
        "many_writers",
        "Many simultaneous writers",
        options,
        rows(found, options.points),
        f"{PROCESSES} processes ingest {options.points // PROCESSES} runs each and correct them for drift; {SHARED} of "
        f"these {options.points // PROCESSES} runs are ingested and corrected by a second process at the same time.",
    )


if __name__ == "__main__":
    sys.exit(main())
