"""An archive of very many runs, made in seconds: every run is in the catalog, and its file is empty.

    python benchmarks/large_archive.py FOLDER 100000

The rows go through the catalog's own ``keep``, and the stamps are those of the files, so that listing finds nothing to
read. Some runs of many_runs.py are the patterns; each copy has its own id, date, title and k_D.
"""

import os
import random
import sqlite3
import sys
import tempfile
import time
from collections.abc import Iterator
from datetime import datetime, timedelta
from functools import partial
from itertools import islice
from pathlib import Path

from many_runs import many_runs

from tribopipe.archive.catalog.catalog import Known, Note, keep
from tribopipe.archive.catalog.database import Database, transaction
from tribopipe.archive.catalog.listing import Cell
from tribopipe.archive.catalog.reading import read_cells
from tribopipe.archive.file_signature import stamp_of
from tribopipe.archive.store import Archive
from tribopipe.documents.quantity import Quantity

PATTERNS = 40
"""Runs that the others are copied from."""
_FIRST_DAY = datetime.fromisoformat("2004-01-05T08:00:00+01:00")
_AN_HOUR = 3600.0
_AT_ONCE = 5000


def large_archive(folder: Path, count: int, seed: int = 1) -> list[float]:
    """Fill an empty folder; return the k_D, m²/N, of the runs of Si3N4 with more than 300 mN, in order."""
    chance = random.Random(seed)  # noqa: S311
    folder.mkdir(parents=True)
    chosen: list[float] = []
    with tempfile.TemporaryDirectory() as scratch:
        many_runs(Path(scratch), PATTERNS)
        store = Archive(Path(scratch))
        patterns = [read_cells(store, run_id) for run_id in store.ids()]
        database = Database(folder)
        runs = _runs(patterns, count, chance)
        while batch := list(islice(runs, _AT_ONCE)):
            notes = [_note(folder, cells) for cells in batch]
            database.do(partial(_written, notes))
            chosen += [float(cells["k_d"].value or 0) for cells in batch if _is_chosen(cells)]
    return sorted(chosen)


def _runs(patterns: list[dict[str, Cell]], count: int, chance: random.Random) -> Iterator[dict[str, Cell]]:
    """Yield the cells of each run."""
    for number in range(count):
        cells = chance.choice(patterns)
        started = _FIRST_DAY + timedelta(hours=chance.randrange(24 * 365 * 20))
        k_d = Quantity(value=chance.lognormvariate(0.0, 0.8) * 1e-14, standard_uncertainty=1e-16, unit="m^2/N")
        yield cells | {
            "id": Cell(f"{cells['id'].value}-{number:06}"),
            "title": Cell(f"{cells['title'].value} no. {number}"),
            "started": Cell(started.isoformat()),
            "k_d": Cell(k_d.value, k_d.standard_uncertainty, k_d.shown("mm^3/(N*mm)").removesuffix(" mm³/(N·mm)")),
        }


def _note(folder: Path, cells: dict[str, Cell]) -> Note:
    """Make the empty file of a run, and return what the catalog would note of one with content."""
    path = folder / f"{cells['id'].value}.h5"
    path.touch()
    long_ago = time.time() - _AN_HOUR
    os.utime(path, (long_ago, long_ago))
    return Note(path.name, Known(str(stamp_of(path.stat())), settled=True, sha256="0" * 64), cells=cells)


def _written(notes: list[Note], connection: sqlite3.Connection) -> None:
    with transaction(connection):
        keep(connection, notes)


def _is_chosen(cells: dict[str, Cell]) -> bool:
    return "Si3N4" in str(cells["material"].value).split("\n") and float(cells["load"].value or 0) > 0.3


if __name__ == "__main__":
    large_archive(Path(sys.argv[1]), int(sys.argv[2]))
