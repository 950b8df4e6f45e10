"""One run as a list tells it, and the order of several."""

import sqlite3
from collections.abc import Callable, Iterable
from functools import cache

from tribopipe.archive.catalogue.columns import COLUMNS, ITEM, ListedColumn, column_named
from tribopipe.files import natural_order


class ListedRun:
    """One run: what is known of it in each column."""

    def __init__(self, row: sqlite3.Row) -> None:
        self._row = row

    def __repr__(self) -> str:
        return f"ListedRun({self.id!r})"

    @property
    def id(self) -> str:
        """Name of the run."""
        return str(self._row["id"])

    def text(self, name: str) -> str:
        """Return what is shown in a column, numbers without their unit; empty where nothing is known."""
        column = COLUMNS[name]
        if column.kind == "number":
            return self._row[f"{name}_shown"] or ""
        if column.kind == "date":
            return (self._row[name] or "")[:16].replace("T", " ")
        return (column.joint or " ").join(self.texts(name))

    def texts(self, name: str) -> list[str]:
        """Return the texts in a column that may hold several, such as the tags."""
        held = self._row[name]
        return held.split(ITEM) if held else []

    def number(self, name: str) -> float | None:
        """Return a number in the unit of its column; none where nothing is known."""
        return _shown(COLUMNS[name])(self.value(name))

    def spread(self, name: str) -> float | None:
        """Return the standard uncertainty of a number in the unit of its column; none where nothing is known."""
        return _shown(COLUMNS[name], spread=True)(self.uncertainty(name))

    def value(self, name: str) -> float | None:
        """Return a number in SI; none where nothing is known."""
        return self._row[name]  # type: ignore[no-any-return]

    def uncertainty(self, name: str) -> float | None:
        """Return the standard uncertainty of a number in SI; none where nothing is known."""
        return self._row[f"{name}_uncertainty"]  # type: ignore[no-any-return]

    def date(self, name: str) -> str | None:
        """Return a date as run.toml has it, ISO 8601; none where nothing is known."""
        return self._row[name]  # type: ignore[no-any-return]


@cache
def _shown(column: ListedColumn, *, spread: bool = False) -> Callable[[float | None], float | None]:
    """Return what turns SI into the unit of a column, in as many digits as are sure."""
    from tribopipe.units import KINDS, from_si, interval_from_si

    convert, si = interval_from_si if spread else from_si, KINDS[column.measures].si
    return lambda value: None if value is None else float(f"{convert(value, si, column.unit):.15g}")


def in_order(runs: Iterable[ListedRun], sort: str) -> list[ListedRun]:
    """Return runs in the order of some columns, "material,-k_d"; unknown comes last, before and after a minus alike.

    Raises ``QueryError`` where there is no such column.
    """
    ordered, names = list(runs), sort.split(",")
    for name in ("id", *reversed(names)) if names[0] != "id" else ("id",):
        column = column_named(name.strip().removeprefix("-"), " to sort by")
        ordered = _by(ordered, column, descending=name.strip().startswith("-"))
    return ordered


def _by(runs: list[ListedRun], column: ListedColumn, *, descending: bool) -> list[ListedRun]:
    key: Callable[[ListedRun], object] = (
        (lambda run: run.value(column.name))
        if column.kind == "number"
        else (lambda run: natural_order(run.text(column.name).casefold()))
    )
    known = [run for run in runs if run.text(column.name)]
    unknown = [run for run in runs if not run.text(column.name)]
    return [*sorted(known, key=key, reverse=descending), *unknown]  # type: ignore[arg-type]
