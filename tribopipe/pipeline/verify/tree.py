"""All that an HDF5 file holds, read once: groups, fields and links, with their attributes and their short texts.

Every value is read, so that HDF5 checks what checksums it keeps; of arrays no more is kept than their shape.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import h5py
from h5py import h5a, h5l

from tribopipe.archive.unpack import check_packed
from tribopipe.pipeline.verify.look import Look


@dataclass(frozen=True)
class Field:
    """A dataset: what it is, not what it holds."""

    attributes: Mapping[str, Any]
    shape: tuple[int, ...]
    kind: str
    """Of its type: i and u for whole numbers, f for others, S for texts."""
    text: str | None
    """What a single text states."""


@dataclass(frozen=True)
class Link:
    """A name for what lies elsewhere in the file."""

    path: str
    """Where it leads."""


@dataclass(frozen=True)
class Group:
    """A group with its members in order."""

    attributes: Mapping[str, Any]
    members: "dict[str, Member]" = field(default_factory=dict)

    def at(self, path: str) -> "Member | None":
        """Return what lies below, links not followed; none where there is nothing."""
        found: Member | None = self
        for name in path.strip("/").split("/"):
            found = found.members.get(name) if isinstance(found, Group) else None
        return found


Member: TypeAlias = Group | Field | Link


def read_tree(group: h5py.Group, look: Look, path: str = "") -> Group:
    """Read all below a group of a file that nests within bounds; what cannot be read is noted and left out."""
    kept = Group(_attributes(group))
    links: list[tuple[bytes, int]] = []
    group.id.links.iterate(lambda name, link: links.append((name, link.type)), info=True)
    for name, kind in links:
        part = f"{path}/{name.decode(errors='replace')}"
        with look.reading(part):
            if kind == h5l.TYPE_SOFT:
                kept.members[name.decode()] = Link(group.id.links.get_val(name).decode())
                continue
            there = group[name]
            kept.members[name.decode()] = (
                read_tree(there, look, part) if isinstance(there, h5py.Group) else _field(there)
            )
    return kept


def _field(dataset: h5py.Dataset) -> Field:
    if h5py.check_string_dtype(dataset.dtype) is not None:
        read = dataset.asstr()[()]
        return Field(_attributes(dataset), dataset.shape, "S", read if isinstance(read, str) else None)
    if dataset.chunks is None:
        dataset[()]
    else:
        check_packed(dataset)
        for part in dataset.iter_chunks():
            dataset[part]
    return Field(_attributes(dataset), dataset.shape, dataset.dtype.kind, None)


def _attributes(part: h5py.Group | h5py.Dataset) -> dict[str, Any]:
    return dict(part.attrs) if h5a.get_num_attrs(part.id) else {}
