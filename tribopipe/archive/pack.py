"""Arrays packed into the chunks of HDF5 datasets by several threads, which HDF5 itself does in one.

A chunk is what HDF5 makes of it, by the filters that the dataset names: its bytes shuffled, deflated, and a checksum
after them. Any HDF5 reader unpacks and checks it. Deflated is by ISA-L, whose streams are zlib's: in an eighth of
the time of its level 4, to a fiftieth more bytes.
"""

from collections.abc import Iterable, Iterator, Mapping
from typing import Any, NamedTuple, NoReturn, TypeVar

import h5py
import numpy as np
from isal import isal_zlib
from numpy.typing import NDArray

from tribopipe.archive.thread_pool import in_turn

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
    for place, packed in in_turn(lambda chunk: (chunk, _packed(chunk.rows)), _chunks(datasets, blocks)):
        place.dataset.id.write_direct_chunk(place.start, packed)


class _Chunk(NamedTuple):
    dataset: h5py.Dataset
    start: tuple[int, ...]
    rows: NDArray[Any]


def _chunks(datasets: Mapping[Name, h5py.Dataset], blocks: Iterable[Mapping[Name, NDArray[Any]]]) -> Iterator[_Chunk]:
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
