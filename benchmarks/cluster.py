"""Batches of runs on workers of which one is killed midway, held against `process -j 1`.

    python benchmarks/cluster.py --runs 200

`process` takes the same runs by two processes (`-j 2`), by a Dask LocalCluster of two workers, and by a Dask scheduler
and two workers that are each started as a program of its own on the loopback. Once half of the runs are archived, the
worker that has worked most is killed (SIGKILL). Asked is that all runs are archived, that the archive verifies, and
that the fingerprint of each step's result is that of `-j 1`, bit for bit. Exits with 1 where that does not hold. POSIX
only.
"""

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import NamedTuple

import psutil
from labs import Report, arguments

sys.path.append(str(Path(__file__).parent / "reliability"))

from short_runs import quick_recipe, short_runs

from tribopipe.archive.store import Archive
from tribopipe.base.process_lifecycle import ONE_THREAD

PROGRAMS = Path(sys.executable).parent
_LOOK_EVERY = 0.1
_BEGINS_WITHIN = 60.0
"""How long a scheduler and workers may take to begin, s."""

Workers = Callable[[int], Sequence[psutil.Process]]
"""Finds the workers of a batch by the number of its process."""


class Batch(NamedTuple):
    """What came of one batch."""

    archive: Path
    seconds: float
    code: int
    """Exit code."""
    killed_after: int | None
    """Runs that were archived when a worker was killed; none where none was."""


def tribopipe(*words: object) -> list[str]:
    """Return a command line."""
    return [str(PROGRAMS / "tribopipe"), *map(str, words)]


def archived(folder: Path) -> int:
    """Return how many runs an archive holds."""
    return sum(1 for _ in folder.glob("*.h5"))


def results(folder: Path) -> dict[tuple[str, str], str]:
    """Return the fingerprint of what each step of each run found."""
    archive = Archive(folder)
    return {
        (run_id, name): step.result
        for run_id in archive.ids()
        for name in archive.step_names(run_id)
        if (step := archive.fingerprints(run_id, name)) is not None
    }


def batch(folder: Path, words: Sequence[object], workers: Workers | None = None, kill_after: int = 0) -> Batch:
    """Process all runs into an archive of their own; kill a worker once so many of them are archived."""
    archive = Path(tempfile.mkdtemp(prefix="archive-", dir=folder))
    given = [folder / "runs", "--recipe", folder / "recipe.toml", "--archive", archive, "--no-figures"]
    start, quiet, killed_after = time.monotonic(), subprocess.DEVNULL, None
    command = tribopipe("process", *given, *words)
    with subprocess.Popen(command, stdout=quiet, stderr=quiet, start_new_session=True) as begun:
        while begun.poll() is None:
            if workers is not None and killed_after is None and archived(archive) >= kill_after:
                max(workers(begun.pid), key=lambda worker: sum(worker.cpu_times()[:2])).kill()
                killed_after = archived(archive)
            time.sleep(_LOOK_EVERY)
    return Batch(archive, time.monotonic() - start, begun.returncode, killed_after)


def spawned(parent: int) -> list[psutil.Process]:
    """Return the processes that a batch has begun to work for it."""
    children = psutil.Process(parent).children(recursive=True)
    return [child for child in children if any("spawn_main" in word for word in child.cmdline())]


def ways(folder: Path) -> Iterator[tuple[str, list[str], Workers]]:
    """Give the ways to do a batch: options of `process`, and how workers are found."""
    yield "two processes: `-j 2`", ["-j", "2"], spawned
    yield "LocalCluster: `--scheduler local -j 2`", ["--scheduler", "local", "-j", "2"], spawned
    with own_cluster(folder) as (address, workers):
        yield "`dask scheduler` and two `dask worker`", ["--scheduler", address], lambda _: workers


@contextmanager
def own_cluster(folder: Path) -> Iterator[tuple[str, list[psutil.Process]]]:
    """Start a scheduler and two workers on the loopback; give the scheduler's address, and the workers."""
    told, quiet = folder / "scheduler.json", subprocess.DEVNULL
    dask, place = str(PROGRAMS / "dask"), ["--no-dashboard", "--scheduler-file", str(told)]
    scheduler = [dask, "scheduler", "--host", "127.0.0.1", "--port", "0", *place]
    worker = [dask, "worker", "--nthreads", "1", "--no-nanny", "--local-directory", str(folder / "scratch"), *place]
    environment = {**os.environ, **ONE_THREAD}  # as a nanny gives it, who would start a killed worker anew
    with ExitStack() as ending:
        begun = []
        for command in (scheduler, worker, worker):
            begun.append(subprocess.Popen(command, stdout=quiet, stderr=quiet, env=environment, start_new_session=True))
            ending.callback(begun[-1].wait)
            ending.callback(begun[-1].kill)
        yield _address(told), [psutil.Process(one.pid) for one in begun[1:]]


def _address(told: Path) -> str:
    """Wait until a scheduler has told its address."""
    deadline = time.monotonic() + _BEGINS_WITHIN
    while time.monotonic() < deadline:
        if told.exists() and (text := told.read_text(encoding="utf-8")):
            return str(json.loads(text)["address"])
        time.sleep(_LOOK_EVERY)
    raise TimeoutError("the scheduler did not begin")


def row(name: str, done: Batch, runs: int, expected: Mapping[tuple[str, str], str]) -> tuple[list[str], bool]:
    """Return what came of a batch as cells of a table, and whether it is all that is asked."""
    found = results(done.archive)
    other = sum(found.get(step) != expected.get(step) for step in found.keys() | expected.keys())
    verify = subprocess.run(tribopipe("verify", "--archive", done.archive), capture_output=True, check=False)
    count, sound = archived(done.archive), verify.returncode == 0
    killed = "none" if done.killed_after is None else f"after {done.killed_after} runs"
    cells = [name, killed, str(count), "no problems" if sound else "PROBLEMS", f"{other} of {len(expected)}"]
    return [*cells, f"{done.seconds:.0f} s"], done.code == 0 and count == runs and sound and not other


def main() -> int:
    """Take the runs in each way, and tell what came of it; 1 where it is not all that is asked."""
    parser = arguments(__doc__ or "")
    parser.add_argument("--runs", type=int, default=200, help="how many runs (%(default)s)")
    options = parser.parse_args()
    report = Report("Batch processing with a killed worker", options)
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        short_runs(folder / "runs", options.runs)
        quick_recipe(folder)
        alone = batch(folder, ["-j", "1"])
        expected = results(alone.archive)
        found = [row("one process: `-j 1`", alone, options.runs, expected)]
        for name, words, workers in ways(folder):
            done = batch(folder, words, workers, max(options.runs // 2, 1))
            cells, holds = row(name, done, options.runs, expected)
            found.append((cells, holds and done.killed_after is not None))
    report.table(_HEAD, [cells for cells, _ in found])
    report.say(
        f"Each batch contains {options.runs} runs of 126 samples, processed without figures and Monte Carlo. When "
        "half of the runs are archived, the worker with the most CPU time is killed. A result is different if its "
        "SHA-256 differs from that with `-j 1`."
    )
    report.finish()
    return 0 if all(holds for _, holds in found) else 1


_HEAD = ("Workers", "Worker killed", "Archived runs", "`verify`", "Different results", "Time")

if __name__ == "__main__":
    sys.exit(main())
