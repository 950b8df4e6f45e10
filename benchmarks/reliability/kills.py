"""Four writers at once in one archive, killed at random moments of ingest, correct-drift, fit and process.

    python benchmarks/reliability/kills.py --points 500

After each kill, while the other writers go on, every file is opened, its seal held against its bytes and what was
recorded against what an undisturbed archive holds. After every 25th, `tribopipe process` has to complete, and the
archive has to be the undisturbed one but for dates; then a new one is begun. POSIX only.
"""

import os
import shutil
import sys
import tempfile
import time
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import count
from pathlib import Path
from random import Random
from typing import NamedTuple

from forks import command, ended, forked, killed
from held import RAW, content, contents, differences, files
from short_runs import quick_recipe, short_runs
from told import Row, asked, tell

from tribopipe.archive.store import Archive
from tribopipe.base.files import leftovers
from tribopipe.documents.recipe import Recipe
from tribopipe.documents.record import load_toml
from tribopipe.pipeline import stages
from tribopipe.pipeline.stages import Outcome, attempted

WRITERS = 4
RUNS = 6
KILLS_AN_ARCHIVE = 25
KINDS = ("ended", "unreadable", "lost", "changed", "failed", "different")
"""What can be wrong."""

Job = Callable[[Archive, Sequence[Path], Recipe], Iterator[Outcome]]


def _ingest(store: Archive, runs: Sequence[Path], _: Recipe) -> Iterator[Outcome]:
    for run in runs:
        yield attempted(run.name, "ingest", partial(stages.ingest, run, store, force=True))


def _correct(store: Archive, runs: Sequence[Path], recipe: Recipe) -> Iterator[Outcome]:
    for run in runs:
        step = partial(stages.advance, store, run.name, "drift_correction", recipe, force=True)
        yield attempted(run.name, "drift_correction", step)


def _fit(store: Archive, runs: Sequence[Path], recipe: Recipe) -> Iterator[Outcome]:
    for run in runs:
        friction = partial(stages.advance, store, run.name, "friction_fit", recipe, force=True)
        yield attempted(run.name, "friction_fit", friction)
        yield attempted(
            run.name, "wear_fit", partial(stages.advance, store, run.name, "wear_fit_sarkar", recipe, force=True)
        )


def _process(store: Archive, runs: Sequence[Path], recipe: Recipe) -> Iterator[Outcome]:
    yield from stages.process(runs, store, recipe, force=True)


JOBS: dict[str, Job] = {"ingest": _ingest, "correct-drift": _correct, "fit": _fit, "process": _process}


@dataclass(frozen=True)
class Lab:
    """Run folders, and what an archive of them holds that nothing disturbed."""

    folder: Path
    runs: list[Path]
    recipe: Path
    whole: dict[str, dict[str, bytes]]
    raw: dict[str, dict[str, bytes]]

    @property
    def archive(self) -> Path:
        """The archive that is written to."""
        return self.folder / "archive"

    @property
    def said(self) -> Path:
        """File of what processes say."""
        return self.folder / "said.txt"

    def process(self) -> int:
        """Run `tribopipe process` on all runs; return its exit code."""
        words = ["process", *self.runs, "--archive", self.archive, "--recipe", self.recipe, "--no-figures"]
        return ended(forked(command(*words), self.said))


def lab(folder: Path, count: int = RUNS) -> Lab:
    """Write run folders, and archive them undisturbed, in this process, which is warm then."""
    runs, recipe, undisturbed = short_runs(folder / "runs", count), quick_recipe(folder), folder / "undisturbed"
    failed = [one for one in stages.process(runs, Archive(undisturbed), load_toml(recipe, Recipe)) if one.error]
    if failed:
        raise RuntimeError(failed)
    raw = {path.stem: content(path, RAW) for path in files(undisturbed)}
    return Lab(folder, runs, recipe, contents(undisturbed), raw)


class Writer(NamedTuple):
    """A process at work."""

    number: int
    job: str
    reports: Path
    """File of what it says to have archived: in each line the id of a run."""
    end: float
    """When it is killed, s, by the clock of ``time.monotonic``."""


def started(one: Lab, job: str, runs: Sequence[Path], seconds: float) -> Writer:
    """Start a writer that does its job over and over, to be killed after so long; or once, and to its end, for 0 s."""
    handle, reports = tempfile.mkstemp(prefix="reports-", dir=one.folder)
    os.close(handle)

    def work() -> None:
        with Path(reports).open("a", encoding="utf-8", buffering=1) as file:
            for _ in count() if seconds else range(1):
                for outcome in JOBS[job](Archive(one.archive), runs, load_toml(one.recipe, Recipe)):
                    if outcome.error is None:
                        file.write(f"{outcome.run_id}\n")

    return Writer(forked(work, one.said), job, Path(reports), time.monotonic() + seconds)


def durations(one: Lab) -> dict[str, float]:
    """Return how long each job takes with two runs, s, where as many do it at once as will be killed."""
    taken = {}
    for job in JOBS:
        start = time.monotonic()
        for writer in [started(one, job, one.runs[at : at + 2], 0.0) for at in range(WRITERS)]:
            ended(writer.number)
        taken[job] = time.monotonic() - start
    return taken


class Killing:
    """Rounds of writers that are killed, and what was found wrong after that."""

    def __init__(self, one: Lab, chance: Random) -> None:
        self.lab, self.chance = one, chance
        self.kills: Counter[str] = Counter()
        self.wrong: dict[str, list[str]] = defaultdict(list)
        self.left = self.looks = self.completed = 0
        self._took = durations(one)
        shutil.rmtree(one.archive)

    def kill(self, points: int) -> None:
        """Go on until so many writers were killed while they worked."""
        while self.kills.total() < points:
            end = min(points, self.kills.total() + KILLS_AN_ARCHIVE)
            while self.kills.total() < end:
                self._round()
            self._complete()

    def _round(self) -> None:
        jobs = [self.chance.choice(list(JOBS)) for _ in range(WRITERS)]
        writers = [
            started(self.lab, job, self.chance.sample(self.lab.runs, 2), self.chance.uniform(0.0, self._took[job]))
            for job in jobs
        ]
        for writer in sorted(writers, key=lambda one: one.end):
            time.sleep(max(0.0, writer.end - time.monotonic()))
            if killed(writer.number):
                self.kills[writer.job] += 1
            else:
                self.wrong["ended"].append(self.lab.said.read_text(encoding="utf-8"))
            self._look(writer)

    def _look(self, writer: Writer) -> None:
        """Look at what is cheap to look at, while the others go on."""
        self.looks += 1
        found = {}
        for path in files(self.lab.archive):
            try:
                found[path.stem] = content(path, RAW)
            except (OSError, KeyError, RuntimeError) as error:
                self.wrong["unreadable"].append(f"{path.name}: {error}")
        self.wrong["changed"] += [run for run, held in found.items() if held != self.lab.raw[run]]
        reported = set(writer.reports.read_text(encoding="utf-8").split())
        self.wrong["lost"] += sorted(reported - found.keys())

    def _complete(self) -> None:
        """Process all runs, and hold the archive against the undisturbed one; the next begins empty."""
        self.completed += 1
        self.left += len(leftovers(self.lab.archive))
        if self.lab.process() != 0:
            self.wrong["failed"].append(self.lab.said.read_text(encoding="utf-8"))
        self.wrong["different"] += differences(contents(self.lab.archive), self.lab.whole)
        shutil.rmtree(self.lab.archive)


def rows(killing: Killing) -> list[Row]:
    """Return what was found as rows of a table."""
    during = ", ".join(f"{kills} {job}" for job, kills in sorted(killing.kills.items()))
    wrong = {
        what: len(killing.wrong[what]) for what in ("ended", "unreadable", "lost", "changed", "failed", "different")
    }
    return [
        Row("writers killed", f"{killing.kills.total()}: {during}"),
        Row("checks of all files while others are writing", str(killing.looks)),
        Row("writers that ended before they were killed", str(wrong["ended"]), "0", not wrong["ended"]),
        Row("unreadable files", str(wrong["unreadable"]), "0", not wrong["unreadable"]),
        Row("lost runs that had been reported as archived", str(wrong["lost"]), "0", not wrong["lost"]),
        Row("runs with a changed raw byte", str(wrong["changed"]), "0", not wrong["changed"]),
        Row(
            "subsequent `process` commands that failed",
            f"{wrong['failed']} of {killing.completed}",
            "0",
            not wrong["failed"],
        ),
        Row("values that differ from those without interruption", str(wrong["different"]), "0", not wrong["different"]),
        Row("temporary files left behind, listed by `verify`", str(killing.left)),
    ]


def main() -> int:
    """Kill, and tell what was found."""
    options = asked(__doc__, points=500).parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        killing = Killing(lab(Path(scratch)), Random(options.seed))  # noqa: S311
        killing.kill(options.points)
    for what, found in killing.wrong.items():
        print(*(f"{what}: {one}" for one in found[:5]), sep="\n", file=sys.stderr)
    return tell(
        "kills",
        "Writers killed at random times",
        options,
        rows(killing),
        f"{WRITERS} writers work simultaneously on one archive of {RUNS} short runs. Each repeats one of four jobs on "
        "two of the runs, with all steps, and is killed at a random time within the usual duration of the job.",
    )


if __name__ == "__main__":
    sys.exit(main())
