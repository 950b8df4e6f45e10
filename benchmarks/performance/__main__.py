"""Our times beside those of what a user would run instead, how they grow with size, and what memory they take.

    python benchmarks/performance --write docs/performance.md
    python benchmarks/performance --only b,c --small
    python benchmarks/performance --only c,i --earlier FOLDER

Each case is a pair, ours and its peer or limit, done in turn in one process; what counts is the ratio of the medians.
Exits with 1 where a bound does not hold. pytest-benchmark and asv each time one function by itself, to be held against
the same function of another day or commit: what is asked here is a ratio to something else under the same load of the
machine, which neither can tell.
"""

import argparse
import importlib
import os
import sys
import tempfile
from collections.abc import Iterator
from importlib.metadata import version
from pathlib import Path

from tribopipe.base.executor.environment import ONE_THREAD

sys.path.append(str(Path(__file__).parents[1]))
os.environ.update(ONE_THREAD | os.environ)  # before numpy is loaded: as the command has it, for ours and for peers

import page
from case import Pair, Row, Setting, unbound
from clock import both, grown
from labs import Report, arguments
from page import Grown, Timed
from weight import weighed

CASES = {
    "a": "ingest",
    "b": "exact_curve",
    "c": "fits",
    "d": "monte_carlo",
    "e": "disc_rotations",
    "f": "archive_listing",
    "g": "command_start",
    "h": "whole_line",
    "i": "earlier_fit",
}
"""Module of each case."""
_WHAT = """\
Each case is ours beside what a user would run instead, or beside the least it could cost: both in one process, in turn,
again and again. Times are medians, the least and the greatest in brackets; a ratio is ours over the peer's, unless it
says how many times as fast ours is. Of what needs no disk (b to e, and i) they are times of the processor; those of (i)
are of two processes in turn. Where the peer would take hours, a part of its work is timed and its time scaled, which is
said. The first lines of the modules in `benchmarks/performance` say what is done in each case; `--only b,c` does some
of them, and `--small` all of them in small, against no bound. Linear algebra has one thread, as the command has it."""
_GROWTH = """\
Medians at sizes over three decades, in turn as well, and the exponent n of time ∝ sizeⁿ by least squares through their
logarithms."""
_MEMORY = """\
Of a process of its own: the most it held while at work, and how much more that is than it held when it began. Of a
command it is all that the command held, or the largest of its processes."""
_REPEATS, _SMALL_REPEATS = 15, 3
_LIBRARIES = ("scipy", "pandas", "h5py", "numba")


def measured(row: Row, repeats: int) -> Timed | Grown:
    """Time and weigh what a case yields."""
    if isinstance(row, Pair):
        ours, peer = both(row, repeats)
        return Timed(row, ours, peer, (weighed(row.ours, ours), weighed(row.peer, peer)))
    works = [row.at(size) for size in row.sizes]
    times, exponent = grown(row, works, repeats)
    return Grown(row, times, exponent, weighed(works[-1], times[-1]))


def rows_of(letter: str, *, small: bool, earlier: Path | None) -> Iterator[Row]:
    """Yield what a case measures, in a folder of its own."""
    with tempfile.TemporaryDirectory() as folder:
        rows = importlib.import_module(CASES[letter]).rows(Setting(Path(folder), small, earlier))
        yield from map(unbound, rows) if small else rows


def main() -> int:
    """Measure the cases that are asked for and say what came of them; 1 where a bound does not hold."""
    options = _asked()
    found: list[tuple[str, Timed | Grown]] = []
    try:
        for letter in options.only:
            for row in rows_of(letter, small=options.small, earlier=options.earlier):
                found.append((letter, measured(row, options.repeats)))
                print(f"({letter}) {row.what}", file=sys.stderr, flush=True)
    finally:
        _tell(options, found)
    return 0 if all(one.holds for _, one in found) else 1


def _asked() -> argparse.Namespace:
    parser = arguments(__doc__ or "")
    parser.add_argument("--only", default=",".join(CASES), help="letters of the cases (%(default)s)")
    parser.add_argument("--repeats", type=int, help=f"number of repeats ({_REPEATS}; of small ones {_SMALL_REPEATS})")
    parser.add_argument("--small", action="store_true", help="sizes that take seconds, for which no bounds hold")
    parser.add_argument("--earlier", type=Path, help="work tree of an earlier commit, for case i")
    options = parser.parse_args()
    options.only = options.only.split(",")
    if unknown := set(options.only) - set(CASES):
        parser.error(f"--only: found {', '.join(sorted(unknown))}; expected some of {', '.join(CASES)}")
    options.repeats = options.repeats or (_SMALL_REPEATS if options.small else _REPEATS)
    return options


def _tell(options: argparse.Namespace, found: list[tuple[str, Timed | Grown]]) -> None:
    pairs = [(letter, one) for letter, one in found if isinstance(one, Timed)]
    growths = [(letter, one) for letter, one in found if isinstance(one, Grown)]
    report = Report("Performance", options)
    report.say("Libraries: " + ", ".join(f"{name} {version(name)}" for name in _LIBRARIES))
    report.say(_WHAT)
    report.table(page.CASES, page.of_cases(pairs))
    report.say("## Growth")
    report.say(_GROWTH)
    report.table(page.GROWTH, page.of_growth(growths))
    report.say("## Peak memory")
    report.say(_MEMORY)
    report.table(page.MEMORY, page.of_memory(pairs, growths))
    report.finish()


if __name__ == "__main__":
    sys.exit(main())
