"""(j) `tribopipe process`, and the draws of a twin-disc fit, compared with those of an earlier commit, in turn.

    git worktree add --detach EARLIER 254266a
    python -m venv EARLIER/.venv && EARLIER/.venv/bin/pip install -e EARLIER
    python benchmarks/performance --only j --earlier EARLIER

Both process the sample runs and studies of the earlier commit, each by itself as a user would give the command, and
archive them anew (`--force`). The earlier commit used one process unless it was asked for more.
"""

import os
import sys
from collections.abc import Iterator
from functools import partial
from pathlib import Path

from case import Command, Pair, Row, Setting
from earlier_fit import HERE, Served, own_folder

sys.path.append(str(Path(__file__).parents[1] / "reliability"))

from short_runs import quick_recipe, short_runs

_REPEATS = 3
_MANY, _FEW = 1000, 4
_DISCS = "si3n4-twin-disc-4pct-500k"
_DRAWS = r"""
import json, sys, time
from pathlib import Path
root, folder = Path(sys.argv[1]), Path(sys.argv[2])
sys.path[:0] = [str(root)]
import numpy as np
from tribopipe import Recipe, read_run
try:
    from tribopipe.evaluation.wear.measurement_problem import measurement_problem as problem_of
except ModuleNotFoundError:  # the names of commit 254266a
    from tribopipe.wear.twin_disc.problem import disc_problem as problem_of
problem = problem_of(read_run(folder), "archard", None, Recipe())
found = problem.coefficients()
for line in sys.stdin:
    values, begun = problem.draw(np.random.default_rng(1), json.loads(line)), time.process_time()
    problem.solve_draws(values, found)
    print(json.dumps([time.process_time() - begun, None]), flush=True)
"""


def rows(setting: Setting) -> Iterator[Row]:
    """Yield the pairs; none where no earlier commit is given."""
    if setting.earlier is None:
        print("(j) is skipped: --earlier FOLDER names the work tree of an earlier commit", file=sys.stderr)
        return
    # Each command is to load the package of its own work tree.
    os.environ.pop("PYTHONPATH", None)
    earlier = setting.earlier.resolve()
    samples, count = earlier / "sample_runs", setting.of(_MANY, small=_FEW)
    short_runs(setting.folder / "runs", count)
    whole = setting.folder / "runs" if setting.small else samples
    for how, at_least in (((), 4.0), (("-j", "1"), 2.5)):
        yield Pair(
            " ".join(("`process` on 14 runs and 3 studies", *how)),
            processed(HERE, whole, setting.folder / "ours", *how),
            processed(earlier, whole, setting.folder / "theirs"),
            "earlier version, without options: one process",
            at_least=at_least,
            repeats=_REPEATS,
        )
    ours, theirs = (Served(root, _DRAWS, str(samples / _DISCS)) for root in (HERE, earlier))
    draws = setting.of(10_000, small=100)
    yield Pair(
        f"{draws:,} Monte Carlo draws of a fit for two discs",
        partial(ours, draws),
        partial(theirs, draws),
        "earlier version",
        at_least=10.0,
    )
    plain = "-j", "2", "--recipe", str(quick_recipe(setting.folder))
    yield Pair(
        f"`process -j 2` on {count} runs",
        processed(HERE, setting.folder / "runs", setting.folder / "many-ours", *plain),
        processed(earlier, setting.folder / "runs", setting.folder / "many-theirs", *plain),
        "earlier version, `-j 2`",
        at_least=2.0,
        repeats=1,
    )


def processed(root: Path, runs: Path, archive: Path, *options: str) -> Command:
    """Return the command of a work tree that does all steps of these runs, whether they were done before or not."""
    command = own_folder(root) / ("tribopipe.exe" if sys.platform == "win32" else "tribopipe")
    return Command([str(command), "process", str(runs), "--archive", str(archive), "--force", *options])
