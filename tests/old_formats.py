"""Archived files as older versions of tribopipe wrote them, made of today's by a step back for each format."""

from collections.abc import Callable
from io import BytesIO
from pathlib import Path

import h5py

from tribopipe.archive.formats import format_of
from tribopipe.archive.seal import SEAL_SIZE, seal


def take_back(path: Path, version: int) -> None:
    """Write an archived file anew in the format of a version, as that tribopipe would have written it."""
    image = BytesIO(path.read_bytes())
    while (found := _format(image)).version > version:
        image = _STEPS_BACK[found.version](image, f"{found.kind}/{found.version - 1}")
    path.write_bytes(image.getvalue())


def take_archive_back(folder: Path, version: int) -> None:
    """Write all runs and studies of an archive anew in the format of a version."""
    for path in [*folder.glob("*.h5"), *folder.glob("studies/*.h5")]:
        take_back(path, version)


def _format(image: BytesIO):
    with h5py.File(image) as file:
        return format_of(file)


def _to_1(image: BytesIO, written_as: str) -> BytesIO:
    """Without a seal, without a word on what a result stands on and what it was computed with.

    Compared with what the last tribopipe of format 1 wrote for all sample runs, this differs in dates, and in the order
    of the keys of options.
    """
    return _without(image, {"stands_on", "environment"}, written_as)


def _to_2(image: BytesIO, written_as: str) -> BytesIO:
    """Without a word on the definition that the file follows."""
    older = _without(image, {"definition"}, written_as, userblock_size=SEAL_SIZE)
    seal(older.getbuffer())
    return older


def _without(image: BytesIO, left_out: set[str], written_as: str, **laid_out: int) -> BytesIO:
    older = BytesIO()
    with h5py.File(image) as file, h5py.File(older, "w", track_order=True, **laid_out) as made:
        made.attrs.update(file.attrs)
        _copy_but(file, made, left_out)
        made["entry/archived/format"][()] = written_as
    return older


def _copy_but(source: h5py.Group, target: h5py.Group, left_out: set[str]) -> None:
    for name in source:
        link = source.get(name, getlink=True)
        if isinstance(link, h5py.SoftLink):
            target[name] = link
        elif name in left_out:
            continue
        elif isinstance(source[name], h5py.Dataset):
            source.copy(name, target)
        else:
            group = target.create_group(name, track_order=True)
            group.attrs.update(source[name].attrs)
            _copy_but(source[name], group, left_out)


_STEPS_BACK: dict[int, Callable[[BytesIO, str], BytesIO]] = {3: _to_2, 2: _to_1}
