"""One run as a list gives it, and the order of several."""

import sqlite3
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cache
from typing import Any

from tribopipe.archive.catalog.columns import COLUMNS, ITEM, ListedColumn, column_named
from tribopipe.base.files import natural_order


class ListedRun:
    """One run: what is known of it in each column."""

    def __init__(self, row: sqlite3.Row, places: Mapping[str, int]) -> None:
        self._row, self._places = row, places

    def __getitem__(self, name: str) -> Any:
        """Return what the catalog holds under a name; a row looks names up one by one, which takes long."""
        return self._row[self._places[name]]

    def __repr__(self) -> str:
        return f"ListedRun({self.id!r})"

    @property
    def id(self) -> str:
        """Name of the run."""
        return str(self["id"])

    def text(self, name: str) -> str:
        """Return what is shown in a column, numbers without their unit; empty where nothing is known."""
        return _shown_text(COLUMNS[name])(self)

    def texts(self, name: str) -> list[str]:
        """Return the texts of a column that can hold several, such as the tags."""
        held = self[name]
        return held.split(ITEM) if held else []

    def number(self, name: str) -> float | None:
        """Return a number in the unit of its column; none where nothing is known."""
        return shown_number(COLUMNS[name])(self.value(name))

    def spread(self, name: str) -> float | None:
        """Return the standard uncertainty of a number in the unit of its column; none where nothing is known."""
        return shown_number(COLUMNS[name], spread=True)(self.uncertainty(name))

    def value(self, name: str) -> float | None:
        """Return a number in SI; none if it is unknown."""
        found: float | None = self[name]
        return found

    def uncertainty(self, name: str) -> float | None:
        """Return the standard uncertainty of a number in SI; none where nothing is known."""
        found: float | None = self[f"{name}_uncertainty"]
        return found

    def date(self, name: str) -> str | None:
        """Return a date as run.toml has it, ISO 8601; none where nothing is known."""
        found: str | None = self[name]
        return found


def texts_of(runs: Iterable[ListedRun], column: ListedColumn) -> list[str]:
    """Return what is shown of several runs in one column, sooner than run by run."""
    shown = _shown_text(column)
    return [shown(run) for run in runs]


@cache
def _shown_text(column: ListedColumn) -> Callable[[ListedRun], str]:
    """Return what reads the text of a column out of a run."""
    name, joint = column.name, column.joint or " "
    if column.kind == "number":
        shown = f"{name}_shown"
        return lambda run: run[shown] or ""
    if column.kind == "date":
        return lambda run: (run[name] or "")[:16].replace("T", " ")
    return lambda run: (run[name] or "").replace(ITEM, joint)


@cache
def shown_number(column: ListedColumn, *, spread: bool = False) -> Callable[[float | None], float | None]:
    """Return what turns SI into the unit of a column, in as many digits as are sure."""
    from tribopipe.base.units import KINDS, from_si, interval_from_si

    convert, si = interval_from_si if spread else from_si, KINDS[column.measures].si
    return lambda value: None if value is None else float(f"{convert(value, si, column.unit):.15g}")


def usual_columns(runs: Sequence[ListedRun]) -> list[ListedColumn]:
    """Return the columns that are shown unless others are chosen, but for those of which nothing is known."""
    usual = [column for column in COLUMNS.values() if column.shown]
    return [column for column in usual if column.name == "id" or any(run.text(column.name) for run in runs)]


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
    key: Callable[[ListedRun], Any] = (
        (lambda run: run.value(column.name))
        if column.kind == "number"
        else (lambda run: natural_order(run.text(column.name).casefold()))
    )
    known = [run for run in runs if run.text(column.name)]
    unknown = [run for run in runs if not run.text(column.name)]
    return [*sorted(known, key=key, reverse=descending), *unknown]
