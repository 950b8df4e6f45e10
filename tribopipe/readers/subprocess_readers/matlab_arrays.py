"""Variables of a MAT-file (MATLAB, Octave) as tables.

The answer is a line of JSON with the tables, then their numbers as float64. A table is made of the vectors of one
length in the workspace or a struct; a matrix counts where a list of as many names stands next to it. Other arrays of
numbers next to them are named as omitted. Numbers and texts that stand next to the vectors, in a struct of their own or
further outside are settings.
"""

import io
import json
import sys
from collections import Counter
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from scipy.io import loadmat

_DEEPEST = 8


def main() -> None:
    """Answer with the tables, or end with what is wrong."""
    try:
        content = loadmat(io.BytesIO(sys.stdin.buffer.read()), simplify_cells=True)
        variables = {name: value for name, value in content.items() if not name.startswith("__")}
        tables = list(_tables("", variables, []))
    except Exception as error:  # noqa: BLE001 - scipy raises whatever a damaged file makes it stumble on
        sys.exit(f"{type(error).__name__}: {error}".replace("\n", " "))
    said = [
        {
            "name": table["name"],
            "settings": table["settings"],
            "omitted": table["omitted"],
            "columns": [{"name": name, "rows": len(values)} for name, values in table["columns"]],
        }
        for table in tables
    ]
    sys.stdout.buffer.write(json.dumps(said).encode("ascii") + b"\n")
    for table in tables:
        for _, values in table["columns"]:
            sys.stdout.buffer.write(values.astype("<f8").tobytes())


def _tables(path: str, struct: Mapping[str, Any], outside: list[tuple[str, str]]) -> Iterator[dict[str, Any]]:
    """Give the table of a struct, and those of the structs in it."""
    settings = [*outside, *_settings(struct)]
    columns = list(_columns(struct))
    rows = Counter(len(values) for _, values in columns).most_common(1)
    kept = [(name, values) for name, values in columns if len(values) == rows[0][0]]
    if len(kept) > 1:
        omitted = [name for name, values in columns if len(values) != rows[0][0]] + _without_columns(struct)
        yield {"name": path, "settings": settings, "omitted": omitted, "columns": kept}
    if path.count(".") < _DEEPEST:
        for name, inner in _structs(struct):
            yield from _tables(f"{path}.{name}".lstrip("."), inner, settings)


def _structs(struct: Mapping[str, Any]) -> Iterator[tuple[str, Mapping[str, Any]]]:
    """Give the structs in a struct, and the elements of its arrays of structs."""
    for name, value in struct.items():
        if isinstance(value, Mapping):
            yield name, value
        elif isinstance(value, list):
            yield from ((f"{name}({i})", one) for i, one in enumerate(value, 1) if isinstance(one, Mapping))


def _settings(struct: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Give the numbers and texts of a struct, and of those structs in it that hold nothing else."""
    for name, value in struct.items():
        if isinstance(value, str | int | float | np.number) and not isinstance(value, bool):
            yield name, value if isinstance(value, str) else repr(float(value))
        elif isinstance(value, Mapping) and not any(_columns(value)) and not any(_structs(value)):
            yield from _settings(value)


def _columns(struct: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    """Give vectors, and columns of matrices whose names stand next to them."""
    lists = _lists_of_names(struct)
    for name, value in struct.items():
        yield from _columns_of(name, value, lists)


def _columns_of(name: str, value: Any, lists: list[list[str]]) -> Iterator[tuple[str, Any]]:
    """Give the columns of one variable; none of complex numbers, which no signal consists of."""
    if not (isinstance(value, np.ndarray) and value.dtype.kind in "fiub"):
        return
    if value.ndim == 1 and len(value) > 1:
        yield name, value
    elif value.ndim == 2:
        names = next((names for names in lists if len(names) == value.shape[1]), ())
        yield from zip(names, value.T, strict=False)


def _without_columns(struct: Mapping[str, Any]) -> list[str]:
    """Name the arrays of numbers that give no column: matrices without names next to them, and complex vectors."""
    lists = _lists_of_names(struct)
    arrays = {
        name: value
        for name, value in struct.items()
        if isinstance(value, np.ndarray) and value.dtype.kind in "fiubc" and value.size > 1
    }
    return [name for name, value in arrays.items() if not any(True for _ in _columns_of(name, value, lists))]


def _lists_of_names(struct: Mapping[str, Any]) -> list[list[str]]:
    return [names for names in map(_names, struct.values()) if names]


def _names(value: Any) -> list[str]:
    """Return the texts of a cell array or of rows of characters; none where it holds anything else."""
    texts = value.tolist() if isinstance(value, np.ndarray) and value.dtype.kind in "OU" else value
    return (
        [text.strip() for text in texts] if isinstance(texts, list) and all(isinstance(t, str) for t in texts) else []
    )


if __name__ == "__main__":
    main()
