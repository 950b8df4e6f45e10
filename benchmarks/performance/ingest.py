"""(a) A run folder ingested, beside `pandas.read_csv` and a plain h5py gzip write of the same columns.

Ours finds the format out, checks the run, keeps the bytes of the file beside the columns, seals the archived file,
reads it back and syncs it to the disk. The peer is told all about the file and keeps the columns alone.
"""

from collections.abc import Callable, Iterator
from itertools import count
from pathlib import Path

import h5py
import numpy as np
import pandas as pd
from case import Growth, Pair, Row, Setting
from reading import write_table

from tribopipe.archive.store import Archive
from tribopipe.pipeline.stages import ingest

MANIFEST = """\
schema = "tribopipe.run/1"
id = "long"
[contact]
kind = "pin-on-disc"
[contact.pin]
shape = "spherical"
radius = "5 mm"
material = "steel"
youngs_modulus = "210 GPa"
poisson_ratio = 0.3
[contact.disc]
material = "steel"
youngs_modulus = "210 GPa"
poisson_ratio = 0.3
[conditions]
normal_load = "200 mN"
sliding_speed = "100 mm/s"
[[signals]]
file = "table.csv"
[signals.columns]
time = { column = "Time [s]" }
depth = { column = "Depth [um]" }
friction_force = { column = "Friction force [N]" }
normal_force = { column = "Normal force [N]" }
temperature = { column = "Temperature [degC]" }
"""
_LONGEST, _SMALL = 1_250_000, 5_000


def rows(setting: Setting) -> Iterator[Row]:
    """Yield the pair and its growth."""
    run = made(setting, setting.of(_LONGEST, small=_SMALL))
    yield Pair(
        "ingest a run folder into an archive",
        ours=ours(run),
        peer=peer(run),
        beside="`pandas.read_csv` and a plain h5py gzip write of the columns",
        at_most=1.6,
    )
    yield Growth(
        "ingest a run folder into an archive",
        sizes=setting.decades(_LONGEST, small=_SMALL),
        at=lambda size: ours(made(setting, size)),
        at_most=1.1,
    )


def made(setting: Setting, size: int) -> Path:
    """Return a run folder of so many samples by five columns."""
    run = setting.folder / f"run-{size}"
    if not run.exists():
        run.mkdir()
        (run / "run.toml").write_text(MANIFEST, encoding="utf-8")
        write_table(run / "table.csv", size)
    return run


def ours(run: Path) -> Callable[[], object]:
    """Return the ingest of a run folder, each time into another archive."""
    archives = (run / f"archive-{number}" for number in count())

    def work() -> None:
        archive = Archive(next(archives))
        ingest(run, archive)
        archive.path("long").unlink()

    return work


def peer(run: Path) -> Callable[[], object]:
    """Return what a user would write by hand."""

    def work() -> None:
        table = pd.read_csv(run / "table.csv", dtype=np.float64)
        with h5py.File(run / "plain.h5", "w") as file:
            for name in table:
                file.create_dataset(str(name).replace("/", "_"), data=table[name].to_numpy(), compression="gzip")

    return work
