"""Columns of a list of runs: numbers in one unit each, and those that fit on a terminal."""

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

from tribopipe.base.number_columns import NOTHING, Number, number_column
from tribopipe.cli.output import fits, line_width, table

if TYPE_CHECKING:
    from tribopipe.archive.catalog.columns import ListedColumn
    from tribopipe.archive.catalog.listed import ListedRun

_MILLI = 1e3
_FIRST = ("id", "mark", "load", "k_d", "law", "friction", "material", "medium", "started", "stage", "tags")
"""Columns that a narrow terminal shows, the most important first; others come after them."""


class Cells(NamedTuple):
    """One column as it is shown."""

    name: str
    heading: str
    cells: Sequence[str]


def show_runs(title: str, runs: "Sequence[ListedRun]") -> None:
    """Show the usual columns of runs, of those of which something is known as many as fit on the terminal."""
    coefficients, laws = _recommended(runs)
    known = {law for law in laws if law}
    columns = {cells.name: cells for cells in _usual(runs)}
    if known:
        columns["k_d"] = coefficients
        columns["law"] = Cells("law", "law", [law or NOTHING for law in laws])
    if len(known) == 1:
        del columns["law"]
        title = f"{title}; k_D by {known.pop()}'s law"
    order = [name for name in (*_FIRST, *columns) if name in columns]
    shown = chosen_columns({name: columns[name] for name in dict.fromkeys(order)}, list(columns))
    table(title, [one.heading for one in shown], rows_of(shown))


def rows_of(columns: "Sequence[Cells]") -> list[Sequence[str]]:
    """Return the rows of a table by its columns."""
    return list(zip(*(one.cells for one in columns), strict=True))


def chosen_columns(ranked: "Mapping[str, Cells]", order: Sequence[str]) -> list[Cells]:
    """Return as many columns as fit on the terminal, the most important first among those tried, in their order.

    Parameters
    ----------
    ranked
        Columns by name, the most important first; the first is shown in any case.
    order
        Names in the order in which columns are shown.
    """
    width = line_width()
    kept: list[str] = []
    for name in ranked:
        among = [ranked[one] for one in order if one in (*kept, name)]
        if not kept or width is None or fits([one.heading for one in among], rows_of(among), width):
            kept.append(name)
    return [ranked[name] for name in order if name in kept]


def listed_cells(runs: "Sequence[ListedRun]", column: "ListedColumn") -> Cells:
    """Return what runs have in a column: numbers with one unit, and one power of ten where they need one."""
    from tribopipe.archive.catalog.columns import PER_SI

    if column.kind != "number" or column.unit not in PER_SI:
        return Cells(column.name, column.heading, [run.text(column.name) or NOTHING for run in runs])
    unit, numbers = _in_unit(column.unit, [_number(run, column) for run in runs])
    return _cells(column.name, column.label, unit, numbers)


def _cells(name: str, label: str, unit: str, numbers: "Sequence[Number | None]") -> Cells:
    shown = number_column(numbers)
    heading = shown.unit(unit)
    return Cells(name, f"{label}, {heading}" if heading else label, shown.cells)


def _number(run: "ListedRun", column: "ListedColumn") -> "Number | None":
    from tribopipe.archive.catalog.columns import PER_SI

    value, u = run.value(column.name), run.uncertainty(column.name)
    factor = PER_SI[column.unit]
    return None if value is None else (value * factor, None if u is None else u * factor)


def _in_unit(unit: str, numbers: "list[Number | None]") -> "tuple[str, list[Number | None]]":
    """Return loads in N if none is below 1 N, and other columns unchanged."""
    known = [number for number in numbers if number is not None]
    if unit != "mN" or not known or min(value for value, _ in known) < _MILLI:
        return unit, numbers
    return "N", [
        None if one is None else (one[0] / _MILLI, None if one[1] is None else one[1] / _MILLI) for one in numbers
    ]


def _usual(runs: "Sequence[ListedRun]") -> "Iterator[Cells]":
    """Give the columns that are shown unless others are chosen, but for those of which nothing is known."""
    from tribopipe.archive.catalog.listed import usual_columns

    yield from (listed_cells(runs, column) for column in usual_columns(runs))


def _recommended(runs: "Sequence[ListedRun]") -> "tuple[Cells, list[str]]":
    """Return k_D of each run by the first law that it was fitted with, Archard's before others, and the law's name."""
    from tribopipe.archive.catalog.columns import COLUMNS

    fitted = [one for name, one in COLUMNS.items() if name.startswith("k_d") and not name.endswith("_disc")]
    found = [next((one for one in fitted if run.value(one.name) is not None), None) for run in runs]
    numbers = [None if one is None else _number(run, one) for run, one in zip(runs, found, strict=True)]
    return _cells("k_d", "k_D", fitted[0].unit, numbers), [_law(one) for one in found]


def _law(column: "ListedColumn | None") -> str:
    if column is None:
        return ""
    return "Archard" if column.name == "k_d" else column.name.removeprefix("k_d_").replace("_", " ").capitalize()
