"""Runs made to be archived, and archived files changed behind their seal, as somebody would who means to."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np

from tribopipe.archive.seal import seal_file
from tribopipe.run import RawRun, SourceFile


@contextmanager
def edited(path: Path) -> Iterator[h5py.File]:
    """Open an archived file for changes, and seal it anew."""
    with h5py.File(path, "r+", locking=False) as file:
        yield file
    seal_file(path)


def with_sources(bare: RawRun, **contents: bytes) -> RawRun:
    """Return a run of five samples that was read from some files; `run` is its run.toml."""
    distance = np.linspace(0, 1, 5)
    return replace(
        bare,
        columns={"time": distance, "sliding_distance": distance, "depth": distance},
        origins={"time": "measured", "sliding_distance": "measured", "depth": "measured"},
        sources=tuple(
            SourceFile(f"{name}.toml" if name == "run" else name, bytes_) for name, bytes_ in contents.items()
        ),
    )
