"""Numbers and texts of records by name: what a crate shows of a run without its files being opened."""

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from tribopipe.documents.quantity import Quantity
from tribopipe.documents.record import Record


class Told(NamedTuple):
    """One number or text of a record."""

    key: str
    """As in the document or the archive, with points between: "conditions.normal_load"."""
    value: float | str
    unit: str | None = None
    """SI unit; none of a text."""
    standard_uncertainty: float | None = None
    """In ``unit``."""
    interval: tuple[float, float] | None = None
    """Coverage interval, in ``unit``."""
    meaning: str = ""


def told(record: Record, prefix: str) -> Iterator[Told]:
    """Give the quantities of a record and of the records in it, and its texts and numbers."""
    for name, field in type(record).model_fields.items():
        one = _told(f"{prefix}.{name}", getattr(record, name), (field.description or "").partition("\n\n")[0])
        beside = getattr(record, "interval", None) if name == "wear_coefficient" else None
        for found in one:
            yield found if beside is None else found._replace(interval=(beside[0].value, beside[1].value))


def _told(key: str, value: Any, meaning: str) -> Iterator[Told]:
    if isinstance(value, Quantity):
        yield Told(key, value.value, value.unit, value.standard_uncertainty, meaning=meaning)
    elif isinstance(value, Record):
        yield from told(value, key)
    elif isinstance(value, Mapping):
        for name, one in value.items():
            yield from _told(f"{key}.{name}", one, meaning)
    elif isinstance(value, str):
        yield Told(key, value, meaning=meaning)
    elif isinstance(value, int | float) and not isinstance(value, bool):
        yield Told(key, float(value), "1", meaning=meaning)
