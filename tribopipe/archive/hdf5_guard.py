"""Whether an HDF5 file holds nothing but what tribopipe writes, so that all of it can be read within bounds.

A file may come from anybody, and its seal too. HDF5 can show what other files hold, lead in circles, nest without end,
and state in a few bytes that it holds more than any memory does. tribopipe writes none of these. A file is looked
through once before anything else is read of it; what passes can be read by ordinary means, but for compressed arrays,
for which see ``tribopipe.archive.hdf5_compression``.

Texts are measured from the bytes of the file, before the library reads them. A text of any length is kept apart; in
its place stands a reference of 16 bytes. HDF5 takes the memory that such a reference states the text needs, up to 4
GB, before it finds that there is no such text. The references of a field stand in a row; those of an attribute in the
header of what has it (HDF5 File Format Specification, "Data Object Headers").
"""

import os
import struct
from collections.abc import Iterable, Iterator, Mapping
from math import prod
from pathlib import Path
from typing import NamedTuple, NoReturn

import h5py
import numpy as np
from h5py import h5d, h5g, h5l, h5o, h5p, h5t, h5z
from numpy.typing import NDArray

from tribopipe.archive.file_signature import Stamp, stamp_of
from tribopipe.archive.remote_blocks import blocks_named
from tribopipe.base.errors import ArchiveError

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
        self._blocks = blocks_named(file.filename)
        self._handle = -1 if self._blocks is not None else int(file.id.get_vfd_handle())
        self._path = Path(file.filename)
        self._whole_heaps: set[int] = set()

    def read(self, place: int, size: int) -> bytes:
        """Return so many bytes."""
        if not 0 <= size <= _MOST_BYTES or place >= _FARTHEST:
            raise ValueError(f"{size:,} bytes at {place:,}, beyond the end of any file")
        if self._blocks is not None:
            found = self._blocks.read_at(self._base + place, size)
        elif hasattr(os, "pread"):
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
        if self._blocks is not None:
            return Stamp(self._blocks.size, 0, 0, 0)
        return stamp_of(os.fstat(self._handle) if hasattr(os, "pread") else self._path.stat())

    def text_lengths(self, dataset: h5py.h5d.DatasetID) -> Lengths:
        """Return how long the texts of a field state they are, bytes. Raises ``ValueError`` where it is packed."""
        size, place = dataset.get_storage_size(), dataset.get_offset()
        if size and place is None:
            raise ValueError("compressed text")
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
                raise ValueError("text references that form a loop")


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
                raise ValueError("types or attributes are stored elsewhere")
            if kind == _CONTINUATION:
                pieces.append(_further_piece(body, is_old=is_old))
            yield kind, body
        if len(pieces) > _MOST_PIECES:
            raise ValueError("the header has too many blocks")


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
        raise ValueError("the type of an attribute is shared")
    start = 8 + (version == 3) + name
    described = body[start] & 0x0F
    if described == _TEXT:
        lengths = file.lengths(body[start + kind + space :])
        return Attribute(is_plain=body[start + 1] & 0x0F == 1, length=int(lengths.sum(dtype=np.uint64)))
    return Attribute(is_plain=described in (_WHOLE, _FLOATING, _FIXED_TEXT), length=0)


Shapes = Mapping[str, tuple[int, ...]]
"""Shapes of datasets by path."""
MOST_TEXT = 4 << 20
"""Bytes of a text, and of all texts that are attributes of one part."""
MOST_CHUNK = 16 << 20
"""Bytes that have to be unpacked for the least of an array's values."""
_MOST_PARTS, _MOST_LEVELS, _MOST_ATTRIBUTES = 20_000, 16, 64
_ROOM, _ROOM_A_BYTE = 64 << 20, 40
"""Bytes of values in a file, however small it is, and those more for each of its bytes. The sample runs have two for
each of their bytes; one number over and over packs into a thousandth."""
_TEXT_OBJECT = 64
"""Bytes that a text takes in memory in addition to its own."""
_LONGEST_NUMBER = 8
_FILTERS = [h5z.FILTER_SHUFFLE, h5z.FILTER_DEFLATE, h5z.FILTER_FLETCHER32]
_MOST_KNOWN = 1000
_known: dict[str, tuple[Stamp, Shapes]] = {}
"""What was found in files that this process looked through, and how they looked then."""


def own_datasets(file: h5py.File) -> Shapes:
    """Return the shapes of all datasets of a file by their paths; soft links are not followed.

    A file that was looked through is known again by its stamp. Raises ``ArchiveError`` where the file holds something
    else than tribopipe writes, or more than it has room for.
    """
    stamp = RawFile(file).stamp()
    known = _known.get(file.filename)
    if known is None or known[0] != stamp:
        if len(_known) >= _MOST_KNOWN:
            _known.clear()
        known = _known[file.filename] = stamp, _Look(file).through()
    return known[1]


def was_looked_through(file: h5py.File) -> bool:
    """Return whether a file is one that was looked through, and has not changed since."""
    known = _known.get(file.filename)
    return known is not None and known[0] == RawFile(file).stamp()


def renamed(part: Path, path: Path, stamp: Stamp) -> None:
    """Keep what was found in a file, now that it has another name and so another stamp."""
    _, shapes = _known.pop(str(part))
    _known[str(path)] = stamp, shapes


def check_attributes(part: h5py.Group | h5py.Dataset | h5py.Datatype) -> None:
    """Raise ``ArchiveError`` where something has more attributes, or longer ones, than tribopipe writes."""
    _Look(part.file).attributes(str(part.name), h5o.get_info(part.id).addr)


def check_parts(file: h5py.File, paths: Iterable[str]) -> None:
    """Look at some datasets alone, which takes a tenth of the time; those that are not there are passed over.

    What is stated about them in attributes is not looked at. Raises ``ArchiveError`` as ``own_datasets`` does.
    """
    look = _Look(file)
    for path in paths:
        look.at(path)


class _Look:
    """One look through a file."""

    def __init__(self, file: h5py.File) -> None:
        self._file, self._raw = file, RawFile(file)
        self._root = h5o.open(file.id, b"/")
        self._size = self._raw.stamp().size
        self._room = _ROOM + _ROOM_A_BYTE * self._size
        self._seen: set[int] = set()
        self._shapes: dict[str, tuple[int, ...]] = {}
        self._waiting: list[tuple[str, h5g.GroupID]] = []
        if file.id.get_create_plist().get_sizes() != (8, 8):
            self._refuse("/", "addresses that are not 8 bytes long")

    def through(self) -> Shapes:
        """Return the shapes of all datasets. Raises ``ArchiveError`` at the first foreign one."""
        self.attributes("/", h5o.get_info(self._root).addr)
        self._waiting.append(("", self._root))
        while self._waiting:
            self._group(*self._waiting.pop())
        return self._shapes

    def at(self, path: str) -> None:
        """Look at a dataset, going there by hard links alone."""
        place, so_far = self._root, ""
        for name in path.split("/"):
            if not isinstance(place, h5g.GroupID) or not place.links.exists(name.encode()):
                return
            so_far += f"/{name}"
            if place.links.get_info(name.encode()).type != h5l.TYPE_HARD:
                self._refuse(so_far, "a link")
            place = h5o.open(place, name.encode())
        if isinstance(place, h5d.DatasetID):
            self._dataset(so_far, place)

    def _group(self, path: str, group: h5g.GroupID) -> None:
        if path.count("/") > _MOST_LEVELS:
            self._refuse(path, f"groups nested more than {_MOST_LEVELS} levels deep")
        if len(self._seen) + group.get_num_objs() > _MOST_PARTS:
            self._refuse(path, f"more than {_MOST_PARTS:,} objects")
        links: list[tuple[bytes, int, int]] = []
        group.links.iterate(lambda name, link: links.append((name, link.type, link.u)), info=True)
        for name, kind, address in links:
            if kind != h5l.TYPE_SOFT:
                part = f"{path}/{name.decode(errors='replace')}"
                self._link(part, kind, address)
                self._part(part, h5o.open(group, name))

    def _link(self, path: str, kind: int, address: int) -> None:
        """Look at what a link leads to, as far as can be seen before HDF5 opens it."""
        if kind != h5l.TYPE_HARD:
            self._refuse(path, "a link to another file")
        if address in self._seen:
            self._refuse(path, "an object with more than one hard link")
        self._seen.add(address)
        self.attributes(path, address)

    def _part(self, path: str, part: object) -> None:
        if isinstance(part, h5g.GroupID):
            self._waiting.append((path, part))
        elif isinstance(part, h5d.DatasetID):
            self._dataset(path, part)
        else:
            self._refuse(path, "a named datatype")

    def attributes(self, path: str, address: int) -> None:
        """Look at the attributes of a part where they are written, before HDF5 reads any of them."""
        try:
            found = attributes(self._raw, address)
        except (IndexError, ValueError, struct.error) as error:
            self._refuse(path, f"a header that tribopipe never writes ({error})")
        if len(found) > _MOST_ATTRIBUTES:
            self._refuse(path, f"more than {_MOST_ATTRIBUTES} attributes")
        if sum(attribute.length for attribute in found) > MOST_TEXT:
            self._refuse(path, f"attributes of more than {MOST_TEXT:,} bytes")
        if not all(attribute.is_plain for attribute in found):
            self._refuse(path, "an attribute that is neither a number nor text")

    def _dataset(self, path: str, dataset: h5d.DatasetID) -> None:
        made, kind = dataset.get_create_plist(), dataset.get_type()
        if elsewhere := _elsewhere(made):
            self._refuse(path, elsewhere)
        if dataset.shape is None:
            self._refuse(path, "a dataset without a shape")
        if kind.get_class() == h5t.STRING and kind.is_variable_str():
            self._room -= self._texts(path, dataset)
        else:
            self._room -= self._values(path, dataset, made, kind)
        if self._room < 0:
            self._refuse(path, f"more values than a file of {self._size:,} bytes can contain")
        self._shapes[path] = dataset.shape

    def _texts(self, path: str, dataset: h5d.DatasetID) -> int:
        """Return the memory, in bytes, that the texts of a dataset need."""
        try:
            lengths = self._raw.text_lengths(dataset)
        except ValueError as error:
            self._refuse(path, f"text that cannot be located ({error})")
        if (lengths > MOST_TEXT).any() or len(lengths) != prod(dataset.shape):
            self._refuse(
                path, f"text of more than {MOST_TEXT:,} bytes, or with a length that differs from the declared one"
            )
        return int(lengths.sum(dtype=np.uint64)) + _TEXT_OBJECT * len(lengths)

    def _values(self, path: str, dataset: h5d.DatasetID, made: h5p.PropDCID, kind: h5t.TypeID) -> int:
        """Return how many bytes the numbers of a dataset, or texts of one length, take in memory."""
        size, is_text = kind.get_size(), kind.get_class() == h5t.STRING
        if not is_text and (kind.get_class() not in (h5t.INTEGER, h5t.FLOAT) or size > _LONGEST_NUMBER):
            self._refuse(path, "values that are neither numbers of at most 8 bytes nor text")
        if size > MOST_TEXT:
            self._refuse(path, f"text of {size:,} bytes")
        declared, stored = int(prod(dataset.shape) * size), int(dataset.get_storage_size())
        if made.get_layout() == h5d.CHUNKED:
            self._packed(path, made, size)
        elif declared != stored or stored > self._size:
            self._refuse(path, f"{stored:,} bytes of data where {declared:,} are declared")
        if declared and not stored:
            self._refuse(path, "values that were never written")
        return declared

    def _packed(self, path: str, made: h5p.PropDCID, size: int) -> None:
        filters = [made.get_filter(number)[0] for number in range(made.get_nfilters())]
        if filters not in ([], _FILTERS):
            self._refuse(path, "values compressed with a filter that tribopipe does not use")
        if prod(made.get_chunk()) * size > MOST_CHUNK:
            self._refuse(path, f"chunks of more than {MOST_CHUNK:,} bytes")

    def _refuse(self, path: str, found: str) -> NoReturn:
        raise ArchiveError(
            f"{self._file.filename}: found {found} at {path}; expected only content that tribopipe writes; move "
            "the file out of the archive"
        )


def storage_elsewhere(dataset: h5d.DatasetID) -> str | None:
    """Report what makes the values of a dataset come from another file; none where they are in its own."""
    return _elsewhere(dataset.get_create_plist())


def _elsewhere(made: h5p.PropDCID) -> str | None:
    if made.get_layout() == h5d.VIRTUAL:
        return "a virtual dataset"
    return "a dataset stored in another file" if made.get_external_count() else None
