"""The source files inside an archived run, as far as a damaged file still gives them.

Argument: the path.

The answer is a line of JSON: whether the list of sources could be read, or they had to be searched for in the file,
so that some may be missing; and for each source its name, its checksum as it was written, its size, and what went wrong
if anything. Then follow the bytes of those that can be read. Whether they are right is for the caller to find out.
Links to other files, virtual datasets and external storage are not followed.
"""

import io
import json
import mmap
import re
import struct
import sys
from collections.abc import Callable, Iterator
from functools import partial
from operator import getitem
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from h5py import h5s, h5t

Opener = Callable[[], Any]
_MAGIC = b"\x89HDF\r\n\x1a\n"
_USER_BLOCKS = (512, 0)
_HEADER = b"OHDR"
_NAMELESS = "a file of unknown name"
_MEMBERS = {"file_name", "checksum", "data"}
_MOST_COMPRESSED = 1100
"""Deflate cannot pack bytes more densely than by this factor."""


def main() -> None:
    """Answer with the sources, or end with what is wrong."""
    try:
        with Path(sys.argv[1]).open("rb") as there:
            content = mmap.mmap(there.fileno(), 0, access=mmap.ACCESS_READ)
        with h5py.File(_as_long_as_it_was(content), "r", locking=False) as file:
            listed, notes = _notes(file, content)
            found = list(_sources(notes, room=_MOST_COMPRESSED * len(content)))
    except Exception as error:  # noqa: BLE001 - HDF5 raises whatever a damaged file makes it stumble on
        sys.exit(_told(error))
    said = {"listed": listed, "sources": [said for said, _ in found]}
    sys.stdout.buffer.write(json.dumps(said).encode("ascii") + b"\n")
    for _, source in found:
        sys.stdout.buffer.write(source)


def _told(error: Exception) -> str:
    return f"{type(error).__name__}: {error}".replace("\n", " ")


def _start(content: mmap.mmap) -> int:
    """Return where HDF5 begins."""
    for start in _USER_BLOCKS:
        if content[start : start + len(_MAGIC)] == _MAGIC:
            return start
    raise ValueError("no HDF5 file header")


def _as_long_as_it_was(content: mmap.mmap) -> str | io.BytesIO:
    """Return a file with zeros where its tail was cut off, since HDF5 opens none shorter than its head states."""
    start = _start(content)
    (end,) = struct.unpack_from("<Q", content, start + (40 if content[start + len(_MAGIC)] < 2 else 28))
    if end <= len(content):
        return sys.argv[1]
    image = io.BytesIO(content)
    image.seek(end - 1)
    image.write(b"\0")
    return image


def _notes(file: Any, content: mmap.mmap) -> tuple[bool, list[tuple[str, Opener]]]:
    """Return whether the sources are listed, and give each one's name in the list and what opens it."""
    try:
        notes = _member(file, "entry/source_files")
        return True, [(key, partial(_member, notes, key)) for key in notes] + list(_earlier(file))
    except Exception:
        found = list(_scattered(file, content))
        if not found:
            raise
        return False, [(_NAMELESS, partial(getitem, file, reference)) for reference in found]


def _earlier(file: Any) -> Iterator[tuple[str, Opener]]:
    """Give what run.toml was before it was amended."""
    try:
        kept = _member(file, "entry/earlier_manifests")
        yield from [(key, partial(_member, kept, key)) for key in kept if key != "amended"]
    except Exception:  # noqa: BLE001 - as above; most runs were never amended
        return


def _scattered(file: Any, content: mmap.mmap) -> Iterator[Any]:
    """Give references to the groups of sources, found by their headers, since what leads to them is damaged."""
    places = [header.start() - _start(content) for header in re.finditer(_HEADER, content)]
    with h5py.File("references", "w", driver="core", backing_store=False) as scratch:
        references = scratch.create_dataset("references", (len(places),), dtype=h5py.ref_dtype)
        references.id.write(h5s.ALL, h5s.ALL, np.array(places, dtype="<u8"), mtype=h5t.STD_REF_OBJ)
        for reference in references[()]:
            try:
                found = file[reference]
                if isinstance(found, h5py.Group) and set(found) >= _MEMBERS:
                    yield reference
            except Exception:  # noqa: BLE001, S112 - as above
                continue


def _sources(notes: list[tuple[str, Opener]], room: int) -> Iterator[tuple[dict[str, Any], bytes]]:
    """Give what is stated about each source, and its bytes."""
    for name, opened in notes:
        said, content = {"name": name, "sha256": "", "problem": None}, b""
        try:
            note = opened()
            said["name"] = str(_dataset(note, "file_name").asstr()[()])
            said["sha256"] = str(_dataset(note, "checksum").asstr()[()])
            data = _dataset(note, "data")
            if data.nbytes > room:
                raise ValueError("more bytes than the file has room for")
            room -= data.nbytes
            content = np.asarray(data[()], dtype=np.uint8).tobytes()
        except Exception as error:  # noqa: BLE001 - as above; the other sources may be whole
            said["problem"] = _told(error)
        yield {**said, "size": len(content)}, content


def _member(place: Any, path: str) -> Any:
    """Give a group or dataset, going by hard links alone."""
    for name in path.split("/"):
        if not isinstance(place.get(name, getlink=True), h5py.HardLink):
            raise ValueError(f"no {path}")
        place = place[name]
    return place


def _dataset(note: Any, name: str) -> Any:
    """Give a dataset that is written in this file."""
    found = _member(note, name)
    if found.is_virtual or found.external:
        raise ValueError(f"{name} kept in another file")
    return found


if __name__ == "__main__":
    main()
