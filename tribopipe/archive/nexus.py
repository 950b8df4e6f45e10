"""Small writers and readers of NeXus groups and fields, so that units, compression and text are the same everywhere."""

import json
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from tribopipe.records.base import Record
from tribopipe.records.quantity import Quantity

_CHUNK = 65_536
_COMPRESSED_FROM = 256


def group(parent: h5py.Group, name: str, nx_class: str, **attributes: Any) -> h5py.Group:
    """Add a group of a NeXus class; its members keep their order."""
    made = parent.create_group(name, track_order=True)
    made.attrs["NX_class"] = nx_class
    made.attrs.update(attributes)
    return made


def field(parent: h5py.Group, name: str, value: Any, unit: str | None = None, **attributes: Any) -> h5py.Dataset:
    """Add a field: a number, a text, or an array, which is compressed and checksummed."""
    options: dict[str, Any] = {}
    if isinstance(value, np.ndarray) and value.dtype != object and value.size >= _COMPRESSED_FROM:
        options = {
            "chunks": (min(len(value), max(1, _CHUNK * len(value) // value.size)), *value.shape[1:]),
            "compression": "gzip",
            "compression_opts": 4,
            "shuffle": True,
            "fletcher32": True,
        }
    if isinstance(value, np.ndarray) and value.dtype == object:
        options["dtype"] = h5py.string_dtype()
    made = parent.create_dataset(name, data=value, **options)
    if unit is not None:
        made.attrs["units"] = unit
    made.attrs.update(attributes)
    return made


def quantity(parent: h5py.Group, name: str, value: Quantity) -> None:
    """Add a quantity as a field with its unit, and its standard uncertainty as NeXus' <name>_errors."""
    field(parent, name, value.value, value.unit)
    if value.standard_uncertainty is not None:
        field(parent, f"{name}_errors", value.standard_uncertainty, value.unit)


def document(parent: h5py.Group, name: str, content: Record | list[Any] | dict[str, Any]) -> h5py.Group:
    """Add a record, or what is JSON already, in an NXnote, from which it comes back to the last digit."""
    text = content.model_dump_json(by_alias=True) if isinstance(content, Record) else json.dumps(content)
    note = group(parent, name, "NXnote")
    field(note, "type", "application/json")
    field(note, "data", text)
    return note


def told(parent: h5py.Group, name: str) -> dict[str, str]:
    """Read texts by name; none where there is no such document, as in files of the first format."""
    return json.loads(text(parent, f"{name}/data")) if name in parent else {}


def text(parent: h5py.Group, path: str) -> str:
    """Read a text field."""
    return str(parent[path].asstr()[()])


def summary(parent: h5py.Group, record: Record, prefix: str = "") -> None:
    """Add the fields of a result one by one, for people and viewers; those of a record in it with its name before."""
    for name in type(record).model_fields:
        value = getattr(record, name)
        if isinstance(value, Record) and not isinstance(value, Quantity):
            summary(parent, value, f"{prefix}{name}_")
        else:
            _summarised(parent, f"{prefix}{name}", value)


def _summarised(parent: h5py.Group, name: str, value: Any) -> None:
    if isinstance(value, Quantity):
        quantity(parent, name, value)
    elif isinstance(value, bool):
        field(parent, name, int(value))
    elif isinstance(value, str | int | float):
        field(parent, name, value)
    elif isinstance(value, tuple) and len(value) == 2 and all(isinstance(end, Quantity) for end in value):
        for suffix, end in zip(("lower", "upper"), value, strict=True):
            quantity(parent, f"{name}_{suffix}", end)
    elif isinstance(value, tuple) and value and all(isinstance(item, str) for item in value):
        field(parent, name, "; ".join(value))


def floats(parent: h5py.Group, name: str) -> NDArray[np.float64]:
    """Read a numeric field."""
    return np.asarray(parent[name][()], dtype=np.float64)
