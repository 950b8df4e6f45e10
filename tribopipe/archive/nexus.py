"""Small writers and readers of NeXus groups and fields, so that units, compression and text are the same everywhere."""

import json
from collections.abc import Iterable, Iterator, Mapping
from typing import Any, TypeVar, get_args

import h5py
import numpy as np
from numpy.typing import DTypeLike, NDArray

from tribopipe.archive.hdf5_compression import FILTERS, chunk_shape, unpacked, write_packed, write_together
from tribopipe.base.errors import ArchiveError
from tribopipe.base.failures import number_of
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.record import Record

R = TypeVar("R", bound=Record)
Name = TypeVar("Name", bound=str)
_COMPRESSED_FROM = 256


def group(parent: h5py.Group, name: str, nx_class: str, **attributes: Any) -> h5py.Group:
    """Add a group of a NeXus class; its members keep their order."""
    made = parent.create_group(name, track_order=True)
    made.attrs["NX_class"] = nx_class
    made.attrs.update(attributes)
    return made


def field(parent: h5py.Group, name: str, value: Any, unit: str | None = None, **attributes: Any) -> h5py.Dataset:
    """Add a field: a number, a text, or an array, which is compressed and checksummed."""
    if isinstance(value, np.ndarray) and value.dtype != object and value.size >= _COMPRESSED_FROM:
        made = _packed(parent, name, [value], value.shape, value.dtype)
    else:
        texts = isinstance(value, np.ndarray) and value.dtype == object
        made = parent.create_dataset(name, data=value, dtype=h5py.string_dtype() if texts else None)
    if unit is not None:
        made.attrs["units"] = unit
    made.attrs.update(attributes)
    return made


def long_field(
    parent: h5py.Group,
    name: str,
    pieces: Iterable[NDArray[Any]],
    rows: int,
    dtype: DTypeLike,
) -> h5py.Dataset:
    """Add a column of so many rows that come in pieces of any length, of which few are in memory at once.

    Raises ``ValueError`` where more or fewer rows come.
    """
    if rows < _COMPRESSED_FROM:
        return field(parent, name, _short(pieces, rows, dtype))
    return _packed(parent, name, pieces, (rows,), np.dtype(dtype))


def long_fields(
    parent: h5py.Group, units: Mapping[Name, str], rows: int, blocks: Iterable[Mapping[Name, NDArray[Any]]]
) -> None:
    """Add columns of so many numbers, by their names with their units, that come together in blocks of any length.

    Raises ``ValueError`` where more or fewer rows come.
    """
    kind = np.dtype(float)
    made = {
        name: parent.create_dataset(name, (rows,), kind, chunks=chunk_shape((rows,), kind), **FILTERS) for name in units
    }
    write_together(made, blocks)
    for name, unit in units.items():
        made[name].attrs["units"] = unit


def _short(pieces: Iterable[NDArray[Any]], rows: int, dtype: DTypeLike) -> NDArray[Any]:
    whole = np.concatenate([np.empty(0, dtype), *pieces], dtype=dtype)
    if len(whole) != rows:
        raise ValueError(f"{len(whole):,} rows instead of {rows:,}")
    return whole


def _packed(
    parent: h5py.Group, name: str, pieces: Iterable[NDArray[Any]], shape: tuple[int, ...], kind: np.dtype[Any]
) -> h5py.Dataset:
    made = parent.create_dataset(name, shape, kind, chunks=chunk_shape(shape, kind), **FILTERS)
    write_packed(made, pieces)
    return made


def document(parent: h5py.Group, name: str, content: Record | list[Any] | dict[str, Any]) -> h5py.Group:
    """Add a record, or what is JSON already, in an NXnote, from which it comes back to the last digit."""
    text = content.model_dump_json(by_alias=True) if isinstance(content, Record) else json.dumps(content)
    note = group(parent, name, "NXnote")
    field(note, "type", "application/json")
    field(note, "data", text)
    return note


def text_mapping(parent: h5py.Group, name: str) -> dict[str, str]:
    """Read texts by name; empty where there is no such document, as in files of the first format."""
    return json.loads(text(parent, f"{name}/data")) if name in parent else {}


def listed(parent: h5py.Group, name: str, record: type[R]) -> list[R]:
    """Read a list of records; empty where there is no such document. Raises ``ValueError`` where it holds others."""
    items = json.loads(text(parent, f"{name}/data")) if name in parent else []
    return [record.model_validate(item) for item in items]


def text(parent: h5py.Group, path: str) -> str:
    """Read a text field. Raises ``ArchiveError`` where something else stands there."""
    found = _dataset(parent, path)
    if found.rank or found.get_type().get_class() != h5py.h5t.STRING:
        raise _refused(parent, path, f"an array of {found.dtype} with shape {found.shape}")
    into = np.empty((), found.dtype)
    found.read(h5py.h5s.ALL, h5py.h5s.ALL, into)
    return bytes(into[()]).decode()


def floats(parent: h5py.Group, name: str) -> NDArray[np.float64]:
    """Read a numeric field. Raises ``ArchiveError`` where something else stands there."""
    found = h5py.Dataset(_dataset(parent, name))
    if found.dtype.kind not in "fiu":
        raise _refused(parent, name, "texts")
    return np.asarray(unpacked(found), dtype=np.float64)


def _dataset(parent: h5py.Group, path: str) -> h5py.h5d.DatasetID:
    try:
        found = h5py.h5o.open(parent.id, path.encode())
    except KeyError as error:
        if number_of(error):
            raise  # the system did not give what may be there
        raise _refused(parent, path, "nothing") from None
    if not isinstance(found, h5py.h5d.DatasetID):
        raise _refused(parent, path, "no dataset")
    return found


def _refused(parent: h5py.Group, path: str, found: str) -> ArchiveError:
    return ArchiveError(
        f"{parent.file.filename}: found a damaged file ({found} at {str(parent.name).rstrip('/')}/{path}); expected "
        "an unmodified tribopipe file; restore it from a backup"
    )


def summary(parent: h5py.Group, record: Record) -> None:
    """Add the fields of a result one by one, for people and viewers."""
    for shown in summarised(record):
        field(parent, *shown)


def summarised(record: Record, prefix: str = "") -> Iterator[tuple[str, float | str, str | None]]:
    """Return what a summary shows, with its unit; fields of a record within the record with its name before theirs.

    Of bodies each has its own name before its fields: "pin_wear_coefficient".
    """
    for name, told in type(record).model_fields.items():
        show = _of_bodies if name == "bodies" else _listed if Ellipsis in get_args(told.annotation) else _shown
        yield from show(f"{prefix}{name}", getattr(record, name))


def _of_bodies(_: str, bodies: Mapping[str, Any]) -> Iterator[tuple[str, float | str, str | None]]:
    for body, found in bodies.items():
        yield from _shown(body, found)


def _listed(name: str, values: tuple[Any, ...]) -> Iterator[tuple[str, str, None]]:
    if values and all(isinstance(item, str) for item in values):
        yield name, "; ".join(values), None


def _shown(name: str, value: Any) -> Iterator[tuple[str, float | str, str | None]]:
    if isinstance(value, Quantity):
        yield name, value.value, value.unit
        if value.standard_uncertainty is not None:
            yield f"{name}_errors", value.standard_uncertainty, value.unit  # as NeXus calls it
    elif isinstance(value, Record):
        yield from summarised(value, f"{name}_")
    elif isinstance(value, str | int | float):
        yield name, int(value) if isinstance(value, bool) else value, None
    elif isinstance(value, tuple) and len(value) == 2 and all(isinstance(end, Quantity) for end in value):
        for suffix, end in zip(("lower", "upper"), value, strict=True):
            yield from _shown(f"{name}_{suffix}", end)
