"""Any part of an HDF5 file by its path, without ever leaving the file."""

from collections.abc import Iterator
from difflib import get_close_matches
from pathlib import PurePath
from typing import NamedTuple, TypeAlias

import h5py

from tribopipe.archive.hdf5_compression import check_packed
from tribopipe.archive.hdf5_guard import storage_elsewhere
from tribopipe.base.errors import ArchiveError

Part: TypeAlias = h5py.Group | h5py.Dataset | h5py.Datatype
Link: TypeAlias = h5py.HardLink | h5py.SoftLink | h5py.ExternalLink
_MOST_LINKS = 16
"""Soft links on one way: they may lead round in circles, or multiply."""


class NoPart(NamedTuple):
    """Why a path leads to no part of its file."""

    beyond: str = ""
    """What it leads to instead, which is not followed; empty where there is nothing."""


def find_part(file: h5py.File, path: str) -> h5py.Group | h5py.Dataset:
    """Return a group or dataset.

    Raises ``ArchiveError`` where there is no such part, it lies in another file, or it unpacks to more than it states.
    """
    part = part_at(file, path)
    if isinstance(part, NoPart) and part.beyond:
        raise ArchiveError(
            f"{_name(file)}: found {part.beyond} at {path!r}; expected an object in this file; open the target "
            "separately if you trust it"
        )
    if isinstance(part, NoPart | h5py.Datatype):
        raise _no_part(file, path)
    if isinstance(part, h5py.Dataset):
        check_packed(part)
    return part


def part_at(start: h5py.Group, path: str) -> Part | NoPart:
    """Follow a path from a group. Soft links are followed; what lies, or keeps its values, in other files is not."""
    part: Part = _start(start, path)
    steps, followed = _steps(path), 0
    while steps:
        found = _member(part, steps.pop())
        if isinstance(found, NoPart):
            return found
        if isinstance(found, h5py.SoftLink):
            followed += 1
            if followed > _MOST_LINKS:
                return NoPart(f"a chain of more than {_MOST_LINKS} links")
            steps += _steps(found.path)
            found = _start(part, found.path)
        part = found
    return part


def _start(group: h5py.Group, path: str) -> h5py.Group:
    """Return the group that a path starts from."""
    return group.file["/"] if path.startswith("/") else group


def _steps(path: str) -> list[str]:
    """Return the names along a path, the first one last."""
    return [name for name in reversed(path.split("/")) if name not in ("", ".")]


def _member(part: Part, name: str) -> Part | h5py.SoftLink | NoPart:
    """Return a member of a group, or the soft link that stands for one."""
    link = link_at(part, name) if isinstance(part, h5py.Group) else None
    if isinstance(link, h5py.ExternalLink):
        return NoPart(f"a link to another file, {link.filename!r}")
    if not isinstance(link, h5py.HardLink):
        return link or NoPart()
    member: Part = part[name]
    elsewhere = storage_elsewhere(member.id) if isinstance(member, h5py.Dataset) else None
    return member if elsewhere is None else NoPart(elsewhere)


def link_at(group: h5py.Group, name: str) -> Link | None:
    """Return a link without following it; none if it does not exist or is of a kind that HDF5 does not define."""
    try:
        return group.get(name, getlink=True)
    except TypeError:
        return None


def _name(file: h5py.File) -> str:
    return PurePath(file.filename).name


def _no_part(file: h5py.File, path: str) -> ArchiveError:
    wanted = "/" + "/".join(reversed(_steps(path)))
    near = get_close_matches(wanted, list(_paths(file)), n=1, cutoff=0)
    nearest = f"; did you mean {near[0]!r}?" if near else ""
    return ArchiveError(f"{_name(file)}: found no {path!r}; expected a group or dataset, such as '/entry/raw'{nearest}")


def _paths(file: h5py.File) -> Iterator[str]:
    """Return the path of everything in a file, links included."""
    found: list[str] = []
    file.visit_links(found.append)
    return (f"/{name}" for name in found)
