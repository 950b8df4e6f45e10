"""Rules of NeXus that viewers count on, as far as they concern what tribopipe writes.

Classes, members and types follow the base classes of the NeXus definitions, of which tribopipe uses few, and of these
few a part: whatever else a file holds, tribopipe has not written. What NXdata has to say for itself follows the
chapter "Associating plottable data using attributes applied to the NXdata group" of the manual.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from datetime import datetime
from typing import Literal, NamedTuple, TypeAlias

import numpy as np

from tribopipe.verify.look import Look
from tribopipe.verify.tree import Field, Group, Link, Member

_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
_NUMBER = "fiu"
"""Kinds of types: floating, signed, unsigned."""
_REDO = "`tribopipe process --force` writes it anew; where that does not help, restore the file from a copy"
_Kind: TypeAlias = Literal["text", "date", "count", "any"]


class _BaseClass(NamedTuple):
    """What a group of a NeXus class may hold, and has to."""

    fields: Mapping[str, _Kind] = {}
    required: tuple[str, ...] = ()
    groups: frozenset[str] = frozenset()
    open: bool = False
    """Whether fields of any name may be in it."""


_CLASSES: Mapping[str, _BaseClass] = {
    "NXroot": _BaseClass(groups=frozenset({"NXentry"}), required=("entry",)),
    "NXentry": _BaseClass(
        {"title": "text", "start_time": "date", "identifier_run": "text", "identifier_study": "text"},
        ("title", "archived"),
        frozenset({"NXcollection", "NXdata", "NXinstrument", "NXnote", "NXprocess", "NXsample", "NXuser"}),
    ),
    "NXuser": _BaseClass({"name": "text"}, ("name",)),
    "NXinstrument": _BaseClass({"name": "text"}, ("name",), frozenset({"NXsensor"})),
    "NXsensor": _BaseClass({"name": "text"}, ("name",)),
    "NXsample": _BaseClass({"name": "text"}, ("name",), frozenset({"NXcollection"})),
    "NXprocess": _BaseClass(
        {"program": "text", "version": "text", "date": "date", "sequence_index": "count"},
        ("program", "version", "date"),
        frozenset({"NXdata", "NXnote", "NXparameters"}),
    ),
    "NXnote": _BaseClass(
        {
            "file_name": "text",
            "type": "text",
            "description": "text",
            "checksum": "text",
            "algorithm": "text",
            "data": "any",
        },
        ("type", "data"),
    ),
    "NXparameters": _BaseClass(open=True),
    "NXcollection": _BaseClass(groups=frozenset({"NXdata", "NXnote"}), open=True),
    "NXdata": _BaseClass({"title": "text"}, open=True),
}
_ATTRIBUTES = {"NXroot": {"default", "creator", "creator_version"}, "NXentry": {"default"}}
_ANY_ATTRIBUTE = ("NXcollection", "NXdata")


class Fault(NamedTuple):
    """One breach of a rule."""

    part: str
    message: str


def check_nexus(root: Group, look: Look) -> None:
    """Note where a file breaks a rule."""
    for fault in (*_faults("", root, root), *_default_faults(root)):
        look.warning("nexus", fault.message, _REDO, fault.part or "/")


def _faults(path: str, group: Group, root: Group) -> Iterator[Fault]:
    nx_class = _text(group, "NX_class") or ""
    if nx_class not in _CLASSES:
        yield Fault(path, f"found a group of the class {nx_class!r}; expected one that tribopipe writes")
        return
    yield from _attribute_faults(path, group, nx_class)
    for name in _CLASSES[nx_class].required:
        if name not in group.members:
            yield Fault(path, f"found no {name!r}; expected one in each {nx_class}")
    for name, member in group.members.items():
        yield from _member_faults(f"{path}/{name}", name, member, nx_class, root)
    yield from _uncertainty_faults(path, group)
    if nx_class == "NXdata":
        yield from _data_faults(path, group, root)


def _attribute_faults(path: str, group: Group, nx_class: str) -> Iterator[Fault]:
    if nx_class in _ANY_ATTRIBUTE:
        return
    for name in group.attributes.keys() - {"NX_class"} - _ATTRIBUTES.get(nx_class, set()):
        yield Fault(path, f"found the attribute {name!r}; expected none of that name in an {nx_class}")


def _member_faults(path: str, name: str, member: Member, nx_class: str, root: Group) -> Iterator[Fault]:
    known = _CLASSES[nx_class]
    if not _NAME.fullmatch(name):
        yield Fault(path, "found a name that NeXus does not allow; expected letters, digits and _")
    if isinstance(member, Link):
        if not isinstance(root.at(member.path), Field):
            yield Fault(path, f"found a link to {member.path}, where there is no field; expected one")
    elif isinstance(member, Field):
        yield from _field_faults(path, name, member, known)
    elif ((inner := _text(member, "NX_class")) in _CLASSES and inner not in known.groups) or name in known.fields:
        yield Fault(path, f"found a group of the class {inner!r}; expected none in an {nx_class}")
    else:
        yield from _faults(path, member, root)


def _field_faults(path: str, name: str, member: Field, known: _BaseClass) -> Iterator[Fault]:
    kind = known.fields.get(name)
    if kind is None and not known.open:
        yield Fault(path, "found a field of this name; expected none in a group of this class")
    elif kind is not None and not _is(member, kind):
        yield Fault(path, f"found no {kind}; expected one")
    for wrong in {"signal", "axis"} & member.attributes.keys():
        yield Fault(path, f"found the attribute {wrong!r} at a field; expected it at its group")


def _uncertainty_faults(path: str, group: Group) -> Iterator[Fault]:
    """Find uncertainties, <name>_errors, that do not belong to a number of the same unit."""
    for name, member in group.members.items():
        of = group.members.get(name.removesuffix("_errors"))
        if of is member:
            continue
        told = (of, member)
        if not all(isinstance(one, Field) and one.kind in _NUMBER for one in told) or _unit(of) != _unit(member):
            yield Fault(f"{path}/{name}", "found an uncertainty without a number of its unit; expected one beside it")


def _is(member: Field, kind: _Kind) -> bool:
    if kind == "any":
        return True
    if kind == "count":
        return member.kind in _NUMBER[1:] and member.shape == ()
    return member.text is not None and (kind == "text" or _is_date(member.text))


def _is_date(text: str) -> bool:
    try:
        datetime.fromisoformat(text)
    except ValueError:
        return False
    return True


def _data_faults(path: str, data: Group, root: Group) -> Iterator[Fault]:
    """Find what keeps a viewer from plotting."""
    signal = _plotted(data, _text(data, "signal"), root)
    if signal is None:
        yield Fault(path, f"found no field for the signal {_text(data, 'signal')!r}; expected one")
        return
    axes = _texts(data, "axes")
    if len(axes) != len(signal.shape):
        yield Fault(path, f"found {len(axes)} axes; expected {len(signal.shape)}, as the signal has dimensions")
    for place, (axis, length) in enumerate(zip(axes, signal.shape, strict=False)):
        yield from _axis_faults(path, data, axis, place, length, root)
    for name in _texts(data, "auxiliary_signals"):
        other = _plotted(data, name, root)
        if other is None or other.shape != signal.shape:
            yield Fault(path, f"found no field of the signal's shape for {name!r}; expected one")
    yield from _unit_faults(path, data, [_text(data, "signal") or "", *axes, *_texts(data, "auxiliary_signals")], root)


def _axis_faults(path: str, data: Group, axis: str, place: int, length: int, root: Group) -> Iterator[Fault]:
    if axis == ".":
        return
    field = _plotted(data, axis, root)
    if field is None:
        yield Fault(path, f"found no field for the axis {axis!r}; expected one")
    elif field.shape != (length,):
        yield Fault(path, f"found the axis {axis!r} of shape {field.shape}; expected ({length},), as the signal is")
    if data.attributes.get(f"{axis}_indices", -1) != place:
        yield Fault(path, f"found no attribute {axis}_indices that is {place}; expected one")


def _unit_faults(path: str, data: Group, names: Sequence[str], root: Group) -> Iterator[Fault]:
    for name in names:
        field = _plotted(data, name, root)
        if field is not None and _unit(field) is None:
            yield Fault(f"{path}/{name}", "found no units; expected the attribute at all that is plotted")


def _default_faults(root: Group) -> Iterator[Fault]:
    """Follow what a viewer opens first."""
    entry = root.members.get(_text(root, "default") or "")
    data = entry.members.get(_text(entry, "default") or "") if isinstance(entry, Group) else None
    if not isinstance(data, Group) or _text(data, "NX_class") != "NXdata":
        yield Fault("", "found no plot by the attributes 'default'; expected them to lead to an NXdata")


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
