"""Any part of an HDF5 file by its path, without ever leaving the file."""

from collections.abc import Iterator
from difflib import get_close_matches
from pathlib import PurePath
from typing import TypeAlias

import h5py

from tribopipe.archive.own_content import storage_elsewhere
from tribopipe.errors import ArchiveError

Part: TypeAlias = "h5py.Group | h5py.Dataset"
_MOST_LINKS = 16
"""Soft links that may lead on to each other."""


def find_part(file: h5py.File, path: str) -> Part:
    """Return a group or dataset. Soft links are followed, which stay within the file, and external ones are not.

    Raises ``ArchiveError`` where there is no such part, or it lies in another file.
    """
    part: Part = file
    steps, followed = _steps(path), 0
    while steps:
        name = steps.pop()
        if not isinstance(part, h5py.Group) or name not in part.keys():  # noqa: SIM118, `in` would follow links
            raise _no_part(file, path)
        target = link_target(part, name)
        if target is None:
            part = part[name]
            continue
        followed += 1
        if followed > _MOST_LINKS or isinstance(target, h5py.ExternalLink):
            raise _led_away(file, path, target)
        part = file if target.startswith("/") else part
        steps += _steps(target)
    if isinstance(part, h5py.Datatype):
        raise _no_part(file, path)
    return part


def _steps(path: str) -> list[str]:
    """Return the names along a path, the first one last."""
    return [name for name in reversed(path.split("/")) if name not in ("", ".")]


def link_target(group: h5py.Group, name: str) -> str | h5py.ExternalLink | None:
    """Return the path a soft link leads to, or an external link as it is; none for a member of the group's own."""
    link = group.get(name, getlink=True)
    if isinstance(link, h5py.SoftLink):
        return str(link.path)
    return link if isinstance(link, h5py.ExternalLink) else None


def lies_elsewhere(dataset: h5py.Dataset) -> bool:
    """Tell whether the values of a dataset are kept in other files."""
    return storage_elsewhere(dataset.id) is not None


def kept_elsewhere(dataset: h5py.Dataset) -> ArchiveError:
    """Return what is said where they are."""
    return ArchiveError(
        f"{_name(dataset.file)}: found values that are kept in other files, at {dataset.name!r}; expected them in this "
        "one; open it elsewhere if you trust it"
    )


def _led_away(file: h5py.File, path: str, link: str | h5py.ExternalLink) -> ArchiveError:
    found = "links that lead to each other" if isinstance(link, str) else f"a link to another file, {link.filename!r}"
    return ArchiveError(
        f"{_name(file)}: found {found}, at {path!r}; expected a part of this file; open it elsewhere if you trust it"
    )


def _name(file: h5py.File) -> str:
    return PurePath(file.filename).name


def _no_part(file: h5py.File, path: str) -> ArchiveError:
    wanted = "/" + "/".join(reversed(_steps(path)))
    near = get_close_matches(wanted, list(_paths(file)), n=1, cutoff=0)
    nearest = f"; did you mean {near[0]!r}?" if near else ""
    return ArchiveError(f"{_name(file)}: found no {path!r}; expected a part of the file, such as '/entry/raw'{nearest}")


def _paths(file: h5py.File) -> Iterator[str]:
    """Return the path of everything in a file, links included."""
    found: list[str] = []
    file.visit_links(found.append)
    return (f"/{name}" for name in found)
