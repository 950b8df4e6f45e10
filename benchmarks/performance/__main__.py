"""Times of tribopipe and of the alternatives that a user would run, their scaling with size, and peak memory.

    python benchmarks/performance --write docs/performance.md --figure docs/figures/scaling.svg
    python benchmarks/performance --only b,c --small
    python benchmarks/performance --only c,i,j --earlier FOLDER

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

from tribopipe.base.process_lifecycle import ONE_THREAD

sys.path.append(str(Path(__file__).parents[1]))
os.environ.update(ONE_THREAD | os.environ)  # before numpy is loaded: as the command has it, for ours and for peers

import page
from case import Pair, Row, Setting, unbound
from chart import plot_growth
from clock import both, grown
from labs import Report, arguments
from page import Grown, Timed
from weight import weighed

from tribopipe.views.run_figures import save_figure

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
    "j": "earlier_process",
    "k": "nothing_to_do",
}
"""Module of each case."""
_WHAT = """\
In each case, tribopipe is compared with the usual alternative, or with a lower bound on the time. The two are timed
alternately, many times, in one process. Times are medians, with the minimum and the maximum in parentheses. A ratio is
the time of tribopipe divided by that of the alternative; "times as fast" is the inverse ratio. Cases without disk
access (b to e, and i) are compared by CPU time. Cases (i) and (j) compare the current version with an earlier one,
which is given with `--earlier`; the two versions are run alternately in separate processes. If the alternative would
take too long, only part of its work is timed, and the time is extrapolated, as stated in the table. The cases are
described in the docstrings of the modules in `benchmarks/performance`. `--only b,c` runs selected cases; `--small` runs
all cases at a small size, without checking the limits. Linear algebra uses one thread, as in the tribopipe command."""
_GROWTH = """\
The table lists median times for sizes spanning three decades; the sizes are also timed alternately. The exponent n in
time ∝ sizeⁿ is determined by a least-squares fit to the logarithms."""
_MEMORY = """\
The table lists the peak memory of a separate process that runs the case, and in parentheses the increase since
the start of the case. For commands, it lists the peak memory of the command, or of its largest process."""
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
    parser.add_argument("--figure", type=Path, help="file into which the scaling is drawn")
    parser.add_argument("--earlier", type=Path, help="work tree of an earlier commit, for cases i and j")
    options = parser.parse_args()
    options.only = options.only.split(",")
    if unknown := set(options.only) - set(CASES):
        parser.error(f"--only: found {', '.join(sorted(unknown))}; expected some of {', '.join(CASES)}")
    options.repeats = options.repeats or (_SMALL_REPEATS if options.small else _REPEATS)
    return options


def _tell(options: argparse.Namespace, found: list[tuple[str, Timed | Grown]]) -> None:
    found.sort(key=lambda one: one[0])
    pairs = [(letter, one) for letter, one in found if isinstance(one, Timed)]
    growths = [(letter, one) for letter, one in found if isinstance(one, Grown)]
    report = Report("Performance", options)
    report.say("Libraries: " + ", ".join(f"{name} {version(name)}" for name in _LIBRARIES))
    report.say(_WHAT)
    report.table(page.CASES, page.of_cases(pairs))
    report.say("## Scaling")
    report.say(_GROWTH)
    report.table(page.GROWTH, page.of_growth(growths))
    if options.figure is not None and growths:
        save_figure(plot_growth(growths), options.figure)
        if options.write is not None:
            shown = os.path.relpath(options.figure, options.write.parent).replace(os.sep, "/")
            report.say(f"![Median times against sizes, on logarithmic axes, with the fitted exponents]({shown})")
    report.say("## Peak memory")
    report.say(_MEMORY)
    report.table(page.MEMORY, page.of_memory(pairs, growths))
    report.finish()


if __name__ == "__main__":
    sys.exit(main())
