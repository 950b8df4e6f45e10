"""Arrays of archived files, unpacked without ever taking more memory than they state they need.

HDF5 unpacks a chunk however long it turns out: half a megabyte may become half a gigabyte.
"""

import zlib
from collections.abc import Iterator, Sequence
from itertools import product
from math import prod
from typing import Any

import h5py
import numpy as np
from h5py import h5z
from numpy.typing import NDArray

from tribopipe.archive.thread_pool import in_turn
from tribopipe.base.errors import ArchiveError


def unpacked(dataset: h5py.Dataset, last: int | None = None) -> NDArray[Any]:
    """Return all values, or those of so many rows at the end.

    Raises ``ArchiveError`` where there are other ones than the dataset states it has.
    """
    first = 0 if last is None else max(len(dataset) - last, 0)
    if not _is_packed(dataset):
        return np.asarray(dataset[first:] if first else dataset[()])
    found, length = np.empty(dataset.shape, dataset.dtype), dataset.chunks[0]
    offsets = [offset for offset in _all_offsets(dataset) if offset[0] + length > first]
    for offset, values in zip(offsets, _chunks(dataset, offsets), strict=True):
        _put(found, offset, values)
    return found[first:]


def unpacked_pieces(dataset: h5py.Dataset) -> Iterator[NDArray[Any]]:
    """Yield the values of a column in chunks, to limit memory. Raises the same errors as ``unpacked``."""
    if not _is_packed(dataset):
        yield np.asarray(dataset[()])
        return
    offsets, rows = _all_offsets(dataset), len(dataset)
    for (start, *_), values in zip(offsets, _chunks(dataset, offsets), strict=True):
        yield values[: rows - start]


def _chunks(dataset: h5py.Dataset, offsets: Sequence[tuple[int, ...]]) -> Iterator[NDArray[Any]]:
    """Yield the values of some chunks."""
    kind, shape = dataset.dtype, dataset.chunks
    size = prod(shape) * kind.itemsize
    packed = (dataset.id.read_direct_chunk(offset) for offset in offsets)
    return in_turn(lambda chunk: _unshuffled(_content(dataset, size, *chunk), kind).reshape(shape), packed)


def _put(found: NDArray[Any], offset: tuple[int, ...], values: NDArray[Any]) -> None:
    """Put the values of a chunk in their place; those beyond the ends of the array are left out."""
    place = tuple(slice(start, start + length) for start, length in zip(offset, values.shape, strict=True))
    wanted = found[place].shape
    found[place] = values[tuple(map(slice, wanted))]


def check_packed(dataset: h5py.Dataset) -> None:
    """Raise ``ArchiveError`` where an array unpacks to other sizes than it states, for who reads it by other ways."""
    if _is_packed(dataset):
        size = prod(dataset.chunks) * dataset.dtype.itemsize
        for offset in _offsets(dataset):
            _content(dataset, size, *dataset.id.read_direct_chunk(offset))


def _is_packed(dataset: h5py.Dataset) -> bool:
    made = dataset.id.get_create_plist()
    return h5z.FILTER_DEFLATE in (made.get_filter(number)[0] for number in range(made.get_nfilters()))


def _all_offsets(dataset: h5py.Dataset) -> list[tuple[int, ...]]:
    """Return where chunks begin, in order. Raises ``ArchiveError`` where some are missing, or others there."""
    offsets = _offsets(dataset)
    grid = [range(0, end, length) for end, length in zip(dataset.shape, dataset.chunks, strict=True)]
    if len(offsets) != prod(map(len, grid)) or offsets != set(product(*grid)):
        raise _damaged(dataset, f"other chunks, {len(offsets):,} of them")
    return sorted(offsets)


def _offsets(dataset: h5py.Dataset) -> set[tuple[int, ...]]:
    """Return where the chunks begin that were written of an array."""
    offsets: set[tuple[int, ...]] = set()
    dataset.id.chunk_iter(lambda chunk: offsets.add(chunk.chunk_offset))
    return offsets


def _content(dataset: h5py.Dataset, size: int, left_out: int, packed: bytes) -> bytes:
    """Return the bytes of a chunk; the checksum after them is left to those who verify."""
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
        f"{dataset.file.filename}: found {found} at {dataset.name}; expected as many values as declared in the file, "
        f"{dataset.shape}; restore it from a copy"
    )
