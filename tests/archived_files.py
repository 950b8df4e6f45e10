"""Runs made to be archived, and archived files changed behind their seal, as somebody would who means to."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np

from tribopipe.archive.seal import seal_file
from tribopipe.results.run import RawRun, SourceFile


@contextmanager
def edited(path: Path) -> Iterator[h5py.File]:
    """Open an archived file for changes, and seal it anew."""
    with h5py.File(path, "r+", locking=False) as file:
        yield file
    seal_file(path)


def write_as_earlier(path: Path) -> None:
    """Let an archived run say that it is of the last format before the first release."""
    with edited(path) as file:
        file["entry/archived/format"][()] = "tribopipe.archive/3"


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


def remove(path: str) -> Callable[[h5py.File], None]:
    """Return a change that takes a part away."""

    def change(file: h5py.File) -> None:
        del file[path]

    change.__name__ = f"remove {path}"
    return change


def put(path: str, value: object) -> Callable[[h5py.File], None]:
    """Return a change that puts something into a place, with the attributes of what was there."""

    def change(file: h5py.File) -> None:
        attributes = dict(file[path].attrs) if path in file else {}
        if path in file:
            del file[path]
        file[path] = value
        if attributes:  # what is put there may be a link to nowhere
            file[path].attrs.update(attributes)

    change.__name__ = f"put {path}"
    return change
