"""Chunks that tribopipe packs itself are those that HDF5 would have written, and any HDF5 reader checks them."""

import tracemalloc
from io import BytesIO
from itertools import pairwise

import h5py
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tribopipe.archive import nexus
from tribopipe.archive.file_access import written
from tribopipe.archive.hdf5_compression import CHUNK_BYTES, FILTERS, fletcher32, unpacked

KINDS = ("<f8", "<f4", "<i8", ">f8", "u1")


def numbers(rows: int, kind: str = "<f8", *more: int) -> np.ndarray:
    return np.random.default_rng(rows).integers(0, 200, (rows, *more)).astype(kind)


def by_hdf5(values: np.ndarray, chunks: tuple[int, ...]) -> bytes:
    """The first chunk of an array as HDF5 itself packs it."""
    with h5py.File(BytesIO(), "w") as file:
        made = file.create_dataset("x", data=values, chunks=chunks, **FILTERS)
        return made.id.read_direct_chunk((0,) * values.ndim)[1]


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("shape", [(256,), (70_000,), (131_072,), (300, 7), (10, 40, 30)])
def test_any_reader_of_hdf5_reads_and_checks_what_was_packed(kind, shape):
    values = numbers(shape[0], kind, *shape[1:])
    with h5py.File(BytesIO(), "w") as file:
        made = nexus.field(file, "x", values, "m")
        assert (made.compression, made.shuffle, made.fletcher32, made.dtype) == ("gzip", True, True, values.dtype)
        assert np.array_equal(made[()], values)
        assert np.array_equal(unpacked(made), values)
        assert made.id.get_num_chunks() == -(-values.nbytes // CHUNK_BYTES)


def test_a_flipped_byte_of_a_chunk_is_refused_by_hdf5():
    image = BytesIO()
    with h5py.File(image, "w") as file:
        chunk = nexus.field(file, "x", numbers(100_000)).id.get_chunk_info(1)
    for place in range(0, chunk.size, chunk.size // 50):
        damaged = bytearray(image.getvalue())
        damaged[chunk.byte_offset + place] ^= 1
        with h5py.File(BytesIO(damaged)) as file, pytest.raises(OSError, match="filter returned failure"):
            file["x"][-1]


@pytest.mark.slow
@given(
    st.binary(min_size=1, max_size=3000) | st.integers(1, 2000).map(bytes) | st.integers(1, 2000).map(b"\xff".__mul__)
)
@settings(max_examples=200, deadline=None)
def test_the_checksum_is_that_of_hdf5(content):
    with h5py.File(BytesIO(), "w") as file:
        made = file.create_dataset("x", data=np.frombuffer(content, "u1"), chunks=(len(content),), fletcher32=True)
        stored = made.id.read_direct_chunk((0,))[1]
    assert stored == content + fletcher32(content).to_bytes(4, "little")


@given(st.lists(st.integers(0, 150_000), max_size=6), st.sampled_from(KINDS))
@settings(max_examples=25, deadline=None)
def test_pieces_of_any_length_give_the_bytes_of_the_whole(lengths, kind):
    values = numbers(sum(lengths), kind)
    ends = np.cumsum([0, *lengths])
    whole, by_pieces = BytesIO(), BytesIO()
    with h5py.File(whole, "w") as file:
        nexus.field(file, "x", values)
    with h5py.File(by_pieces, "w") as file:
        pieces = (values[start:end] for start, end in pairwise(ends))
        nexus.long_field(file, "x", pieces, len(values), kind)
    assert whole.getvalue() == by_pieces.getvalue()


@pytest.mark.parametrize("rows", [100, 299, 301, 70_000])
def test_pieces_that_are_not_as_long_as_said_are_refused(rows):
    with h5py.File(BytesIO(), "w") as file, pytest.raises(ValueError, match="rows"):
        nexus.long_field(file, "x", iter([numbers(rows)]), 300 if rows > 100 else 99, "<f8")


def test_memory_does_not_grow_with_the_length_of_a_field(tmp_path):
    piece, peaks = numbers(100_000), []
    for count in (20, 60):
        with written(tmp_path / "run.h5", 512) as file:
            tracemalloc.start()
            nexus.long_field(file, "x", (piece for _ in range(count)), count * len(piece), "<f8")
            peaks.append(tracemalloc.get_traced_memory()[1])
            tracemalloc.stop()
    assert peaks[1] < 1.2 * peaks[0] < 16e6
