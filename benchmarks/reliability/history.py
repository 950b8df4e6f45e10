"""What the history of an archive costs: each write with and without it, and with that of ten thousand runs.

    python benchmarks/reliability/history.py --points 200

A step of a short run is written over and over, in turn with and without the history, and in turn with a short history
and with one as long as that of an archive of 10 000 runs. Then that one is read whole, as `verify` does.
"""

import shutil
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import islice
from pathlib import Path
from statistics import median

from short_runs import short_runs
from told import Row, asked, tell

from tribopipe.archive import run_files
from tribopipe.archive.history import FILE_NAME, Account, Entry, append, chained, entry
from tribopipe.archive.store import Archive
from tribopipe.base.files import replacing
from tribopipe.pipeline import stages as pipeline

RUNS = 10_000
WRITES = 7
"""Of each run, from ingestion to its predictions."""
MOST_RATIO, MOST_LONGER, MOST_READING = 1.25, 1.1, 10.0
"""Of a write with the history to one without it; of one to a long history to one to a short; to read a long one, s."""


def long_history() -> Iterator[Entry]:
    """Give the lines of an archive of many runs."""
    for number in range(RUNS):
        for write in range(WRITES):
            before, after = (f"{WRITES * number + write + one:064x}" for one in (0, 1))
            yield entry("written", f"run-{number}.h5", before=before if write else None, after=after)
            yield entry("done", f"run-{number}.h5")


@contextmanager
def without_history() -> Iterator[None]:
    """Have files written as they were before there was a history."""
    plain = vars(run_files)["placed"]
    vars(run_files)["placed"] = lambda archive, path, event: replacing(path)  # noqa: ARG005
    try:
        yield
    finally:
        vars(run_files)["placed"] = plain


def timed(work: Callable[[], object]) -> float:
    """Return how long some work takes, s."""
    start = time.perf_counter()
    work()
    return time.perf_counter() - start


def rows(folder: Path, points: int) -> list[Row]:
    """Write, and return what was found as rows of a table."""
    (run,) = short_runs(folder / "runs", 1)
    short = Archive(folder / "short")
    if [one for one in pipeline.process([run], short) if one.error is not None]:
        raise RuntimeError("the run could not be processed")
    step = short.step(run.name, "friction_fit")
    if step is None:
        raise RuntimeError("the run has no friction fit")
    long = Archive(Path(shutil.copytree(short.folder, folder / "long")))
    with (long.folder / FILE_NAME).open("ab") as file:
        lines, _ = chained(long_history(), Account(long.folder).read().head)
        file.write(lines)
    shutil.rmtree(long.folder / ".locks")  # which hold the hash of a line before these
    append(long.folder, [])
    plain, bare, late = [], [], []
    for _ in range(points):
        plain.append(timed(lambda: short.put_step(run.name, step)))
        late.append(timed(lambda: long.put_step(run.name, step)))
        with without_history():
            bare.append(timed(lambda: short.put_step(run.name, step)))
    ratio, longer = median(plain) / median(bare), median(late) / median(plain)
    account = Account(long.folder)
    reading = timed(account.read)
    size = (long.folder / FILE_NAME).stat().st_size
    ends = list(islice(account.problems, 1))
    return [
        Row("a step written without the history, median", f"{1e3 * median(bare):.1f} ms"),
        Row("with it, median", f"{1e3 * median(plain):.1f} ms"),
        Row("ratio", f"{ratio:.3f}", f"at most {MOST_RATIO}", ratio <= MOST_RATIO),
        Row(f"lines after {RUNS:,} runs", f"{account.lines:,}, {size / 1e6:.0f} MB"),
        Row(
            "a step written to that one, to a short one",
            f"{longer:.3f}",
            f"at most {MOST_LONGER}",
            longer <= MOST_LONGER,
        ),
        Row("that one read whole", f"{reading:.1f} s", f"at most {MOST_READING:g} s", reading <= MOST_READING),
        Row("lines that do not follow the one before", str(len(ends)), "0", not ends),
    ]


def main() -> int:
    """Measure, and tell what was found."""
    options = asked(__doc__, points=200).parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        found = rows(Path(scratch), options.points)
    return tell(
        "history",
        "What the history of an archive costs",
        options,
        found,
        "A step of a short run is written in turn with the history, with a long one, and without any. Each write "
        "appends two lines, each of which is on the disk before the next thing is done; only the end is read for it.",
    )


if __name__ == "__main__":
    sys.exit(main())
