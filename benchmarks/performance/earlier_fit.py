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
    ours, peer = Fitting(HERE), Fitting(setting.earlier.resolve())
    both, work = partial(ours, _BOTH), "k_D for one run, with both laws"
    yield Pair(
        work,
        both,
        partial(peer, _ONE),
        "earlier version: fit, uncertainty budget and joint fit, with one law",
        at_most=_MOST,
    )
    yield Pair(work, both, partial(peer, _BOTH), "earlier version: the same fits, with both laws")


def _python(root: Path) -> str:
    """Return the interpreter of a work tree's own environment; that of this process where it has none."""
    own = root / ".venv" / ("Scripts/python.exe" if sys.platform == "win32" else "bin/python")
    return str(own) if own.is_file() else sys.executable


class Fitting:
    """A process that fits the run, with the code of one work tree, as often as it is asked to."""

    def __init__(self, root: Path) -> None:
        """Start it; it ends with this object."""
        self._process = subprocess.Popen(
            [_python(root), "-c", _SERVE, str(root)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            env=os.environ | {"PYTHONPATH": str(root)},
        )
        weakref.finalize(self, self._process.communicate)

    def __call__(self, laws: tuple[str, ...]) -> Taken:
        """Fit under these laws, and tell the time of the processor. Raises ``ValueError`` where that fails."""
        ask, answer = self._process.stdin, self._process.stdout
        if ask is None or answer is None:
            raise ValueError(self._process.args)
        print(json.dumps(laws), file=ask, flush=True)
        return Taken(*json.loads(answer.readline()))
