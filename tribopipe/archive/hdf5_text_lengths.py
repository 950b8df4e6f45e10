"""Lengths of the texts in an HDF5 file, from its bytes, before the library reads them.

A text of any length is kept apart; in its place stands a reference of 16 bytes. HDF5 takes the memory that such a
reference states the text needs, up to 4 GB, before it finds that there is no such text. The references of a field stand
in a row; those of an attribute in the header of what has it (HDF5 File Format Specification, "Data Object Headers").
"""

import os
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import h5py
import numpy as np
from numpy.typing import NDArray

from tribopipe.archive.file_signature import Stamp, stamp_of

_MOST_BYTES = 64 << 20
"""Bytes read at once: references to four million texts."""
_FARTHEST = 1 << 62
_MOST_PIECES = 64
_ATTRIBUTE, _CONTINUATION, _ATTRIBUTES_APART = 0x0C, 0x10, 0x15
"""Kinds of messages in a header."""
_SHARED = 2
"""Flag of a message that stands elsewhere."""
_NOWHERE = b"\xff" * 8
_WHOLE, _FLOATING, _FIXED_TEXT, _TEXT = 0, 1, 3, 9
"""Classes of types."""

_REFERENCE = np.dtype([("length", "<u4"), ("heap", "<u8"), ("number", "<u4")])
"""What stands for a text: how long it is, the place of the heap it is kept in, and its number there."""

Lengths = NDArray[np.uint32]


class RawFile:
    """The bytes of an open file, counted from where HDF5 begins in it. Raises ``ValueError`` where there are none."""

    def __init__(self, file: h5py.File) -> None:
        self._base = int(file.userblock_size)
        self._handle = int(file.id.get_vfd_handle())
        self._path = Path(file.filename)
        self._whole_heaps: set[int] = set()

    def read(self, place: int, size: int) -> bytes:
        """Return so many bytes."""
        if not 0 <= size <= _MOST_BYTES or place >= _FARTHEST:
            raise ValueError(f"{size:,} bytes at {place:,}, which is beyond all files")
        if hasattr(os, "pread"):
            found = os.pread(self._handle, size, self._base + place)
        else:  # on Windows, where nobody replaces a file that is open
            with self._path.open("rb") as file:
                file.seek(self._base + place)
                found = file.read(size)
        if len(found) != size:
            raise ValueError(f"the end of the file before {size:,} bytes at {place:,}")
        return found

    def stamp(self) -> Stamp:
        """Return size and time stamps of the file."""
        return stamp_of(os.fstat(self._handle) if hasattr(os, "pread") else self._path.stat())

    def text_lengths(self, dataset: h5py.h5d.DatasetID) -> Lengths:
        """Return how long the texts of a field state they are, bytes. Raises ``ValueError`` where it is packed."""
        size, place = dataset.get_storage_size(), dataset.get_offset()
        if size and place is None:
            raise ValueError("texts that are packed")
        return self.lengths(self.read(place - self._base, size) if size else b"")

    def lengths(self, references: bytes) -> Lengths:
        """Return what references to texts state about their lengths. Raises ``ValueError`` where HDF5 would fail."""
        found = np.frombuffer(references[: len(references) // _REFERENCE.itemsize * _REFERENCE.itemsize], _REFERENCE)
        for heap in set(found["heap"][found["length"] > 0].tolist()) - self._whole_heaps:
            self._check_heap(heap)
            self._whole_heaps.add(heap)
        lengths: Lengths = found["length"]
        return lengths

    def _check_heap(self, place: int) -> None:
        """Go through the texts at a place as HDF5 does, which never ends where one of them states it has no size."""
        name, size = struct.unpack("<4s4xQ", self.read(place, 16))
        content, at = self.read(place, size), 16
        while name == b"GCOL" and at + 16 <= size:
            number, length = struct.unpack_from("<H6xQ", content, at)
            at += 16 + -(-length // 8) * 8 if number else length
            if not number and length < 16:
                raise ValueError("texts among which HDF5 would go in circles")


class Attribute(NamedTuple):
    """An attribute as its header has it."""

    is_plain: bool
    """Whether it holds nothing but numbers and texts."""
    length: int
    """How long its texts state they are together, bytes."""


def attributes(file: RawFile, address: int) -> list[Attribute]:
    """Return the attributes in the header at an address.

    Raises ``ValueError`` or ``struct.error`` where it cannot be understood, or keeps any of it in another place.
    """
    return [_attribute(file, body) for kind, body in _messages(file, address) if kind == _ATTRIBUTE]


def _messages(file: RawFile, address: int) -> Iterator[tuple[int, bytes]]:
    """Return what a header states, by kinds, in however many pieces it is."""
    is_old = file.read(address, 4) != b"OHDR"
    head = struct.Struct("<HHB3x" if is_old else "<BHB")
    is_numbered = not is_old and file.read(address + 5, 1)[0] & 4
    pieces = [_first_piece(file, address, is_old=is_old)]
    for place, size in pieces:
        content, at = file.read(place, size), 0
        while (start := at + head.size + 2 * bool(is_numbered)) <= size:
            kind, length, flags = head.unpack_from(content, at)
            at = start + length
            body = content[start:at]
            if flags & _SHARED or (kind == _ATTRIBUTES_APART and not body.endswith(_NOWHERE)):
                raise ValueError("it keeps types or attributes in another place")
            if kind == _CONTINUATION:
                pieces.append(_further_piece(body, is_old=is_old))
            yield kind, body
        if len(pieces) > _MOST_PIECES:
            raise ValueError("its header has too many pieces")


def _first_piece(file: RawFile, address: int, *, is_old: bool) -> tuple[int, int]:
    """Return where a header's messages begin, and how many bytes they have."""
    if is_old:
        return address + 16, struct.unpack("<I", file.read(address + 8, 4))[0]
    flags = file.read(address + 5, 1)[0]
    start = address + 6 + 16 * (flags >> 5 & 1) + 4 * (flags >> 4 & 1)
    width = 1 << (flags & 3)
    return start + width, int.from_bytes(file.read(start, width), "little")


def _further_piece(body: bytes, *, is_old: bool) -> tuple[int, int]:
    """Return the same of a piece that a header goes on in; a new one begins with a name and ends with a checksum."""
    place, size = struct.unpack_from("<QQ", body)
    return (place, size) if is_old else (place + 4, size - 8)


def _attribute(file: RawFile, body: bytes) -> Attribute:
    version, flags, *sizes = struct.unpack_from("<BBHHH", body)
    name, kind, space = (-(-size // 8) * 8 for size in sizes) if version == 1 else sizes
    if version > 1 and flags:
        raise ValueError("it shares the type of an attribute")
    start = 8 + (version == 3) + name
    described = body[start] & 0x0F
    if described == _TEXT:
        lengths = file.lengths(body[start + kind + space :])
        return Attribute(is_plain=body[start + 1] & 0x0F == 1, length=int(lengths.sum(dtype=np.uint64)))
    return Attribute(is_plain=described in (_WHOLE, _FLOATING, _FIXED_TEXT), length=0)
