"""Ctrl-C at random moments of `tribopipe process` on 50 runs, which is then given again.

    python benchmarks/reliability/interrupts.py --points 100

The command is a process group of its own that gets SIGINT, as from a terminal, so long after it was started as chance
says. After each interrupt every file has to be whole. Once a command reaches its end the archive and its figures have
to be those of one that was never interrupted, but for dates; then a new one is begun. POSIX only.
"""

import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from random import Random

from held import RAW, content, contents, differences, figures, files
from short_runs import quick_recipe, short_runs
from told import Row, asked, tell

from tribopipe.base.files import leftovers

COMMAND = Path(sys.executable).with_name("tribopipe")
INTERRUPTED = 128 + signal.SIGINT
PART = 3
"""A command is interrupted within this part of the time of a whole batch, so that a batch is several times."""


@dataclass(frozen=True)
class Batch:
    """What is processed, and how that ends where nobody interrupts."""

    folder: Path
    words: list[str]
    seconds: float
    """How long it takes."""
    whole: dict[str, dict[str, bytes]]
    raw: dict[str, dict[str, bytes]]
    figures: dict[str, bytes]


@dataclass
class Interrupted:
    """What was found after interrupts."""

    moments: list[float] = field(default_factory=list)
    """How long after their start commands were interrupted, s."""
    codes: Counter[int] = field(default_factory=Counter)
    """Exit codes of commands that were."""
    ended: int = 0
    """Commands that ended before they could be."""
    early: int = 0
    """Of the interrupts, those while Python itself was starting, which answers with words of its own."""
    slowest: float = 0.0
    """Longest time from the signal to the end, s."""
    wrong: list[str] = field(default_factory=list)
    """What was not as it should be."""
    left: int = 0
    """Temporary files left."""
    batches: int = 0
    """Batches that came to their end."""


def batch(folder: Path, runs: int) -> Batch:
    """Write run folders, and process them without an interrupt."""
    paths = short_runs(folder / "runs", runs)
    words = [str(COMMAND), "process", *map(str, paths), "--recipe", str(quick_recipe(folder)), "--archive"]
    archive, start = folder / "undisturbed", time.monotonic()
    subprocess.run([*words, str(archive)], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    taken = time.monotonic() - start
    raw = {path.stem: content(path, RAW) for path in files(archive)}
    return Batch(folder, words, taken, contents(archive), raw, figures(archive))


def interrupt(one: Batch, points: int, chance: Random) -> Interrupted:
    """Process with interrupts until there were so many."""
    # Who is started in the background ignores Ctrl-C, and so does what it starts.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    found, archive = Interrupted(), one.folder / "archive"
    while len(found.moments) < points:
        if _ends(one, archive, found, chance.uniform(0.0, one.seconds / PART)):
            _compare(one, archive, found)
    if archive.exists():
        subprocess.run([*one.words, str(archive)], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        _compare(one, archive, found)
    return found


def _ends(one: Batch, archive: Path, found: Interrupted, moment: float) -> bool:
    """Start the command and interrupt it at a moment; tell whether it had come to its end before."""
    with subprocess.Popen(
        [*one.words, str(archive)], stderr=subprocess.PIPE, text=True, encoding="utf-8", start_new_session=True
    ) as process:
        try:
            _, said = process.communicate(timeout=moment)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGINT)
            start = time.monotonic()
            _, said = process.communicate()
            found.slowest = max(found.slowest, time.monotonic() - start)
            _look(one, archive, found, process.returncode, said)
            found.moments.append(moment)
        else:
            found.ended += 1
    if process.returncode == 0 and "steps" not in said:
        found.wrong.append(f"exit code 0, but said {said!r}")
    return process.returncode == 0


def _look(one: Batch, archive: Path, found: Interrupted, code: int, said: str) -> None:
    """Look at how a command ended that was interrupted, and at what it left."""
    found.codes[code] += 1
    if code not in (0, INTERRUPTED) or "Traceback" in said:
        if _python_was_starting(said):
            found.early += 1
        else:
            found.wrong.append(f"exit code {code}: {said[-500:]}")
    elif code and said.splitlines()[-1].partition(";")[0] != "interrupted":
        found.wrong.append(f"said {said[-500:]!r}")
    for path in files(archive):
        try:
            if content(path, RAW) != one.raw[path.stem]:
                found.wrong.append(f"{path.name}: raw content changed")
        except (OSError, KeyError, RuntimeError) as error:
            found.wrong.append(f"{path.name}: {error}")
    found.left += sum(len(leftovers(folder)) for folder in (archive, archive / "figures"))


def _python_was_starting(said: str) -> bool:
    """Tell whether no line of tribopipe had run yet: a signal then ends Python, with or without words of its own."""
    return "tribopipe/cli/app.py" not in said and "steps" not in said


def _compare(one: Batch, archive: Path, found: Interrupted) -> None:
    """Hold an archive that is done against the undisturbed one, and take it away."""
    found.batches += 1
    found.wrong += differences(contents(archive), one.whole)
    found.wrong += sorted(f"figures/{name}" for name, _ in figures(archive).items() ^ one.figures.items())
    shutil.rmtree(archive)


def rows(found: Interrupted) -> list[Row]:
    """Return what was found as rows of a table."""
    codes = ", ".join(f"{count} with exit code {code}" for code, count in sorted(found.codes.items()))
    return [
        Row("interrupts", f"{len(found.moments)}: {codes}"),
        Row("of these, while Python was starting", str(found.early)),
        Row("longest time from Ctrl-C to exit", f"{found.slowest:.2f} s", "< 2 s", found.slowest < 2),
        Row("temporary files left behind", str(found.left), "0", not found.left),
        Row("interrupted batches that were completed", str(found.batches)),
        Row("tracebacks, or wrong exit codes, files or figures", str(len(found.wrong)), "0", not found.wrong),
    ]


def main() -> int:
    """Interrupt, and tell what was found."""
    parser = asked(__doc__, points=100)
    parser.add_argument("--runs", type=int, default=50, help="runs of a batch (%(default)s)")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        one = batch(Path(scratch), options.runs)
        found = interrupt(one, options.points, Random(options.seed))  # noqa: S311
    print(*found.wrong[:10], sep="\n", file=sys.stderr)
    return tell(
        "interrupts",
        "Ctrl-C at random times",
        options,
        rows(found),
        f"A batch of {options.runs} short runs with figures takes {one.seconds:.0f} s. The command is interrupted "
        f"within its first {one.seconds / PART:.0f} s and run again, so that the interruptions are distributed over "
        "the entire batch.",
    )


if __name__ == "__main__":
    sys.exit(main())
