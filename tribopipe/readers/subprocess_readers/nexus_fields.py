"""Recorded data of a run archived by tribopipe.

The answer is a line of JSON (format, manifest, headers, columns), then the numbers of the columns as float64. Links to
other files, virtual datasets and external storage are refused; so are arrays larger than the file could hold.
"""

import io
import json
import sys
from collections.abc import Iterator
from typing import Any

import h5py
import numpy as np

_MOST_COMPRESSED = 1100
"""Deflate cannot pack numbers more densely than by this factor."""


def main() -> None:
    """Answer with the run, or end with what is wrong."""
    content = sys.stdin.buffer.read()
    try:
        with h5py.File(io.BytesIO(content), "r") as file:
            said, numbers = _run(_File(file, most=_MOST_COMPRESSED * len(content)))
    except Exception as error:  # noqa: BLE001 - HDF5 raises whatever a damaged file makes it stumble on
        sys.exit(f"{type(error).__name__}: {error}".replace("\n", " "))
    sys.stdout.buffer.write(json.dumps(said).encode("ascii") + b"\n")
    for values in numbers:
        sys.stdout.buffer.write(values.tobytes())


class _File:
    """An open file, of which nothing but its own content is read."""

    def __init__(self, file: Any, most: int) -> None:
        self.file = file
        self.most = most

    def names(self, path: str) -> list[str]:
        """Name the members of a group; none where there is no such group."""
        parent, _, name = path.rpartition("/")
        return list(self.member(path)) if name in self.member(parent) else []

    def member(self, path: str) -> Any:
        """Give a group or dataset, going from the root by hard links alone."""
        place = self.file
        for name in filter(None, path.split("/")):
            link = place.get(name, getlink=True)
            if not isinstance(link, h5py.HardLink):
                raise ValueError(f"{'no' if link is None else 'a link instead of'} {path}")
            place = place[name]
        return place

    def dataset(self, path: str, rank: int) -> Any:
        """Give a dataset that is whole and written in this file."""
        found = self.member(path)
        if found.is_virtual or found.external:
            raise ValueError(f"numbers of {path} kept in another file")
        if found.ndim != rank or found.nbytes > self.most:
            raise ValueError(f"{path} of the shape {found.shape}")
        if found.size and not found.id.get_storage_size():
            raise ValueError(f"{path} declared, but never written")
        return found

    def text(self, path: str) -> str:
        """Read a single text."""
        return str(self.dataset(path, rank=0).asstr()[()])


def _run(file: _File) -> tuple[dict[str, Any], list[Any]]:
    columns, numbers = [], []
    for name, path, unit in (*_signals(file), *_extras(file)):
        dataset = file.dataset(path, rank=1)
        is_number = dataset.dtype.kind in "fiub"
        numbers += [np.asarray(dataset[()], dtype="<f8")] if is_number else []
        columns.append(
            {
                "name": name,
                "unit": unit,
                "is_signal": path.startswith("entry/raw/"),
                "rows": len(dataset),
                "texts": None if is_number else dataset.asstr()[()].tolist(),
            }
        )
    headers = [f"entry/source_files/{name}/description" for name in file.names("entry/source_files")]
    said = {
        "format": file.text("entry/archived/format"),
        "manifest": json.loads(file.text("entry/manifest/data")),
        "headers": [file.text(path) for path in headers if "description" in file.member(path.rpartition("/")[0])],
        "columns": columns,
    }
    return said, numbers


def _signals(file: _File) -> Iterator[tuple[str, str, str]]:
    """Give name, path and unit of each signal that was measured."""
    for name in file.member("entry/raw"):
        path = f"entry/raw/{name}"
        said = file.dataset(path, rank=1).attrs
        if said["origin"] == "measured":
            yield name, path, str(said["units"])


def _extras(file: _File) -> Iterator[tuple[str, str, str]]:
    for key in file.names("entry/extra_columns"):
        path = f"entry/extra_columns/{key}"
        said = file.dataset(path, rank=1).attrs
        yield str(said["column_name"]), path, str(said["column_unit"])


if __name__ == "__main__":
    main()
