"""Archived files that somebody made to do harm, each from a good one: what they are is in their names.

They are sealed, as anybody can compute a SHA-256.
"""

import json
import os
import re
import shutil
import struct
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from tribopipe.archive.seal import SEAL_SIZE, seal_file

DEPTH, MANIFEST = "entry/raw/depth", "entry/manifest/data"
RESULT, FINDINGS = "entry/friction_fit/result/data", "entry/findings/data"
_CHUNK = 65_536
_NO_CHECKSUM = 1 << 2
"""Says that the third way of packing was left out of a chunk."""

Spoil = Callable[[h5py.File], object]


def _other(file: h5py.File, path: str = DEPTH, **made: Any) -> h5py.Dataset:
    """Put another dataset in the place of one, with its attributes; of the depths where nothing is said."""
    said, length = dict(file[path].attrs), len(file[DEPTH]) if DEPTH in file else 0
    del file[path]
    dataset = file.create_dataset(path, **({"shape": (length,)} | made if "data" not in made else made))
    dataset.attrs.update(said)
    return dataset


def _made(**made: Any) -> Spoil:
    """Put another dataset in the place of the depths."""

    def spoil(file: h5py.File) -> None:
        _other(file, **made)

    return spoil


def _values(kind: Any) -> Spoil:
    """Give the depths another type of values."""

    def spoil(file: h5py.File) -> None:
        _other(file, data=np.zeros(len(file[DEPTH]), kind), dtype=kind)

    return spoil


def _text(path: str, text: str) -> Spoil:
    def spoil(file: h5py.File) -> None:
        _other(file, path, data=text, dtype=h5py.string_dtype())

    return spoil


def _changed(path: str, **changes: Any) -> Spoil:
    """Change a JSON document at its top."""

    def spoil(file: h5py.File) -> None:
        document = json.loads(file[path].asstr()[()]) | changes
        _other(file, path, data=json.dumps(document), dtype=h5py.string_dtype())

    return spoil


def _zeros(size: int) -> bytes:
    """Return the deflate stream of so many MB of zeros, made of one that is repeated."""
    packing = zlib.compressobj(9)
    first = packing.compress(bytes(1 << 20)) + packing.flush(zlib.Z_FULL_FLUSH)
    again = packing.compress(bytes(1 << 20)) + packing.flush(zlib.Z_FULL_FLUSH)
    end = b"\x03\x00" + struct.pack(">I", ((size << 20) % 65521 << 16) + 1)
    return first + again * (size - 1) + end


def _packed(length: int | None, chunk: int | None, megabytes: float) -> Spoil:
    """Put zeros in the place of every chunk of a column, of the length of the others where none is said."""

    def spoil(file: h5py.File) -> None:
        count = length or len(file[DEPTH])
        filters: dict[str, Any] = {"compression": "gzip", "shuffle": True, "fletcher32": True}
        dataset = _other(file, shape=(count,), dtype="f8", chunks=(chunk or count,), **filters)
        stream = _zeros(int(megabytes)) if megabytes >= 1 else zlib.compress(bytes(8 * _CHUNK))
        for start in range(0, count, chunk or count):
            dataset.id.write_direct_chunk((start,), stream, _NO_CHECKSUM)

    return spoil


def _deep(file: h5py.File) -> None:
    group = file["entry"].id
    for _ in range(10_000):
        group = h5py.h5g.create(group, b"g")


def _many_members(file: h5py.File) -> None:
    group = file["entry/raw"]
    for number in range(100_000):
        group.id.links.create_soft(f"{number}".encode(), b"/entry")


def _many_attributes(file: h5py.File) -> None:
    group = file.create_group("entry/many", track_order=True)
    for number in range(20_000):
        group.attrs[f"{number}"] = number


def _link(path: str, link: h5py.SoftLink | h5py.ExternalLink) -> Spoil:
    def spoil(file: h5py.File) -> None:
        del file[path]
        file[path] = link

    return spoil


def _hard_link(file: h5py.File) -> None:
    file["entry/raw/again"] = file["entry"]


def _virtual(file: h5py.File) -> None:
    shape = file[DEPTH].shape
    layout = h5py.VirtualLayout(shape, dtype=float)
    layout[:] = h5py.VirtualSource("elsewhere.h5", "numbers", shape=shape)
    del file[DEPTH]
    file.create_virtual_dataset(DEPTH, layout)


def _lists(file: h5py.File) -> None:
    dataset = _other(file, dtype=h5py.vlen_dtype("f8"))
    for number in range(len(dataset)):
        dataset[number] = np.zeros(2)


def _named_type(file: h5py.File) -> None:
    file["entry/type"] = np.dtype("f8")
    _other(file, dtype=file["entry/type"])[:] = 0.0


def _one_text_over_and_over(file: h5py.File) -> None:
    texts = np.array(["x" * (1 << 20), *[""] * 9999], object)
    column = file.create_dataset("entry/extra_columns/many", data=texts, dtype=h5py.string_dtype())
    column.attrs.update(column_name="many", column_unit="")
    place = column.id.get_offset()
    file.flush()
    with Path(file.filename).open("rb+") as raw:
        raw.seek(place)
        reference = raw.read(16)
        raw.seek(place)
        raw.write(reference * 10_000)


def _text_that_lies(file: h5py.File) -> None:
    dataset = _other(file, RESULT, data="{}", dtype=h5py.string_dtype())
    place = dataset.id.get_offset()
    file.flush()
    with Path(file.filename).open("rb+") as raw:
        raw.seek(place)
        raw.write(struct.pack("<I", 0xFFFF_FFF0))


def _long_attribute(file: h5py.File) -> None:
    file[DEPTH].attrs["origin"] = ["x" * 9000] * 3000


def _attribute_that_lies(file: h5py.File) -> None:
    file[DEPTH].attrs["origin"] = "x" * 4711
    file.flush()
    content = bytearray(Path(file.filename).read_bytes())
    place = content.index(struct.pack("<I", 4711))
    with Path(file.filename).open("rb+") as raw:
        raw.seek(place)
        raw.write(struct.pack("<I", 0xFFFF_FFF0))


def _group_for_a_field(file: h5py.File) -> None:
    del file[MANIFEST]
    file.create_group(MANIFEST)


def _field_for_a_group(file: h5py.File) -> None:
    del file["entry/friction_fit"]
    file["entry/friction_fit"] = 1.0


def _names(file: h5py.File) -> None:
    group = file["entry"]
    for name in ("..", ".. ", "a\x1b[2J", "\u202ea", "C:\\x", "x" * 60_000):
        group.id.links.create_soft(name.encode(), b"/entry/raw")


INSIDE: dict[str, Spoil] = {
    "dataset with a declared length of 2^60": _made(shape=(1 << 60,), dtype="f8", chunks=(_CHUNK,)),
    "dataset of 1 GB that was never written": _made(shape=(1 << 27,), dtype="f8", fillvalue=1e9),
    "1 GB of zeros in ordinary chunks": _packed(1 << 27, _CHUNK, 0.5),
    "512 MB of zeros in a small chunk": _packed(None, None, 512),
    "chunk of 4 GB": _packed((1 << 29) - 1, (1 << 29) - 1, 4095),
    "10 000 nested groups": _deep,
    "group that contains itself": _hard_link,
    "soft link that points to itself": _link(DEPTH, h5py.SoftLink(f"/{DEPTH}")),
    "soft link instead of a result": _link("entry/friction_fit", h5py.SoftLink("/entry/specific_wear")),
    "external link": _link(DEPTH, h5py.ExternalLink("elsewhere.h5", "/x")),
    "external link instead of the entry": _link("entry", h5py.ExternalLink("elsewhere.h5", "/x")),
    "external storage": _made(dtype="f8", external=[("elsewhere", 0, 1 << 20)]),
    "virtual dataset": _virtual,
    "100 000 members": _many_members,
    "20 000 attributes": _many_attributes,
    "attribute with 27 MB of text": _long_attribute,
    "text of 64 MB": _text(RESULT, "x" * (64 << 20)),
    "text with a declared length of 4 GB": _text_that_lies,
    "attribute with a declared length of 4 GB": _attribute_that_lies,
    "one text of 1 MB, referenced 10 000 times": _one_text_over_and_over,
    "records instead of numbers": _values([("x", "f8"), ("y", "f8")]),
    "references instead of numbers": _made(dtype=h5py.ref_dtype),
    "enumeration instead of numbers": _values(h5py.enum_dtype({"a": 0, "b": 1}, "i4")),
    "opaque bytes instead of numbers": _values("V8"),
    "lists instead of numbers": _lists,
    "16-byte numbers": _values("f16" if hasattr(np, "float128") else "c16"),
    "numbers with a different byte order": _values(">f8"),
    "text instead of numbers": _values("S8"),
    "named datatype": _named_type,
    "different compression filter": _made(dtype="f8", compression="lzf"),
    "one number instead of a column": _made(data=1.0),
    "two-dimensional column": _made(data=np.zeros((126, 2))),
    "shorter column": _made(data=np.zeros(125)),
    "group instead of a field": _group_for_a_field,
    "field instead of a group": _field_for_a_group,
    "result nested 100 000 levels deep": _text(RESULT, "[" * 100_000 + "]" * 100_000),
    "findings nested 100 000 levels deep": _text(FINDINGS, '{"a":' * 100_000),
    "600 000 lists": _text(FINDINGS, f"[{'[],' * 600_000}[]]"),
    "number 1e400": _text(FINDINGS, "[1e400]"),
    "number with 100 000 digits": _text(FINDINGS, f"[{'9' * 100_000}]"),
    "invalid JSON": _text(MANIFEST, "\u202e{"),
    "negative load": _changed(MANIFEST, conditions={"normal_load": {"value": -1.0, "unit": "N"}}),
    "infinite load": _text(MANIFEST, '{"conditions": {"normal_load": {"value": Infinity, "unit": "N"}}}'),
    "manifest of another run": _changed(MANIFEST, id="another"),
    "run ID with a path outside the archive": _changed(MANIFEST, id="../../x"),
    "source file name with a path outside the folder": _text("entry/source_files/file_0/file_name", "../../x"),
    "names with paths outside the archive": _names,
}
"""What is done to the content of a good run."""


def _points_outside(path: Path) -> None:
    content = path.read_bytes()
    root = content.index((0).to_bytes(8, "little"), SEAL_SIZE + 8)
    path.write_bytes(content[:root] + (1 << 50).to_bytes(8, "little") * 4 + content[root + 32 :])


def _endless_heap(path: Path) -> None:
    """Say of the room that is left among texts that it has no size, so that HDF5 never gets past it."""
    content = bytearray(path.read_bytes())
    heaps = (found.start() for found in re.finditer(b"GCOL", content))
    room = next(room for room in (_room_in(content, heap) for heap in heaps) if room)
    content[room + 8 : room + 16] = bytes(8)
    path.write_bytes(content)


def _room_in(content: bytes | bytearray, heap: int) -> int | None:
    """Return where the room that is left in a heap of texts begins; none where it is full."""
    (size,) = struct.unpack_from("<8xQ", content, heap)
    at = heap + 16
    while at + 16 <= heap + size:
        number, length = struct.unpack_from("<H6xQ", content, at)
        if not number:
            return at
        at += 16 + -(-length // 8) * 8
    return None


def _sparse(path: Path) -> None:
    with path.open("rb+") as file:
        file.truncate(1 << 30)


def _block_of_1_gb(path: Path) -> None:
    content = path.read_bytes()[SEAL_SIZE:]
    with path.open("rb+") as file:
        file.truncate(SEAL_SIZE)
        file.seek(1 << 30)
        file.write(content)


STUDY: dict[str, Spoil] = {
    "study with 10 000 nested groups": _deep,
    "study with a text of 64 MB": _text("entry/result/data", "x" * (64 << 20)),
    "study with a result nested 100 000 levels deep": _text("entry/result/data", "[" * 100_000),
    "study without JSON": _text("entry/study/data", "{"),
    "study with an external link": _link("entry/study", h5py.ExternalLink("elsewhere.h5", "/x")),
    "study with a curve with a declared length of 2^60": lambda file: file["entry"].create_dataset(
        "curve_999", (1 << 60,), "f8", chunks=(99,)
    ),
}
"""What is done to the content of a good study."""


def _in_place(make: Callable[[Path], object]) -> Callable[[Path], object]:
    def replaced(path: Path) -> None:
        path.unlink()
        make(path)

    return replaced


OUTSIDE: dict[str, Callable[[Path], object]] = {
    "superblock with an address outside the file": _points_outside,
    "text reference that causes an endless loop in HDF5": _endless_heap,
    "file truncated to half its length": lambda path: os.truncate(path, path.stat().st_size // 2),
    "empty file": lambda path: os.truncate(path, 0),
    "file that contains only zeros": lambda path: path.write_bytes(bytes(1 << 20)),
    "hole of 1 GB at the end": _sparse,
    "hole of 1 GB at the beginning": _block_of_1_gb,
    "folder": _in_place(Path.mkdir),
    "symbolic link to a missing file": _in_place(lambda path: path.symlink_to("nowhere.h5")),
    "symbolic link to itself": _in_place(lambda path: path.symlink_to(path)),
    "symbolic link to an endless device": _in_place(lambda path: path.symlink_to("/dev/zero")),
    **({"pipe": _in_place(os.mkfifo)} if hasattr(os, "mkfifo") else {}),
}
"""What is done to the file of a good run."""


def make_hostile(good: Path, name: str, path: Path) -> None:
    """Make a hostile file from a good one."""
    path.parent.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(good, path)
    if name in INSIDE or name in STUDY:
        with h5py.File(path, "r+", locking=False) as file:
            (INSIDE | STUDY)[name](file)
    else:
        OUTSIDE[name](path)
    if path.is_file() and path.stat().st_size > SEAL_SIZE:
        seal_file(path)
