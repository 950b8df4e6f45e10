"""What a file of the archive is declared to hold: groups, fields and links, in the words of NeXus' NXDL.

With declarations that files of runs and of studies share.

Fields that show a record one by one are given by its type: see ``shown_fields``, the twin of ``nexus.summarised``.
"""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, NamedTuple, TypeAlias, TypeVar, Union, get_args, get_origin

from tribopipe.documents.contact_kinds import contacts
from tribopipe.documents.quantity import Quantity, Unit
from tribopipe.documents.record import Record

Kind = Literal["NX_CHAR", "NX_DATE_TIME", "NX_FLOAT", "NX_INT", "NX_POSINT", "NX_BINARY", "NX_CHAR_OR_NUMBER"]


@dataclass(frozen=True)
class FieldPart:
    """A dataset."""

    name: str
    """Capital letters in it stand for whatever a file puts there."""
    doc: str
    kind: Kind = "NX_CHAR"
    units: tuple[str, ...] = ()
    """Units that it may have, as files write them; none for what has no unit."""
    required: bool = False
    values: tuple[str, ...] = ()
    """Texts that it may hold; none where it may hold any."""
    attributes: tuple[str, ...] = ()
    """Names of its attributes with units."""


@dataclass(frozen=True)
class LinkPart:
    """A name for a field that lies elsewhere in the file."""

    name: str
    target: str
    """Where it usually leads, by names and classes."""
    required: bool = True


@dataclass(frozen=True)
class GroupPart:
    """A group with all that may be in it."""

    name: str
    """As that of a field; empty where groups of the class may have any name."""
    nx_class: str
    doc: str
    members: "tuple[Part, ...]" = ()
    required: bool = False
    attributes: tuple[str, ...] = ()
    """Names of its attributes with those that NeXus has for its class."""

    def member(self, name: str, nx_class: str | None) -> "Part | None":
        """Return what is declared of a member: by its name, or of a group by its class; none where it is not."""
        exactly = (part for part in self.members if part.name == name)
        partly = (part for part in self.members if is_partial(part.name) and _stands_for(part.name, name))
        classed = (part for part in self.members if not part.name and getattr(part, "nx_class", None) == nx_class)
        return next((part for found in (exactly, partly, classed) for part in found), None)


Part: TypeAlias = FieldPart | LinkPart | GroupPart


@dataclass(frozen=True)
class Definition:
    """A NeXus application definition."""

    name: str
    version: int
    """That of the format of its files."""
    doc: str
    entry: GroupPart


def is_partial(declared: str) -> bool:
    """Return whether a part of a declared name is what files put there."""
    return declared != declared.lower()


def _stands_for(declared: str, name: str) -> bool:
    return re.fullmatch(re.sub("[A-Z]+", r"\\w+", declared), name) is not None


Name = TypeVar("Name", bound=str)


def text(name: str, doc: str, *, required: bool = True) -> FieldPart:
    """Declare a text."""
    return FieldPart(name, doc, required=required)


def defined(name: str) -> FieldPart:
    """Declare the field that names the definition; its version is that of the format of the file."""
    return FieldPart("definition", "Name of this definition.", required=True, values=(name,), attributes=("version",))


def document(name: str, doc: str, *, required: bool = True) -> GroupPart:
    """Declare a JSON document, as ``nexus.document`` writes it."""
    members = (text("type", "application/json."), text("data", "Content as JSON."))
    return GroupPart(name, "NXnote", doc, members, required)


def process(name: str, doc: str, *members: Part, required: bool = False) -> GroupPart:
    """Declare a step of processing: what is known of every one, and its own members."""
    common = (
        text("program", "Name of the program."),
        text("version", "Version of the program."),
        FieldPart("date", "Date of the computation.", "NX_DATE_TIME", required=True),
        document("environment", "Software versions of the computation.", required=False),
    )
    return GroupPart(name, "NXprocess", doc, (*common, *members), required)


def columns(units: Mapping[str, str], *, required: bool = True) -> Iterator[FieldPart]:
    """Declare columns of numbers by their names with their units."""
    for name, unit in units.items():
        yield FieldPart(name, _in_words(name), "NX_FLOAT", (unit,), required)


def banded(units: Mapping[Name, str]) -> dict[str, str]:
    """Return the fields of curves with their units, and of both ends of their 95 % intervals."""
    return {f"{name}{end}": unit for name, unit in units.items() for end in ("", "_lower", "_upper")}


def drawn_against(axis: str) -> LinkPart:
    """Declare the axis of curves over the samples of a run."""
    return LinkPart(axis, f"/NXentry/raw:NXdata/{axis}")


def _in_words(name: str) -> str:
    for end in ("lower", "upper"):
        if name.endswith(f"_{end}"):
            return f"{end.capitalize()} limit of the 95 % interval of {name.removesuffix(f'_{end}')}."
    return f"{name.replace('_', ' ').capitalize()}."


_KINDS: dict[object, Kind] = {str: "NX_CHAR", bool: "NX_INT", int: "NX_INT", float: "NX_FLOAT"}


class _Type(NamedTuple):
    """What a field of a record may hold."""

    plain: Any
    units: tuple[str, ...]
    always: bool
    """Whether it holds something in any case."""


def shown_fields(record: type[Record], prefix: str = "", *, always: bool = True) -> Iterator[FieldPart]:
    """Return the fields of a record type; they are optional unless it is ``always`` present."""
    for name, told in record.model_fields.items():
        units = tuple(said.si for said in told.metadata if isinstance(said, Unit))
        found = _taken_apart(told.annotation, units)
        found = found._replace(always=found.always and always and told.is_required())
        yield from _shown(f"{prefix}{name}", told.description or "", found)


def _taken_apart(annotation: Any, units: tuple[str, ...] = ()) -> _Type:
    if get_origin(annotation) is Annotated:
        plain, *said = get_args(annotation)
        return _taken_apart(plain, tuple(one.si for one in said if isinstance(one, Unit)))
    if get_origin(annotation) in (Union, UnionType):
        inner = [one for one in get_args(annotation) if one is not NoneType]
        return _taken_apart(inner[0] if len(inner) == 1 else tuple(inner))._replace(always=False)
    return _Type(annotation, units, always=True)


def _shown(name: str, doc: str, found: _Type) -> Iterator[FieldPart]:
    if _is(found.plain, Quantity):
        yield FieldPart(name, doc, "NX_FLOAT", found.units, found.always)
        yield FieldPart(f"{name}_errors", f"Standard uncertainty of {name}.", "NX_FLOAT", found.units)
    elif get_origin(found.plain) is dict and name == "bodies":
        for body in dict.fromkeys(name for contact in contacts().values() for name in contact.body_names):
            yield from _shown(body, "", _taken_apart(get_args(found.plain)[1])._replace(always=False))
    elif _is(found.plain, Record):
        yield from shown_fields(found.plain, f"{name}_", always=found.always)
    elif get_origin(found.plain) is Literal:
        yield FieldPart(name, doc, required=found.always, values=get_args(found.plain))
    elif found.plain in _KINDS:
        yield FieldPart(name, doc, _KINDS[found.plain], required=found.always)
    elif get_origin(found.plain) is tuple:
        yield from _shown_together(name, doc, found)


def _shown_together(name: str, doc: str, found: _Type) -> Iterator[FieldPart]:
    """Declare the two ends of an interval, or a list of texts; other lists are not shown."""
    first, last = (_taken_apart(one) for one in get_args(found.plain))
    if last.plain is not Ellipsis and _is(first.plain, Quantity):
        yield from _shown(f"{name}_lower", f"{doc} Lower end.", first._replace(always=found.always))
        yield from _shown(f"{name}_upper", f"{doc} Upper end.", last._replace(always=found.always))
    elif last.plain is Ellipsis and (first.plain is str or get_origin(first.plain) is Literal):
        yield FieldPart(name, f"{doc} Several values are separated by semicolons.")


def _is(plain: Any, kind: type[Record]) -> bool:
    return isinstance(plain, type) and issubclass(plain, kind)
