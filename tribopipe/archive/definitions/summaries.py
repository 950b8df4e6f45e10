"""What the fields are that show a record one by one, given by its type: the twin of ``nexus.summarised``."""

from collections.abc import Iterator
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, NamedTuple, Union, get_args, get_origin

from tribopipe.archive.definitions.parts import FieldPart, Kind
from tribopipe.documents.contact_kinds import contacts
from tribopipe.documents.quantity import Quantity, Unit
from tribopipe.documents.record import Record

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
        yield FieldPart(name, f"{doc} Several with semicolons between them.")


def _is(plain: Any, kind: type[Record]) -> bool:
    return isinstance(plain, type) and issubclass(plain, kind)
