"""Whether a file is what its NeXus application definition states, and what viewers can plot.

What a file may hold, and has to, is declared in ``tribopipe.archive.definitions``. What NXdata has to state for itself
follows the chapter "Associating plottable data using attributes applied to the NXdata group" of the NeXus manual.

The file is read once, into groups, fields and links, with their attributes and their short texts. Every value is read,
so that HDF5 checks what checksums it keeps; of arrays no more is kept than their shape.
"""

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime
from typing import Any, NamedTuple, TypeAlias

import h5py
import numpy as np
from h5py import h5a, h5l

from tribopipe.archive.definitions.nxdl import definitions
from tribopipe.archive.definitions.parts import FieldPart, GroupPart, Kind, Part
from tribopipe.archive.hdf5_compression import check_packed
from tribopipe.pipeline.verify.file_findings import Look


@dataclass(frozen=True)
class Field:
    """A dataset: what it is, not what it holds."""

    attributes: Mapping[str, Any]
    shape: tuple[int, ...]
    kind: str
    """Kind of its type: i and u for integers, f for floats, S for text."""
    text: str | None
    """Content of a single text."""


@dataclass(frozen=True)
class Link:
    """A name for what lies elsewhere in the file."""

    path: str
    """Target of the link."""


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


_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
_NUMBER = "fiu"
"""Kinds of types: floating, signed, unsigned."""
_REDO = "run `tribopipe process --force` to write the file again; if that does not help, restore it from a backup"
_DEFINITION = "/entry/definition"
_ROOT_ATTRIBUTES = ("default", "creator", "creator_version")
_ANY_ATTRIBUTE = ("NXcollection", "NXdata")


class Fault(NamedTuple):
    """One breach of a rule."""

    part: str
    message: str


def check_nexus(root: Group, look: Look) -> None:
    """Note where a file breaks a rule."""
    for fault in (*_definition_faults(root), *_default_faults(root)):
        look.warning("nexus", fault.message, _REDO, fault.part or "/")


def _definition_faults(root: Group) -> Iterator[Fault]:
    said = root.at(_DEFINITION)
    named = said.text if isinstance(said, Field) else None
    if named is None or named not in definitions():
        found = "no definition" if named is None else repr(named)
        yield Fault(_DEFINITION, f"found {found}; expected one of {', '.join(definitions())}")
        return
    definition = definitions()[named]
    if isinstance(said, Field) and said.attributes.get("version") != str(definition.version):
        yield Fault(
            _DEFINITION,
            f"found another version of the definition; expected version {definition.version}, as for this file format",
        )
    yield from _faults("", root, GroupPart("", "NXroot", "", (definition.entry,), attributes=_ROOT_ATTRIBUTES), root)


def _faults(path: str, group: Group, declared: GroupPart, root: Group) -> Iterator[Fault]:
    """Find what a group is, holds or does not have otherwise than declared."""
    nx_class = _text(group, "NX_class") or ""
    if nx_class != declared.nx_class:
        yield Fault(path, f"found a group of the class {nx_class!r}; expected the class {declared.nx_class}")
        return
    yield from _attribute_faults(path, group, declared)
    yield from _missing_faults(path, group, declared)
    for name, member in group.members.items():
        yield from _member_faults(f"{path}/{name}", name, member, declared, root)
    yield from _uncertainty_faults(path, group)
    if nx_class == "NXdata":
        yield from _data_faults(path, group, root)


def _missing_faults(path: str, group: Group, declared: GroupPart) -> Iterator[Fault]:
    classes = {_text(member, "NX_class") for member in group.members.values() if isinstance(member, Group)}
    for part in declared.members:
        if part.required and part.name and part.name not in group.members:
            yield Fault(path, f"found no {part.name!r}; expected {_kind_of(part)} of this name")
        elif part.required and isinstance(part, GroupPart) and not part.name and part.nx_class not in classes:
            yield Fault(path, f"found no {part.nx_class}; expected at least one group of this class")
    # A pin may be a ball instead, which NXDL has no way to say.
    bodies = [part for part in declared.members if isinstance(part, GroupPart) and part.nx_class == "NXsample"]
    either = [part.name for part in bodies if not part.required]
    if either and not any(name in group.members for name in either):
        yield Fault(path, f"found no {' or '.join(map(repr, either))}; expected a group of this name")


def _attribute_faults(path: str, group: Group, declared: GroupPart) -> Iterator[Fault]:
    if declared.nx_class in _ANY_ATTRIBUTE:
        return
    for name in group.attributes.keys() - {"NX_class", *declared.attributes}:
        yield Fault(path, f"found the attribute {name!r}; expected no attribute of this name in an {declared.nx_class}")


def _member_faults(path: str, name: str, member: Member, holder: GroupPart, root: Group) -> Iterator[Fault]:
    if not _NAME.fullmatch(name):
        yield Fault(path, "found a name that NeXus does not allow; expected only letters, digits and _")
    declared = holder.member(name, _text(member, "NX_class") if isinstance(member, Group) else None)
    if declared is None:
        yield Fault(path, "found an item that is not in the file's definition; expected no item with this name")
    elif isinstance(member, Link):
        if not isinstance(root.at(member.path), Field) or isinstance(declared, GroupPart):
            yield Fault(path, f"found a link to {member.path}, which is not a field; expected a link to a field")
    elif isinstance(member, Group) and isinstance(declared, GroupPart):
        yield from _faults(path, member, declared, root)
    elif isinstance(member, Field) and isinstance(declared, FieldPart):
        yield from _field_faults(path, member, declared)
    else:
        yield Fault(path, f"found a {type(member).__name__.lower()}; expected {_kind_of(declared)}")


def _kind_of(declared: Part) -> str:
    return {GroupPart: "a group", FieldPart: "a field"}.get(type(declared), "a link to a field")


def _field_faults(path: str, member: Field, declared: FieldPart) -> Iterator[Fault]:
    if not _IS[declared.kind](member):
        yield Fault(path, f"found a field of another type; expected {declared.kind}")
    elif declared.values and member.text not in declared.values:
        yield Fault(path, f"found {member.text!r}; expected {' or '.join(declared.values)}")
    if declared.units and _unit(member) not in declared.units:
        found = "no units" if _unit(member) is None else f"the units {_unit(member)!r}"
        yield Fault(path, f"found {found}; expected {' or '.join(declared.units)}")
    for wrong in {"signal", "axis"} & member.attributes.keys():
        yield Fault(path, f"found the attribute {wrong!r} on a field; expected it on the group that contains the field")


def _uncertainty_faults(path: str, group: Group) -> Iterator[Fault]:
    """Find uncertainties, <name>_errors, that do not belong to a number of the same unit."""
    for name, member in group.members.items():
        of = group.members.get(name.removesuffix("_errors"))
        if of is member:
            continue
        told = (of, member)
        if not all(isinstance(one, Field) and one.kind in _NUMBER for one in told) or _unit(of) != _unit(member):
            yield Fault(
                f"{path}/{name}",
                "found a standard uncertainty without a value in the same unit; expected a value and its uncertainty "
                "in the same unit",
            )


def _is_text(member: Field) -> bool:
    return member.text is not None


def _is_count(member: Field) -> bool:
    return member.kind in _NUMBER[1:] and member.shape == ()


def _is_date(member: Field) -> bool:
    try:
        datetime.fromisoformat(member.text or "")
    except ValueError:
        return False
    return True


_IS: Mapping[Kind, Callable[[Field], bool]] = {
    "NX_CHAR": _is_text,
    "NX_DATE_TIME": _is_date,
    "NX_FLOAT": lambda member: member.kind == "f",
    "NX_INT": lambda member: member.kind in _NUMBER[1:],
    "NX_POSINT": _is_count,
    "NX_BINARY": lambda member: member.kind == "u",
    "NX_CHAR_OR_NUMBER": lambda member: member.kind in f"{_NUMBER}S",
}
"""Whether a field is of a type of NeXus."""


def _data_faults(path: str, data: Group, root: Group) -> Iterator[Fault]:
    """Find what keeps a viewer from plotting."""
    signal = _plotted(data, _text(data, "signal"), root)
    if signal is None:
        yield Fault(path, f"found no field for the signal {_text(data, 'signal')!r}; expected a field of this name")
        return
    axes = _texts(data, "axes")
    if len(axes) != len(signal.shape):
        yield Fault(path, f"found {len(axes)} axes; expected {len(signal.shape)}, one per dimension of the signal")
    for place, (axis, length) in enumerate(zip(axes, signal.shape, strict=False)):
        yield from _axis_faults(path, data, axis, place, length, root)
    for name in _texts(data, "auxiliary_signals"):
        other = _plotted(data, name, root)
        if other is None or other.shape != signal.shape:
            yield Fault(
                path, f"found no field {name!r} with the shape of the signal; expected a field of this name and shape"
            )
    yield from _unit_faults(path, data, [_text(data, "signal") or "", *axes, *_texts(data, "auxiliary_signals")], root)


def _axis_faults(path: str, data: Group, axis: str, place: int, length: int, root: Group) -> Iterator[Fault]:
    if axis == ".":
        return
    field = _plotted(data, axis, root)
    if field is None:
        yield Fault(path, f"found no field for the axis {axis!r}; expected a field of this name")
    elif field.shape != (length,):
        yield Fault(path, f"found the axis {axis!r} of shape {field.shape}; expected ({length},), to match the signal")
    if data.attributes.get(f"{axis}_indices", -1) != place:
        yield Fault(path, f"found no attribute {axis}_indices = {place}; expected the attribute with this value")


def _unit_faults(path: str, data: Group, names: Sequence[str], root: Group) -> Iterator[Fault]:
    for name in names:
        field = _plotted(data, name, root)
        if field is not None and _unit(field) is None:
            yield Fault(f"{path}/{name}", "found no units; expected the attribute 'units' on every plotted field")


def _default_faults(root: Group) -> Iterator[Fault]:
    """Follow what a viewer opens first."""
    entry = root.members.get(_text(root, "default") or "")
    data = entry.members.get(_text(entry, "default") or "") if isinstance(entry, Group) else None
    if not isinstance(data, Group) or _text(data, "NX_class") != "NXdata":
        yield Fault("", "found no plot specified by the attribute 'default'; expected the path to an NXdata group")


def _plotted(data: Group, name: str | None, root: Group) -> Field | None:
    """Return a field of numbers that is a member, or that a member leads to."""
    there = data.members.get(name or "")
    if isinstance(there, Link):
        there = root.at(there.path)
    return there if isinstance(there, Field) and there.kind in _NUMBER else None


def _unit(member: Member | None) -> str | None:
    return _text(member, "units") if isinstance(member, Field) else None


def _text(group: Group | Field, attribute: str) -> str | None:
    said = group.attributes.get(attribute)
    return said if isinstance(said, str) else None


def _texts(group: Group, attribute: str) -> list[str]:
    return [str(one) for one in np.atleast_1d(group.attributes.get(attribute, []))]
