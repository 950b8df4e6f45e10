"""Reading of 1.25 million rows by 5 columns of CSV beside `pandas.read_csv` told everything about the file.

    python benchmarks/reading.py

The file is read from the disk by both in turn in one process; ours finds encoding, separator, decimal sign, header and
units by itself, refuses what is broken, and keeps the bytes for the archive. The target is a ratio of at most 1.5 and a
peak memory of at most 3 times the parsed columns, the bytes of the file included. Memory is the peak of a process of
its own over what it held before it read; only Linux tells it.
"""

import math
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
from labs import Report, arguments

from tribopipe.base.files import read_file
from tribopipe.readers.delimited import DelimitedReader
from tribopipe.readers.reader import Hints
from tribopipe.results.run import SourceFile

HEADER = "Time [s],Depth [um],Friction force [N],Normal force [N],Temperature [degC]"
DECIMALS = (3, 4, 5, 5, 2)
_WARM_UP = 2000
"""Rows read first, so that imports and tables of units count for neither."""


def write_table(path: Path, rows: int) -> None:
    """Write a table as an instrument would, with so many decimals in each column."""
    rng = np.random.default_rng(1)
    spreads = (10.0, 1.0), (0.1, 0.01), (0.2, 0.001), (23.0, 0.1)
    columns = [np.arange(rows) * 1e-3, *(rng.normal(mean, spread, rows) for mean, spread in spreads)]
    table = {
        name: column.round(digits) for name, column, digits in zip(HEADER.split(","), columns, DECIMALS, strict=True)
    }
    pd.DataFrame(table).to_csv(path, index=False)


def ours(path: Path) -> object:
    """Read a file as ingestion does."""
    return DelimitedReader().read(SourceFile(path.name, read_file(path)), Hints())


def theirs(path: Path) -> object:
    """Read a file by pandas, told all that is to know."""
    return pd.read_csv(path, sep=",", decimal=".", header=0, dtype=np.float64, encoding="utf-8")


READERS: dict[str, Callable[[Path], object]] = {"pandas.read_csv": theirs, "tribopipe": ours}


def peak() -> float:
    """Return the largest memory this process has held, bytes; not a number where the system does not tell."""
    status = Path("/proc/self/status")
    lines = status.read_text(encoding="ascii").splitlines() if status.exists() else []
    held = [int(line.split()[1]) * 1024 for line in lines if line.startswith("VmHWM:")]
    return float(held[0]) if held else math.nan


def memory(name: str, path: Path, small: Path) -> float:
    """Return the peak memory of reading the file in a process of its own, bytes."""
    command = [sys.executable, __file__, "--memory-of", name, str(path), str(small)]
    return float(subprocess.run(command, check=True, capture_output=True, text=True).stdout)


def print_memory(name: str, path: Path, small: Path) -> None:
    """Read a small file and then the large one, and print what the latter took."""
    READERS[name](small)
    before = peak()
    READERS[name](path)
    print(peak() - before)


def timed(work: Callable[[], object]) -> float:
    """Return how long it took, s."""
    start = time.perf_counter()
    work()
    return time.perf_counter() - start


def main() -> None:
    """Time both in turn, weigh both, and print medians and ratios."""
    parser = arguments(__doc__ or "")
    parser.add_argument("--repeats", type=int, default=31, help="number of repeats (%(default)s)")
    parser.add_argument("--rows", type=int, default=1_250_000, help="rows of the file (%(default)s)")
    options = parser.parse_args()
    report = Report("Time and memory for reading files", options)
    with tempfile.TemporaryDirectory() as folder:
        path, small = Path(folder) / "table.csv", Path(folder) / "small.csv"
        write_table(path, options.rows)
        write_table(small, _WARM_UP)
        times: dict[str, list[float]] = {name: [] for name in READERS}
        for read in READERS.values():
            read(small)
        for _ in range(options.repeats):
            for name, read in READERS.items():
                times[name].append(timed(lambda read=read: read(path)))  # type: ignore[misc]
        held = {name: memory(name, path, small) for name in READERS}
        size = path.stat().st_size
    parsed = options.rows * len(DECIMALS) * 8
    report.say(
        f"{options.rows} rows × {len(DECIMALS)} columns, {size / 1e6:.1f} MB as text, {parsed / 1e6:.1f} MB parsed. "
        f"Medians of {options.repeats} alternating repeats; minimum and maximum in parentheses."
    )
    medians = {name: statistics.median(taken) for name, taken in times.items()}
    rows = [
        [
            name,
            f"{medians[name]:.3f} s ({min(taken):.3f} to {max(taken):.3f})",
            f"{medians[name] / medians['pandas.read_csv']:.2f}",
            f"{held[name] / 1e6:.0f} MB",
            f"{held[name] / parsed:.2f}",
        ]
        for name, taken in times.items()
    ]
    report.table(["", "elapsed time", "ratio", "peak memory", "peak memory / parsed data"], rows)
    report.finish()


if __name__ == "__main__":
    if sys.argv[1:2] == ["--memory-of"]:
        print_memory(sys.argv[2], Path(sys.argv[3]), Path(sys.argv[4]))
    else:
        main()
