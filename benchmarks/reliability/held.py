"""What an archive holds, byte by byte, and whether it is whole: looked at by plain h5py, not by what is tested."""

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from io import BytesIO
from pathlib import Path

import h5py

from tribopipe.archive.seal import SEAL_SIZE

Content = Mapping[str, bytes]
"""Each field and attribute of a file by its path, as bytes; links by where they lead."""
_DATED = "/date"
RAW = ("entry/raw", "entry/source_files", "entry/manifest")
"""Where a run's file keeps what was recorded."""


def content(path: Path, below: Sequence[str] = ("entry",)) -> dict[str, bytes]:
    """Return all that a file holds below some groups, but dates.

    Raises ``OSError`` where its seal is broken or it cannot be opened, ``KeyError`` where it has no such group.
    """
    image = path.read_bytes()
    if hashlib.sha256(image[SEAL_SIZE:]).hexdigest().encode() not in image[:SEAL_SIZE]:
        raise OSError(f"{path}: the seal is broken")
    with h5py.File(BytesIO(image), "r") as file:
        found = (field for name in below for field in _fields(name, file[name]))
        return {name: value for name, value in found if not name.endswith(_DATED)}


def contents(archive: Path) -> dict[str, dict[str, bytes]]:
    """Return what every run of an archive holds, by its id. Raises as ``content`` does."""
    return {path.stem: content(path) for path in files(archive)}


def files(archive: Path) -> list[Path]:
    """Return the files of an archive's runs."""
    return sorted(path for path in archive.glob("*.h5") if not path.name.startswith("."))


def figures(archive: Path) -> dict[str, bytes]:
    """Return the figures beside an archive, by their names."""
    return {path.name: path.read_bytes() for path in sorted((archive / "figures").glob("*"))}


def differences(found: Mapping[str, Content], expected: Mapping[str, Content]) -> list[str]:
    """Name what two archives do not have in common: runs that only one has, and fields that are not the same."""
    apart = [f"{run}: only in one" for run in sorted(found.keys() ^ expected.keys())]
    for run in sorted(found.keys() & expected.keys()):
        names = sorted(found[run].keys() | expected[run].keys())
        apart += [f"{run}: {name}" for name in names if found[run].get(name) != expected[run].get(name)]
    return apart


def _fields(prefix: str, group: h5py.Group) -> Iterator[tuple[str, bytes]]:
    yield from _attributes(prefix, group)
    for name in group:
        path, link = f"{prefix}/{name}", group.get(name, getlink=True)
        if not isinstance(link, h5py.HardLink):
            yield path, repr(getattr(link, "path", link)).encode()
        elif isinstance(group[name], h5py.Group):
            yield from _fields(path, group[name])
        else:
            yield path, _bytes(group[name])
            yield from _attributes(path, group[name])


def _attributes(path: str, of: h5py.Group | h5py.Dataset) -> Iterator[tuple[str, bytes]]:
    for name, value in of.attrs.items():
        yield f"{path}@{name}", repr(value).encode()


def _bytes(field: h5py.Dataset) -> bytes:
    value = field[()]
    return value if isinstance(value, bytes) else bytes(value.tobytes()) + repr(value.dtype).encode()
