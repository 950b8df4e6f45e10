"""Columns of an archived run as CSV: all numbers in full precision, in the units of the archive."""

import csv
import io
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import h5py
import numpy as np
import orjson
from numpy.typing import NDArray

from tribopipe.archive.hdf5_compression import unpacked
from tribopipe.archive.runfile import read_cleaned
from tribopipe.archive.store import Archive
from tribopipe.base.errors import ArchiveError
from tribopipe.documents.signals import SIGNALS, SignalName
from tribopipe.physics.laws import LAWS, law_title

Columns = dict[str, NDArray[Any]]
"""Columns of equal length by their headers."""
_ROWS = 65_536
"""Number of rows written at once."""
_FORMULA = ("=", "+", "-", "@", "\t", "\r")
"""First characters of texts that spreadsheets would treat as formulas."""


class _Kind(NamedTuple):
    """Data of a run that form a table."""

    meaning: str
    path: str
    """Member of the entry in runs that have this table."""
    read: Callable[[h5py.File], Columns]


def csv_kinds(archive: Archive, run_id: str) -> list[str]:
    """Return those of ``CSV_KINDS`` that a run has. Raises ``ArchiveError`` if there is no such run."""
    with archive.open(run_id) as file:
        return [name for name, kind in _KINDS.items() if kind.path in file["entry"]]


def csv_parts(archive: Archive, run_id: str, what: str) -> Iterator[bytes]:
    """Return an iterator over the parts of one of ``CSV_KINDS`` of a run as CSV (RFC 4180), in UTF-8.

    Headers are names and units, "depth [m]"; missing values are empty fields. Raises ``ArchiveError``, before the first
    part, if the run does not exist, has no such table, or stores data in another file.
    """
    return csv_of(csv_columns(archive, run_id, what))


def csv_columns(archive: Archive, run_id: str, what: str) -> Columns:
    """Return one of ``CSV_KINDS`` of a run as columns of equal length by header; raises as ``csv_parts`` does."""
    there = csv_kinds(archive, run_id)
    if what not in there:
        raise lacking(run_id, what, there)
    with archive.open(run_id) as file:
        columns = _KINDS[what].read(file)
        if len({len(values) for values in columns.values()}) != 1:
            raise ValueError(f"columns of different lengths for the table {what!r}")
    return columns


def lacking(run_id: str, what: str, there: Sequence[str]) -> ArchiveError:
    """Return the error message for a table that a run does not have, which lists its tables."""
    return ArchiveError(f"{run_id}: found no table {what!r}; expected one of: {', '.join(there)}")


def csv_of(columns: Columns) -> Iterator[bytes]:
    """Yield columns by their headers as a CSV file, in parts."""
    yield csv_lines([list(columns)])
    arrays = list(columns.values())
    numeric = all(values.dtype.kind in "fiu" for values in arrays)
    for start in range(0, len(arrays[0]), _ROWS):
        block = [values[start : start + _ROWS] for values in arrays]
        yield _numbers(np.column_stack(block).astype(np.float64)) if numeric else csv_lines(zip(*block, strict=True))


def _numbers(block: NDArray[np.float64]) -> bytes:
    """Format rows of numbers with the fewest digits that distinguish each from all others.

    By JSON's writer, which is forty times faster than Python's own.
    """
    if np.isinf(block).any():
        return csv_lines(block)
    written = orjson.dumps(np.ascontiguousarray(block), option=orjson.OPT_SERIALIZE_NUMPY)
    return written[2:-2].replace(b"],[", b"\r\n").replace(b"null", b"") + b"\r\n"


def csv_lines(rows: Any) -> bytes:
    """Format rows of texts and numbers, with an empty field for an unknown number."""
    written = io.StringIO(newline="")
    csv.writer(written).writerows([csv_field(value) for value in row] for row in rows)
    return written.getvalue().encode("utf-8", "backslashreplace")


def csv_field(value: Any) -> str:
    """Return a CSV field; strings that a spreadsheet would interpret as formulas are prefixed with an apostrophe."""
    if not isinstance(value, str):
        return "" if np.isnan(value) else repr(float(value))
    return f"'{value}" if value.startswith(_FORMULA) and not _is_number(value) else value


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _raw(file: h5py.File) -> Columns:
    raw = file["entry/raw"]
    return dict(_column(raw, name) for name in SIGNALS if name in raw)


def _cleaned(file: h5py.File) -> Columns:
    return {head_of(name, SIGNALS[name].unit): values for name, values in read_cleaned(file).columns.items()}


def _other_columns(file: h5py.File) -> Columns:
    found: Columns = {}
    for column in file["entry/extra_columns"].values():
        textual = h5py.check_string_dtype(column.dtype)
        found[_unused(_extra_head(column), found)] = column.asstr()[()] if textual else unpacked(column)
    return found


def _extra_head(column: h5py.Dataset) -> str:
    name, unit = str(column.attrs["column_name"]), str(column.attrs["column_unit"])
    return head_of(name, unit) if unit and unit not in name else name


def _unused(head: str, columns: Mapping[str, object]) -> str:
    """Return a header that no column has yet."""
    number, found = 2, head
    while found in columns:
        found, number = f"{head} ({number})", number + 1
    return found


def _friction(file: h5py.File) -> Columns:
    """Return preprocessed friction with the fit."""
    run, fit = read_cleaned(file), file["entry/friction_fit/data"]
    names: list[SignalName] = ["time", "rotations", "sliding_distance", "friction_coefficient"]
    columns = {head_of(name, SIGNALS[name].unit): run.columns[name] for name in names if name in run.columns}
    return columns | {"fitted_friction_coefficient [1]": unpacked(fit["friction_coefficient"])}


def _over_samples(path: str) -> Callable[[h5py.File], Columns]:
    """Return a function that reads data along the samples of a run: first time, then the axis, then the curves."""

    def read(file: h5py.File) -> Columns:
        entry = file["entry"]
        times = [entry[f"{data}/time"] for data in ("clean_up/data", "raw") if f"{data}/time" in entry]
        return ({"time [s]": unpacked(times[0])} if times else {}) | _plotted(entry[path])

    return read


def _course(path: str) -> Callable[[h5py.File], Columns]:
    return lambda file: _plotted(file[f"entry/{path}"])


def _plotted(data: h5py.Group) -> Columns:
    """Return the axis and the signals of an NXdata group over one axis."""
    axes = [axis for axis in data.attrs["axes"] if axis != "."]
    names = [*axes, data.attrs["signal"], *data.attrs.get("auxiliary_signals", [])]
    return dict(_column(data, name) for name in names)


def _column(group: h5py.Group, name: str) -> tuple[str, NDArray[Any]]:
    return head_of(name, str(group[name].attrs["units"])), unpacked(group[name])


def head_of(name: str, unit: str) -> str:
    """Return the header of a column: "depth [m]"."""
    return f"{name} [{unit}]"


_KINDS: dict[str, _Kind] = {
    "raw": _Kind("signals as ingested", "raw", _raw),
    "cleaned": _Kind("preprocessed signals", "clean_up", _cleaned),
    "other-columns": _Kind("other columns of the source files", "extra_columns", _other_columns),
    "corrected": _Kind("wear corrected for drift", "drift_correction/data", _over_samples("drift_correction/data")),
    "friction": _Kind("friction coefficient with its fit", "friction_fit/data", _friction),
    "wear": _Kind("corrected wear with the fitted laws, µm", "wear", _over_samples("wear")),
    **{
        f"{name}-{law}": _Kind(f"{meaning} ({law_title(law)})", path, _over_samples(path))
        for name, step, meaning in (("fit", "wear_fit", "fitted wear"), ("prediction", "prediction", "predicted wear"))
        for law in LAWS
        for path in [f"{step}_{law}/data"]
    },
    **{
        f"local-wear-{law}": _Kind(f"local wear ({law_title(law)})", path, _course(path))
        for law in LAWS
        for path in [f"local_wear_{law}/course"]
    },
}
CSV_KINDS: dict[str, str] = {name: kind.meaning for name, kind in _KINDS.items()}
"""Tables that a run may have, with their content."""
