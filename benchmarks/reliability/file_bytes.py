"""What the bytes of an archived file are, by the blocks that the HDF5 file format is made of, and what HDF5 reads."""

import hashlib
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import h5py
import numpy as np

from tribopipe.archive.part_by_path import link_at
from tribopipe.archive.seal import SEAL_SIZE

_SUPERBLOCK = 96
_SIGNED = {b"OHDR": "header", b"OCHK": "header", b"GCOL": "text"} | dict.fromkeys(
    (b"TREE", b"SNOD", b"HEAP", b"BTHD", b"BTIN", b"BTLF", b"FRHP", b"FHDB", b"FHIB"), "tree or heap"
)
"""How blocks of the HDF5 file format begin, and what they hold."""


class Extent(NamedTuple):
    """Bytes of one kind, from the first one on."""

    start: int
    end: int
    kind: str


def extents(path: Path) -> list[Extent]:
    """Return what the bytes of a file are, in order and without gaps."""
    content = path.read_bytes()
    with h5py.File(path, "r", locking=False) as file:
        known = [Extent(0, SEAL_SIZE, "seal"), Extent(SEAL_SIZE, SEAL_SIZE + _SUPERBLOCK, "superblock"), *_stored(file)]
    taken = np.zeros(len(content), dtype=bool)
    for start, end, _ in known:
        taken[start:end] = True
    for signature, kind in _SIGNED.items():
        place = content.find(signature)
        while place >= 0:
            if not taken[place]:
                known.append(Extent(place, place + len(signature), kind))
            place = content.find(signature, place + 1)
    return list(_without_gaps(sorted(known), len(content)))


def _without_gaps(known: Sequence[Extent], size: int) -> Iterator[Extent]:
    """Let each kind that begins with a signature reach to where the next begins."""
    ends = [*(extent.start for extent in known[1:]), size]
    for extent, end in zip(known, ends, strict=True):
        if extent.kind in _SIGNED.values():
            yield Extent(extent.start, end, extent.kind)
        else:
            yield extent
            if extent.end < end:
                yield Extent(extent.end, end, "header")


def _stored(file: h5py.File) -> Iterator[Extent]:
    found: list[h5py.Dataset] = []
    file.visititems(lambda _, there: found.append(there) if isinstance(there, h5py.Dataset) else None)
    for dataset in found:
        source = dataset.name.startswith("/entry/source_files/") and dataset.name.endswith("/data")
        if dataset.chunks is None and dataset.id.get_offset() is not None:
            start = dataset.id.get_offset()
            yield Extent(start, start + dataset.id.get_storage_size(), "source file" if source else "small field")
        for number in range(dataset.id.get_num_chunks() if dataset.chunks else 0):
            chunk = dataset.id.get_chunk_info(number)
            kind = "source file" if source else "chunk of a column"
            yield Extent(chunk.byte_offset, chunk.byte_offset + chunk.size, kind)


def content(path: Path) -> dict[str, str]:
    """Return the SHA-256 of every part of a file as HDF5 reads it. Raises whatever HDF5 does."""
    with h5py.File(path, "r", locking=False) as file:
        return dict(_parts(file["/"], ""))


def _parts(group: h5py.Group, path: str) -> Iterator[tuple[str, str]]:
    yield f"{path}/", _sum(sorted(group.attrs.items()))
    for name in group:
        part, link = f"{path}/{name}", link_at(group, name)
        if not isinstance(link, h5py.HardLink):
            yield part, _sum(link.path if isinstance(link, h5py.SoftLink) else link)
            continue
        there = group[name]
        if isinstance(there, h5py.Group):
            yield from _parts(there, part)
        else:
            values = there[()]
            if isinstance(values, np.ndarray):
                values = values.tolist() if values.dtype == object else values.tobytes()
            yield part, _sum((there.dtype, there.shape, values, sorted(there.attrs.items())))


def _sum(told: Any) -> str:
    return hashlib.sha256(repr(told).encode("utf-8", "surrogateescape")).hexdigest()
