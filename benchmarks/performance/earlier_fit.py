"""(i) The fit of k_D of one run beside that of an earlier commit, each in a process of its own, in turn.

    git worktree add --detach EARLIER 254266a
    python -m venv EARLIER/.venv && EARLIER/.venv/bin/pip install -e EARLIER
    python benchmarks/performance --only i --earlier EARLIER

Both fit the run of case (c), the earlier one with the packages of its own environment if it has one. Ours is the fit
by the whole reading under both laws; the earlier one, under one law or both, is the fit in two steps with its budget
and that together with drift.
"""

import json
import os
import subprocess
import sys
import weakref
from collections.abc import Iterator
from functools import partial
from pathlib import Path

from case import Pair, Row, Setting
from own_process import Taken

HERE = Path(__file__).parents[2]
_ONE, _BOTH = ("archard",), ("archard", "sarkar")
_MOST = 10.0
_SERVE = r"""
import json, re, sys, time
from pathlib import Path
root = Path(sys.argv[1])
sys.path[:0] = [str(root), str(root / "benchmarks"), str(root / "benchmarks" / "performance")]
import fits, tribopipe
try:
    from tribopipe.evaluation.friction import fit_friction
    from tribopipe.evaluation.wear.fit import fit_wear
except ModuleNotFoundError:  # the names of commit 254266a
    from tribopipe.friction import fit_friction
    from tribopipe.wear.identify import fit_wear
if root not in Path(tribopipe.__file__).parents:
    sys.exit(f"{tribopipe.__file__} is not in {root}")
run = fits.TestRun(fits.SAMPLES_A_RUN).corrected
friction = fit_friction(run.run)
for line in sys.stdin:
    begun = time.process_time()
    for law in json.loads(line):
        fit_wear(run, law, None if law == "archard" else friction, fits.NO_DRAWS)
    seconds, peak = time.process_time() - begun, None
    if sys.platform == "linux":
        (held,) = re.findall(r"^VmHWM:\s*([0-9]+) kB$", Path("/proc/self/status").read_text("ascii"), re.MULTILINE)
        peak = 1024.0 * float(held)
    print(json.dumps([seconds, peak]), flush=True)
"""


def rows(setting: Setting) -> Iterator[Row]:
    """Yield the pairs; none where no earlier commit is given."""
    if setting.earlier is None:
        print("(i) is skipped: --earlier FOLDER names the work tree of an earlier commit", file=sys.stderr)
        return
    ours, peer = Served(HERE, _SERVE), Served(setting.earlier.resolve(), _SERVE)
    both, work = partial(ours, _BOTH), "k_D for one run, with both laws"
    yield Pair(
        work,
        both,
        partial(peer, _ONE),
        "earlier version: fit, uncertainty budget and joint fit, with one law",
        at_most=_MOST,
    )
    yield Pair(work, both, partial(peer, _BOTH), "earlier version: the same fits, with both laws")


def own_folder(root: Path) -> Path:
    """Return the folder of programs of a work tree's own environment; of that of this process where it has none."""
    own = root / ".venv" / ("Scripts" if sys.platform == "win32" else "bin")
    return own if own.is_dir() else Path(sys.executable).parent


class Served:
    """A process that does some work with the code of one work tree, as often as it is asked to.

    Each line that it reads is an order, and its answer the time of the processor, s, and the peak memory, bytes.
    """

    def __init__(self, root: Path, script: str, *arguments: str) -> None:
        """Start it; it ends with this object."""
        python = own_folder(root) / ("python.exe" if sys.platform == "win32" else "python")
        self._process = subprocess.Popen(
            [str(python), "-c", script, str(root), *arguments],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            env=os.environ | {"PYTHONPATH": str(root)},
        )
        weakref.finalize(self, self._process.communicate)

    def __call__(self, order: object) -> Taken:
        """Have the work done, and return what it took. Raises ``ValueError`` where that fails."""
        ask, answer = self._process.stdin, self._process.stdout
        if ask is None or answer is None:
            raise ValueError(self._process.args)
        print(json.dumps(order), file=ask, flush=True)
        return Taken(*json.loads(answer.readline()))
