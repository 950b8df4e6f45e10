"""(f) `tribopipe ls` of thousands of archived runs beside a loop of h5py over their files.

The command starts, looks at every file for changes, and prints a table of all runs. The loop, in a process that has
loaded h5py, reads id, date and k_D of a tenth of them, and its time is scaled to all.
"""

import time
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path

import h5py
from case import Command, Pair, Row, Setting
from catalogue import COMMAND, age
from many_runs import many_runs

_SETTLED = 2.5
"""Seconds after which the catalogue trusts the time of a file."""


def rows(setting: Setting) -> Iterator[Row]:
    """Yield the pair."""
    archive, runs = setting.folder / "archive", setting.of(10_000, small=60)
    many_runs(archive, runs)
    age(archive)
    time.sleep(_SETTLED)
    some = sorted(archive.glob("*.h5"))[::10]
    listing = Command([str(COMMAND), "ls", "--archive", str(archive)])
    listing()  # which makes the catalogue
    yield Pair(
        f"`tribopipe ls` with {runs:,} runs",
        listing,
        partial(listed, some),
        f"h5py loop over the files; extrapolated from {len(some)} files",
        scaled=runs / len(some),
        repeats=7,
    )


def listed(paths: Sequence[Path]) -> list[tuple[str, str, float]]:
    """Return id, date and k_D, m²/N, of runs."""
    found = []
    for path in paths:
        with h5py.File(path, "r") as file:
            entry = file["entry"]
            k_d = entry["wear_fit_archard/parameters/pin_wear_coefficient"][()]
            found.append((entry["identifier_run"].asstr()[()], entry["start_time"].asstr()[()], float(k_d)))
    return found
