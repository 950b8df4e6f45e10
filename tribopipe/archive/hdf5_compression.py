"""Arrays compressed into the chunks of HDF5 datasets and decompressed from them, by several threads.

HDF5 itself uses one thread. A chunk is what HDF5 makes of it, by the filters that the dataset names: its bytes
shuffled, deflated, and a checksum after them. Any HDF5 reader unpacks and checks it. Deflated is by ISA-L, whose
streams are zlib's: in an eighth of the time of its level 4, to a fiftieth more bytes.

HDF5 unpacks a chunk however long it turns out: half a megabyte may become half a gigabyte. Here an array never takes
more memory than it states it needs.
"""

import os
import zlib
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from itertools import islice, product
from math import prod
from typing import Any, NamedTuple, NoReturn, TypeVar

import h5py
import numpy as np
from h5py import h5z
from isal import isal_zlib
from numpy.typing import NDArray

from tribopipe.base.errors import ArchiveError

Item = TypeVar("Item")
Answer = TypeVar("Answer")
_THREADS = min(os.cpu_count() or 1, 4)


def _in_threads(work: Callable[[Item], Answer], items: Iterable[Item]) -> Iterator[Answer]:
    """Yield the result of each item in order; several items run in parallel, a single one in this thread."""
    coming = iter(items)
    first = list(islice(coming, 2))
    if len(first) < 2:
        yield from map(work, first)
        return
    with ThreadPoolExecutor(_THREADS) as pool:
        waiting: deque[Future[Answer]] = deque(pool.submit(work, item) for item in first)
        for item in coming:
            waiting.append(pool.submit(work, item))
            if len(waiting) > _THREADS:
                yield waiting.popleft().result()
        while waiting:
            yield waiting.popleft().result()


Name = TypeVar("Name", bound=str)
CHUNK_BYTES = 1 << 19
FILTERS: dict[str, Any] = {"compression": "gzip", "compression_opts": 4, "shuffle": True, "fletcher32": True}
"""What a dataset states about its chunks. The level is that of zlib for who writes more of them; readers need none."""
_LEVEL_OF_TEXT, _LEVEL_OF_NUMBERS = 3, 2
"""Of ISA-L; shuffled numbers come out no smaller at 3, in twice the time."""
_COUNTS = np.arange(1 << 16, 0, -1, dtype=np.float64)
"""How often each of so many words is in the second sum of their checksum."""


def chunk_shape(shape: tuple[int, ...], kind: np.dtype[Any]) -> tuple[int, ...]:
    """Return the chunk shape of an array: complete rows of about half a megabyte, at least one."""
    row = max(int(np.prod(shape[1:])) * kind.itemsize, 1)
    return (max(1, min(shape[0], CHUNK_BYTES // row)), *shape[1:])


def write_packed(dataset: h5py.Dataset, pieces: Iterable[NDArray[Any]]) -> None:
    """Fill a dataset whose chunks are of whole rows with rows in their order, in pieces of any length.

    Raises ``ValueError`` where there are more or fewer rows than the dataset has.
    """
    write_together({"": dataset}, ({"": piece} for piece in pieces))


def write_together(datasets: Mapping[Name, h5py.Dataset], blocks: Iterable[Mapping[Name, NDArray[Any]]]) -> None:
    """Fill several datasets whose rows come together: each block has rows of some of them, by their names.

    Raises ``ValueError`` where there are more or fewer rows than a dataset has.
    """
    for place, packed in _in_threads(lambda chunk: (chunk, _packed(chunk.rows)), _filled_chunks(datasets, blocks)):
        place.dataset.id.write_direct_chunk(place.start, packed)


class _Chunk(NamedTuple):
    dataset: h5py.Dataset
    start: tuple[int, ...]
    rows: NDArray[Any]


def _filled_chunks(
    datasets: Mapping[Name, h5py.Dataset], blocks: Iterable[Mapping[Name, NDArray[Any]]]
) -> Iterator[_Chunk]:
    fillings = {name: _Filling(dataset) for name, dataset in datasets.items()}
    for block in blocks:
        for name, piece in block.items():
            yield from fillings[name].add(piece)
    for filling in fillings.values():
        yield from filling.finish()


class _Filling:
    """Rows on their way into the chunks of a dataset."""

    def __init__(self, dataset: h5py.Dataset) -> None:
        self._dataset, self._left, self._start, self._filled = dataset, len(dataset), 0, 0
        self._rows = np.zeros(dataset.chunks, dataset.dtype)

    def add(self, piece: NDArray[Any]) -> Iterator[_Chunk]:
        """Add rows, and give the chunks that they fill."""
        self._left -= len(piece)
        if self._left < 0:
            self._refuse()
        while len(piece):
            part = piece[: len(self._rows) - self._filled]
            self._rows[self._filled : self._filled + len(part)] = part
            self._filled, piece = self._filled + len(part), piece[len(part) :]
            if self._filled == len(self._rows):
                yield self._taken()

    def finish(self) -> Iterator[_Chunk]:
        """Give the last chunk, filled up with zeros, where rows are left."""
        if self._left:
            self._refuse()
        if self._filled:
            yield self._taken()

    def _taken(self) -> _Chunk:
        chunk = _Chunk(self._dataset, (self._start, *[0] * (self._rows.ndim - 1)), self._rows)
        self._start, self._filled = self._start + len(self._rows), 0
        self._rows = np.zeros_like(self._rows)
        return chunk

    def _refuse(self) -> NoReturn:
        name, rows = self._dataset.name, len(self._dataset)
        raise ValueError(f"{rows - self._left:,} rows or more where {name} has {rows:,}")


def _packed(chunk: NDArray[Any]) -> bytes:
    """Return what HDF5 would keep of a chunk: shuffled, deflated, with its checksum after it."""
    planes = chunk.reshape(-1).view(np.uint8).reshape(-1, chunk.dtype.itemsize).T
    level = _LEVEL_OF_TEXT if chunk.dtype.itemsize == 1 else _LEVEL_OF_NUMBERS
    deflated: bytes = isal_zlib.compress(np.ascontiguousarray(planes), level)
    return deflated + fletcher32(deflated).to_bytes(4, "little")


def fletcher32(content: bytes) -> int:
    """Return the checksum that HDF5 keeps after a chunk: two sums modulo 65 535 over words of two bytes.

    As HDF5 has it, a sum that is a multiple of 65 535 is that number itself, unless nothing was added. Words are added
    with their bytes the other way round, which is modulo 65 535 to multiply by 256, in numbers that hold all sums.
    """
    words = np.frombuffer(content + bytes(len(content) % 2), "<u2")
    first = second = 0
    for start in range(0, len(words), len(_COUNTS)):
        block = words[start : start + len(_COUNTS)].astype(np.float64)
        second += first * len(block) + int(np.einsum("i,i->", block, _COUNTS[-len(block) :]))
        first += int(block.sum())
    return _folded(256 * second) << 16 | _folded(256 * first)


def _folded(total: int) -> int:
    return (total - 1) % 65_535 + 1 if total else 0


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
    return _in_threads(lambda chunk: _unshuffled(_content(dataset, size, *chunk), kind).reshape(shape), packed)


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
        raise _damaged(dataset, f"{len(offsets):,} chunks that do not match the shape")
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
        raise _damaged(dataset, f"a chunk whose size is not {size:,} bytes")
    return content


def _unshuffled(content: bytes, kind: np.dtype[Any]) -> NDArray[Any]:
    """Return values whose first bytes stand first, then their second bytes, and so on."""
    planes = np.frombuffer(content, np.uint8).reshape(kind.itemsize, -1)
    return np.ascontiguousarray(planes.T).view(kind).ravel()


def _damaged(dataset: h5py.Dataset, found: str) -> ArchiveError:
    return ArchiveError(
        f"{dataset.file.filename}: found {found} at {dataset.name}; expected the declared shape "
        f"{dataset.shape}; restore the file from a backup"
    )
