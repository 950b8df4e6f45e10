"""A run larger than memory should hold: ingested and processed within bounds, with the k_D of every sample.

    python benchmarks/long_run.py --write docs/results/long_run.md
    python benchmarks/long_run.py --rows 300000 --held 200000 --threshold 1000000 --means 20000    # in seconds

A run of 500 m with drift, running-in friction and correlated noise, of which the truth is known, is written row by row.
`tribopipe ingest` and `tribopipe process` take it in processes of their own, whose peak resident memory the system
tells on Linux (ru_maxrss). A shorter run that can be held is evaluated twice: by every sample, and by means of 20.

Ends with exit code 1 where a process took 1 GB or more, or where k_D by means is 1 % of its uncertainty or more away
from that by every sample.
"""

import argparse
import math
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd
from labs import SAMPLES, Report, arguments
from own_process import Taken, taken
from scipy.signal import lfilter

from tribopipe.archive.store import Archive
from tribopipe.base.arrays import Column
from tribopipe.base.files import pieces_of
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import LawName
from tribopipe.evaluation.drift import correct_drift
from tribopipe.evaluation.friction import fit_friction
from tribopipe.evaluation.wear.fit import fit_wear
from tribopipe.extras.simulate import VirtualTest
from tribopipe.readers import long_runs, long_text
from tribopipe.readers.harmonize import read_run
from tribopipe.results.run import RawRun

SERIES, SAMPLE = SAMPLES["si3n4-air-200mN"]
LAWS: tuple[LawName, ...] = ("archard", "sarkar")
_AT_ONCE = 100_000
_ROW = "%.6f,%.3f,%.3f,%.3f\n"
_GIGABYTE = 1e9
_SHARE = 0.01
"""Of its uncertainty, by which k_D may differ."""
_FOLDED = 20
"""Samples in a mean of the run that can be held."""


class _Noise:
    """First-order autoregressive noise of unit variance that comes piece by piece."""

    def __init__(self, rng: np.random.Generator, length: float) -> None:
        self._rng, self._memory = rng, float(np.exp(-1 / length))
        self._state = rng.standard_normal(1) * self._memory

    def draw(self, count: int) -> Column:
        """Draw the next values."""
        gain = [float(np.sqrt(1 - self._memory**2))]
        values, self._state = lfilter(gain, [1.0, -self._memory], self._rng.standard_normal(count), zi=self._state)
        return np.asarray(values)


def write_run(folder: Path, rows: int) -> None:
    """Write a run folder of so many rows, few of which are in memory at once."""
    VirtualTest(SERIES, SAMPLE).write(folder)
    with (folder / "signals.csv").open("w", encoding="ascii", newline="\n") as file:
        file.write("Time [s],Depth [um],Ff [mN],Fn [mN]\n")
        for block in _samples(rows):
            file.write(_ROW * len(block) % tuple(block.ravel().tolist()))


def _samples(rows: int) -> Iterator[Column]:
    test, sensors = VirtualTest(SERIES, SAMPLE), SERIES.sensors
    rate = (rows - 1) / test.time[-1]
    rng = np.random.default_rng(SAMPLE.seed)
    depth_noise = _Noise(rng, sensors.depth_correlation_time.value * rate)
    friction_noise = _Noise(rng, sensors.friction_correlation_time.value * rate)
    for start in range(0, rows, _AT_ONCE):
        clock = np.arange(start, min(start + _AT_ONCE, rows)) / rate
        distance = clock * (test.distance[-1] / test.time[-1])
        # Depth is nearly straight over the root of the distance.
        worn = np.interp(np.sqrt(distance), np.sqrt(test.distance), test.worn.pin_depth + test.worn.disc_depth)
        noise = sensors.depth_noise.value * depth_noise.draw(len(clock))
        depth = SAMPLE.zero_offset.value + worn + SAMPLE.drift_rate.value * clock + noise
        mu = test.friction.coefficient(distance) + sensors.friction_noise.value * friction_noise.draw(len(clock))
        load = SAMPLE.normal_load.value * (1 + sensors.load_noise.value * rng.standard_normal(len(clock)))
        yield np.column_stack([clock, 1e6 * depth, 1e3 * mu * load, 1e3 * load])


_COMMAND = """
from tribopipe.readers import long_runs, long_text
long_text.LARGE, long_runs.MOST = {large}, {most}
from tribopipe.cli.entry_point import main
main()
"""


def run(command: str, folder: Path, archive: Path, options: argparse.Namespace) -> Taken:
    """Run a command of tribopipe in a process of its own."""
    script = _COMMAND.format(large=options.threshold, most=options.means)
    return taken([sys.executable, "-c", script, command, str(folder), "--archive", str(archive)])


def counted(path: Path) -> None:
    """Read a file and count its lines, as `wc -l` does."""
    sum(piece.count(b"\n") for piece in pieces_of(path, 1 << 20))


def parsed(path: Path) -> None:
    """Parse a file by pandas in chunks, told all that is to know."""
    with pd.read_csv(path, dtype=np.float64, chunksize=_AT_ONCE) as chunks:
        for _ in chunks:
            pass


def clocked(work: Callable[[Path], None], path: Path) -> float:
    """Return how long it took, s."""
    begun = time.perf_counter()
    work(path)
    return time.perf_counter() - begun


def take_long_run(folder: Path, options: argparse.Namespace, report: Report) -> bool:
    """Write, ingest and process the long run; tell time and memory, and whether that stayed in its bound."""
    write_run(folder, options.rows)
    signals = folder / "signals.csv"
    report.say(
        f"The signal file contains {options.rows:,} rows and 4 columns, {signals.stat().st_size / 1e6:.0f} MB of text."
    )
    plain, pandas = clocked(counted, signals), clocked(parsed, signals)
    archive = folder.parent / "archive"
    ingested, done = (run(command, folder, archive, options) for command in ("ingest", "process"))
    rows = {
        "counting lines": Taken(plain, None),
        "`pandas.read_csv` in chunks": Taken(pandas, None),
        "`tribopipe ingest`": ingested,
        "`tribopipe process`, after `ingest`": done,
    }
    head = ["", "elapsed time", "rows per second", "relative to pandas", "peak memory"]
    report.table(head, [[name, *_shown(one, pandas, options.rows)] for name, one in rows.items()])
    report.say(_kept(Archive(archive), options.rows))
    return all(one.peak is None or one.peak < _GIGABYTE for one in (ingested, done))


def _shown(one: Taken, pandas: float, rows: int) -> list[str]:
    memory = f"{one.peak / 1e6:.0f} MB" if one.peak else "–"
    return [f"{one.seconds:.1f} s", f"{rows / one.seconds:,.0f}", f"{one.seconds / pandas:.2f}", memory]


def _kept(archive: Archive, rows: int) -> str:
    run = archive.raw(SAMPLE.id)
    size = archive.path(SAMPLE.id).stat().st_size
    seen = 0 if run.recording is None else sum(len(block.get("depth", ())) for block in run.recording.blocks())
    kept = f"{seen:,} of {rows:,} recorded samples, and {run.samples}, which are evaluated"
    return f"The archived file has a size of {size / 1e6:.0f} MB. It contains {kept}."


class Evaluated(NamedTuple):
    """What a run comes to."""

    friction: Quantity
    coefficients: dict[LawName, Quantity]


def evaluated(run: RawRun) -> Evaluated:
    """Take a run through the line."""
    corrected, friction = correct_drift(run), fit_friction(run)
    fits = {law: fit_wear(corrected, law, friction).first for law in LAWS}
    coefficients = {law: needed(None if found is None else found.wear_coefficient) for law, found in fits.items()}
    return Evaluated(needed(friction.steady_state), coefficients)


def needed(found: Quantity | None) -> Quantity:
    """Return what was found. Raises ``SystemExit`` where nothing was."""
    if found is None:
        raise SystemExit("long_run: found a run without a result; expected one that can be fitted")
    return found


def compare(folder: Path, options: argparse.Namespace, report: Report) -> bool:
    """Evaluate a run by every sample and by means; tell whether k_D is the same within a share of its uncertainty."""
    write_run(folder, options.held)
    long_text.LARGE = 1 << 62
    every = evaluated(read_run(folder))
    long_text.LARGE, long_runs.MOST = 0, -(-options.held // _FOLDED)
    folded = read_run(folder)
    by_means = evaluated(folded)
    pairs = {"friction, steady state": (every.friction, by_means.friction)}
    pairs |= {f"k_D, {law}": (every.coefficients[law], by_means.coefficients[law]) for law in LAWS}
    report.say(f"Results for a run of {options.held:,} rows, from all samples and from {folded.samples}:")
    rows = [
        [name, str(one), str(other), f"{apart(one, other):.4f}", f"{ratio(one, other):.4f}"]
        for name, (one, other) in pairs.items()
    ]
    report.table(["", "all samples", "means", "difference / u", "u from means / u"], rows)
    return all(apart(every.coefficients[law], by_means.coefficients[law]) < _SHARE for law in LAWS)


def apart(one: Quantity, other: Quantity) -> float:
    """Return how far two results are apart, as a share of the first one's standard uncertainty."""
    return abs(other.value - one.value) / (one.standard_uncertainty or math.nan)


def ratio(one: Quantity, other: Quantity) -> float:
    """Return the second standard uncertainty over the first."""
    return (other.standard_uncertainty or math.nan) / (one.standard_uncertainty or math.nan)


def main() -> None:
    """Take both runs, and print what came of it."""
    parser = arguments(__doc__ or "")
    parser.add_argument("--rows", type=int, default=20_000_000, help="rows of the long run (%(default)s)")
    parser.add_argument("--held", type=int, default=2_000_000, help="rows of the run that can be held (%(default)s)")
    parser.add_argument("--threshold", type=int, default=long_text.LARGE, help="bytes of a long file (%(default)s)")
    parser.add_argument("--means", type=int, default=long_runs.MOST, help="means that are evaluated (%(default)s)")
    options = parser.parse_args()
    report = Report("Recordings larger than memory", options)
    with tempfile.TemporaryDirectory(prefix="tribopipe-") as made:
        within = take_long_run(Path(made) / "long", options, report)
    with tempfile.TemporaryDirectory(prefix="tribopipe-") as made:
        same = compare(Path(made) / "held", options, report)
    report.say(
        f"Peak memory below 1 GB: {'yes' if within else 'no'}. Difference in k_D below 1 % of its uncertainty: "
        f"{'yes' if same else 'no'}."
    )
    report.finish()
    sys.exit(0 if within and same else 1)


if __name__ == "__main__":
    main()
