"""Any part of a run's HDF5 file on a terminal: a group as a tree, a plot as a table, a dataset as its values."""

import json
import math
from collections.abc import Iterator, Sequence
from itertools import chain
from typing import TYPE_CHECKING, Any

from tribopipe.cli.output import print_result, seen, table
from tribopipe.cli.pages import heading

if TYPE_CHECKING:
    import h5py

    from tribopipe.archive.part_by_path import Part
    from tribopipe.archive.store import Archive

_DEPTH = 2
"""Levels that are shown below a group."""
_LONGEST = 60
"""Largest number of characters of a text that are shown in a tree."""
_BESIDE = ("NX_class", "units")
"""Attributes that are shown next to the name of their group or dataset."""


def show_part(store: "Archive", run_id: str, path: str, rows: int) -> None:
    """Show a part of a run's file; of many values, only the first and last ``rows``.

    Raises ``ArchiveError`` if there is no such part, or it lies in another file.
    """
    from tribopipe.archive.part_by_path import find_part

    with store.open(run_id) as file:
        part = find_part(file, path)
        # All is read before anything is said: what is damaged is one sentence.
        lines, columns = [*_attributes(part), *_lines(part, rows)], _columns(part)
        heads, cells = [_head(name, column) for name, column in columns.items()], _cells(list(columns.values()), rows)
        name, more = part.name, _described(part)
    heading(name, more, apart=False)
    for line in lines:
        print_result(f"  {line}")
    if heads:
        table("", ["number", *heads], cells)


def part_json(store: "Archive", run_id: str, path: str) -> dict[str, Any]:
    """Return a part of a run's file with its values as JSON types. Raises ``ArchiveError`` as ``show_part`` does."""
    import h5py

    from tribopipe.archive.part_by_path import find_part

    with store.open(run_id) as file:
        part = find_part(file, path)
        told = {"id": run_id, "path": part.name, **_document(part, 1)}
        if isinstance(part, h5py.Dataset):
            return told | {"value": _json(_read(part))}
        return told | {"values": {name: _json(_read(data)) for name, data in _plotted(part).items()}}


def _document(part: "Part", depth: int) -> dict[str, Any]:
    """Return the description of a part and of the members of a group, without columns of values."""
    import h5py

    told: dict[str, Any] = {"attributes": {name: _json(value) for name, value in part.attrs.items()}}
    if isinstance(part, h5py.Dataset):
        told |= {"value": _json(_read(part))} if part.shape == () else {}
        return {"kind": "dataset", "shape": list(part.shape or ()), "type": str(part.dtype)} | told
    if depth > _DEPTH:
        return {"kind": "group"} | told
    return {"kind": "group"} | told | {"members": {name: _member_document(part, name, depth) for name in part}}


def _member_document(group: "h5py.Group", name: str, depth: int) -> dict[str, Any]:
    link = _link(group, name)
    return _document(group[name], depth + 1) if link is None else {"kind": "link", "leads_to": link}


def _lines(part: "Part", rows: int) -> Iterator[str]:
    """Return the content of a part other than columns, line by line: the tree of a group, a note, an array."""
    import h5py

    from tribopipe.archive.part_by_path import find_part

    if isinstance(part, h5py.Dataset):
        yield from _value_lines(part, rows)
        return
    yield from _tree(part, 1)
    if _text(part.attrs.get("NX_class", "")) == "NXnote" and "data" in part:
        data = find_part(part.file, f"{part.name}/data")
        yield from _value_lines(data, rows) if isinstance(data, h5py.Dataset) else ()


def _columns(part: "Part") -> "dict[str, h5py.Dataset]":
    """Return the columns of a table: a dataset that is a column, or the columns of a plot."""
    import h5py

    if isinstance(part, h5py.Dataset):
        return {"value": part} if part.ndim == 1 else {}
    return _beside(part)


def _tree(group: "h5py.Group", depth: int) -> Iterator[str]:
    """Return one line per member of a group, indented by level."""
    import h5py

    for name in group:
        link = _link(group, name)
        if link is not None:
            yield seen(f"{name} -> {link}")
            continue
        part = group[name]
        yield seen(f"{name} {_described(part)}")
        below = _tree(part, depth + 1) if isinstance(part, h5py.Group) and depth < _DEPTH else iter(())
        yield from (f"    {line}" for line in chain(_attributes(part), below))


def _link(group: "h5py.Group", name: str) -> str | None:
    """Return the target of a link; nothing for a member of the group itself."""
    import h5py

    link = group.get(name, getlink=True)
    return str(link.path) if isinstance(link, h5py.SoftLink) else None


def _described(part: "Part") -> str:
    """Describe a part: the class of a group; shape, type and unit of a dataset, or its value if it is a scalar."""
    import h5py

    if isinstance(part, h5py.Group):
        members = "1 member" if len(part) == 1 else f"{len(part)} members"
        return f"({_text(part.attrs.get('NX_class', 'group'))}, {members})"
    unit = f" [{_text(part.attrs['units'])}]" if "units" in part.attrs else ""
    if part.shape != ():
        size = " × ".join(f"{length:,}" for length in part.shape)
        return f"({size}, {'text' if h5py.check_string_dtype(part.dtype) else part.dtype}){unit}"
    value = _text(_read(part))
    return f"= {value if len(value) <= _LONGEST else f'{value[: _LONGEST - 1]}…'}{unit}"


def _attributes(part: "Part") -> Iterator[str]:
    for name, value in part.attrs.items():
        if name not in _BESIDE:
            yield seen(f"@{name} = {_text(value)}")


def _plotted(group: "h5py.Group") -> "dict[str, h5py.Dataset]":
    """Return axes and signals of an NXdata group; nothing for another group."""
    import h5py

    from tribopipe.archive.part_by_path import find_part

    if _text(group.attrs.get("NX_class", "")) != "NXdata":
        return {}
    named = [*_names(group, "axes"), *_names(group, "signal"), *_names(group, "auxiliary_signals")]
    members = set(group)  # a name with slashes would be looked for wherever it leads
    parts = {name: find_part(group.file, f"{group.name}/{name}") for name in named if name in members}
    return {name: part for name, part in parts.items() if isinstance(part, h5py.Dataset)}


def _beside(group: "h5py.Group") -> "dict[str, h5py.Dataset]":
    """Return the datasets of a plot that form a table with its signal; none if the signal is not a column."""
    plotted = _plotted(group)
    signal = next((plotted[name] for name in _names(group, "signal") if name in plotted), None)
    if signal is None or signal.ndim != 1:
        return {}
    return {name: column for name, column in plotted.items() if column.shape == signal.shape}


def _names(group: "h5py.Group", attribute: str) -> list[str]:
    import numpy as np

    return [_text(name) for name in np.atleast_1d(group.attrs.get(attribute, ()))]


def _value_lines(dataset: "h5py.Dataset", rows: int) -> Iterator[str]:
    """Yield the lines of a value: a text in full, the first and last rows of an array."""
    import h5py
    import numpy as np

    if dataset.shape == () and h5py.check_string_dtype(dataset.dtype):
        yield from (seen(line.expandtabs()) for line in _laid_out(str(_read(dataset))).splitlines())
    elif dataset.ndim > 1:
        for number in _ends(len(dataset), rows):
            yield "…" if number is None else f"{number}: {np.array2string(_read(dataset, number), threshold=10 * rows)}"


def _laid_out(text: str) -> str:
    """Return JSON with indentation, and any other text unchanged."""
    try:
        document = json.loads(text)
    except ValueError:
        return text
    return json.dumps(document, indent=2, ensure_ascii=False) if isinstance(document, dict | list) else text


def _cells(columns: "Sequence[h5py.Dataset]", rows: int) -> list[list[str]]:
    """Return the first and last values of columns side by side, preceded by their numbers."""
    return [
        ["…"] * (len(columns) + 1) if number is None else [f"{number:,}", *(_text(_read(c, number)) for c in columns)]
        for number in _ends(len(columns[0]) if columns else 0, rows)
    ]


def _ends(length: int, rows: int) -> Iterator[int | None]:
    """Yield the indices of the first and last rows, and None for the gap between them."""
    if length <= 2 * rows + 1:
        yield from range(length)
        return
    yield from range(rows)
    yield None
    yield from range(length - rows, length)


def _head(name: str, dataset: "h5py.Dataset") -> str:
    return f"{name} [{_text(dataset.attrs['units'])}]" if "units" in dataset.attrs else name


def _read(dataset: "h5py.Dataset", number: int | tuple[()] = ()) -> Any:
    """Return all values, or those of one row."""
    import h5py

    if h5py.check_string_dtype(dataset.dtype):
        return dataset.asstr(errors="backslashreplace")[number]
    return dataset[number]


def _text(value: Any) -> str:
    """Format a value: numbers with eight digits, texts unchanged, several separated by commas."""
    plain = _json(value)
    if isinstance(plain, list):
        return ", ".join(map(_text, plain))
    if isinstance(plain, float):
        return f"{plain:.8g}"
    return "–" if plain is None else str(plain)


def _json(value: Any) -> Any:
    """Return a value as JSON types; NaN, and values that JSON cannot represent, become null or a text."""
    import numpy as np

    plain = value.tolist() if isinstance(value, np.ndarray | np.generic) else value
    if isinstance(plain, list | tuple):
        return [_json(one) for one in plain]
    if isinstance(plain, bytes):
        return plain.decode("utf-8", "backslashreplace")
    if isinstance(plain, float):
        return plain if math.isfinite(plain) else None
    return plain if plain is None or isinstance(plain, str | int | bool) else str(plain)
