"""Arrays of archived files, unpacked without ever taking more memory than they say they need.

HDF5 unpacks a chunk however long it turns out: half a megabyte may become half a gigabyte.
"""

import zlib
from itertools import product
from math import prod
from typing import Any

import h5py
import numpy as np
from h5py import h5z
from numpy.typing import NDArray

from tribopipe.errors import ArchiveError


def unpacked(dataset: h5py.Dataset, last: int | None = None) -> NDArray[Any]:
    """Return all values, or those of so many rows at the end.

    Raises ``ArchiveError`` where there are other ones than the dataset says it has.
    """
    first = 0 if last is None else max(len(dataset) - last, 0)
    if not _is_packed(dataset):
        return np.asarray(dataset[first:] if first else dataset[()])
    found, offsets = np.empty(dataset.shape, dataset.dtype), _offsets(dataset)
    grid = [range(0, end, length) for end, length in zip(dataset.shape, dataset.chunks, strict=True)]
    if len(offsets) != prod(map(len, grid)) or offsets != set(product(*grid)):
        raise _damaged(dataset, f"other chunks, {len(offsets):,} of them")
    for offset in offsets:
        if offset[0] + dataset.chunks[0] > first:
            _put(found, dataset.chunks, offset, _content(dataset, offset))
    return found[first:]


def _put(found: NDArray[Any], chunks: tuple[int, ...], offset: tuple[int, ...], content: bytes) -> None:
    """Put the values of a chunk in their place; those beyond the ends of the array are left out."""
    whole = _unshuffled(content, found.dtype).reshape(chunks)
    wanted = tuple(min(length, end - start) for start, length, end in zip(offset, chunks, found.shape, strict=True))
    place = tuple(slice(start, start + length) for start, length in zip(offset, wanted, strict=True))
    found[place] = whole[tuple(map(slice, wanted))]


def check_packed(dataset: h5py.Dataset) -> None:
    """Raise ``ArchiveError`` where an array unpacks to other sizes than it says, for who reads it by other ways."""
    if _is_packed(dataset):
        for offset in _offsets(dataset):
            _content(dataset, offset)


def _is_packed(dataset: h5py.Dataset) -> bool:
    made = dataset.id.get_create_plist()
    return h5z.FILTER_DEFLATE in (made.get_filter(number)[0] for number in range(made.get_nfilters()))


def _offsets(dataset: h5py.Dataset) -> set[tuple[int, ...]]:
    """Return where the chunks begin that were written of an array."""
    offsets: set[tuple[int, ...]] = set()
    dataset.id.chunk_iter(lambda chunk: offsets.add(chunk.chunk_offset))
    return offsets


def _content(dataset: h5py.Dataset, offset: tuple[int, ...]) -> bytes:
    """Return the bytes of a chunk; the checksum after them is left to those who verify."""
    size = prod(dataset.chunks) * dataset.dtype.itemsize
    left_out, packed = dataset.id.read_direct_chunk(offset)
    unpacking = zlib.decompressobj()
    try:
        content = unpacking.decompress(packed, size + 1)
    except zlib.error as error:
        raise _damaged(dataset, f"a chunk that cannot be unpacked ({error})") from None
    if left_out or len(content) != size or not unpacking.eof:
        raise _damaged(dataset, f"a chunk of another size than {size:,} bytes")
    return content


def _unshuffled(content: bytes, kind: np.dtype[Any]) -> NDArray[Any]:
    """Return values whose first bytes stand first, then their second bytes, and so on."""
    planes = np.frombuffer(content, np.uint8).reshape(kind.itemsize, -1)
    return np.ascontiguousarray(planes.T).view(kind).ravel()


def _damaged(dataset: h5py.Dataset, found: str) -> ArchiveError:
    return ArchiveError(
        f"{dataset.file.filename}: found {found} at {dataset.name}; expected as many values as the file says, "
        f"{dataset.shape}; restore it from a copy"
    )
