"""The list of the runs of an archive: the command ls and its columns, as many as fit on a terminal."""

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer

from tribopipe.base.column_formatting import NOTHING, Number, in_power, number_column
from tribopipe.base.errors import counted
from tribopipe.cli.options import DEFAULT_ARCHIVE, AsJson, ReadableArchive, require_archive
from tribopipe.cli.output import exit_with, fits, line_width, print_json, print_result, progress, table

if TYPE_CHECKING:
    from pathlib import Path

    from tribopipe.archive.catalog.catalog import Catalogue
    from tribopipe.archive.catalog.listing import ListedColumn, ListedRun


_MILLI = 1e3
_FIRST = ("id", "mark", "load", "k_d", "law", "friction", "material", "medium", "started", "stage", "tags")
"""Columns shown on a narrow terminal, the most important first; others come after them."""


class Cells(NamedTuple):
    """One displayed column."""

    name: str
    heading: str
    cells: Sequence[str]


def show_runs(title: str, runs: "Sequence[ListedRun]") -> None:
    """Show the default columns that are not empty, as many as fit on the terminal."""
    coefficients, laws = _recommended(runs)
    known = {law for law in laws if law}
    columns = {cells.name: cells for cells in _usual(runs)}
    if known:
        columns["k_d"] = coefficients
        columns["law"] = Cells("law", "law", [law or NOTHING for law in laws])
    if len(known) == 1:
        del columns["law"]
        title = f"{title}; k_D from {known.pop()}'s law"
    order = [name for name in (*_FIRST, *columns) if name in columns]
    shown = chosen_columns({name: columns[name] for name in dict.fromkeys(order)}, list(columns))
    show_table(title, shown)


def show_table(title: str, columns: "Sequence[Cells]") -> None:
    """Show columns under a title that explains ±, if it occurs."""
    uncertain = any("±" in cell for column in columns for cell in column.cells)
    explained = "; ± is one standard uncertainty" if uncertain else ""
    table(f"{title}{explained}", [one.heading for one in columns], rows_of(columns))


def rows_of(columns: "Sequence[Cells]") -> list[Sequence[str]]:
    """Return the rows of a table by its columns."""
    return list(zip(*(one.cells for one in columns), strict=True))


def chosen_columns(ranked: "Mapping[str, Cells]", order: Sequence[str]) -> list[Cells]:
    """Return as many columns as fit on the terminal, chosen by importance and shown in their own order.

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
    """Return the cells of a column: numbers with one unit, and a common power of ten if they need one."""
    from tribopipe.archive.catalog.listing import PER_SI

    if column.kind != "number" or column.unit not in PER_SI:
        return Cells(column.name, column.heading, [run.text(column.name) or NOTHING for run in runs])
    unit, numbers = _in_unit(column.unit, [_number(run, column) for run in runs])
    return _cells(column.name, column.label, unit, numbers)


def _cells(name: str, label: str, unit: str, numbers: "Sequence[Number | None]") -> Cells:
    # Nobody writes a friction coefficient in thousandths.
    shown = in_power(numbers, 0) if not unit and _are_coefficients(numbers) else number_column(numbers)
    heading = shown.unit(unit)
    return Cells(name, f"{label}, {heading}" if heading else label, shown.cells)


def _are_coefficients(numbers: "Sequence[Number | None]") -> bool:
    return all(number is None or 1 / _MILLI <= abs(number[0]) < _MILLI for number in numbers)


def _number(run: "ListedRun", column: "ListedColumn") -> "Number | None":
    from tribopipe.archive.catalog.listing import PER_SI

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
    """Yield the columns that are shown by default, except those that are empty."""
    from tribopipe.archive.catalog.listing import usual_columns

    yield from (listed_cells(runs, column) for column in usual_columns(runs))


def _recommended(runs: "Sequence[ListedRun]") -> "tuple[Cells, list[str]]":
    """Return k_D of each run from the first law fitted to it, Archard's before others, and the names of these laws."""
    from tribopipe.archive.catalog.listing import COLUMNS

    fitted = [one for name, one in COLUMNS.items() if name.startswith("k_d") and not name.endswith("_disc")]
    found = [next((one for one in fitted if run.value(one.name) is not None), None) for run in runs]
    numbers = [None if one is None else _number(run, one) for run, one in zip(runs, found, strict=True)]
    return _cells("k_d", "k_D", fitted[0].unit, numbers), [_law(one) for one in found]


def _law(column: "ListedColumn | None") -> str:
    if column is None:
        return ""
    return "Archard" if column.name == "k_d" else column.name.removeprefix("k_d_").replace("_", " ").capitalize()


_ROWS = 20
"""Largest number of runs listed on a terminal."""
Where = Annotated[
    str,
    typer.Option(
        "--where",
        help=(
            'Filter, for example "material=Si3N4 load>300mN tag=run-in k_d<1e-8 started>=2006-03 title~wear"; all '
            "conditions must be met; the value none matches missing values."
        ),
    ),
]
Sort = Annotated[
    str,
    typer.Option(
        "--sort", help="Columns to sort by, for example material,-k_d; a minus sign sorts in descending order."
    ),
]
Columns = Annotated[
    str | None, typer.Option("--columns", help="Columns to show, for example id,load,k_d; `--columns help` lists all.")
]


def ls(
    where: Where = "",
    sort: Sort = "id",
    columns: Columns = None,
    archive: ReadableArchive = DEFAULT_ARCHIVE,
    everything: Annotated[
        bool, typer.Option("--all", help="Show all rows on a terminal; output to files and pipes is always complete.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """List the runs of an archive, or those that --where selects.

    On a terminal, only the columns that fit and the first 20 rows are shown.
    """
    from tribopipe.archive.catalog.listing import columns_named
    from tribopipe.archive.catalog.query import Asked

    if columns is not None and columns.strip() == "help":
        _show_columns(as_json=as_json)
        return
    chosen = None if columns is None else columns_named(columns)
    catalogue = up_to_date(archive)
    complete = as_json or everything or line_width() is None
    total, runs = catalogue.listed(Asked(where, sort), most=None if complete else _ROWS)
    if as_json:
        print_json({"runs": [_document(run) for run in runs]})
    elif runs or not catalogue.unreadable:
        asked = f" where {where}" if where else ""
        title = f"{counted(total, 'run')} in {archive}{asked}"
        if chosen is None:
            show_runs(title, runs)
        else:
            show_table(title, [listed_cells(runs, column) for column in chosen])
        if len(runs) < total:
            print_result(f"and {total - len(runs)} more: add --all, or filter with --where")
    tell_unreadable(catalogue, some_done=bool(runs))


def _document(run: "ListedRun") -> dict[str, Any]:
    """Return all data of a run in the catalog as JSON types, numbers in SI units."""
    from tribopipe.archive.catalog.listing import COLUMNS

    known = {name: _json(run, column) for name, column in COLUMNS.items()}
    return known | {"normal_load": known["load"], "steps": run.texts("steps")}


def _json(run: "ListedRun", column: "ListedColumn") -> Any:
    if column.kind == "number":
        return _number_json(run, column)
    if column.kind == "date":
        return run.date(column.name)
    return (run.text(column.name) or None) if column.joint is None else run.texts(column.name)


def _number_json(run: "ListedRun", column: "ListedColumn") -> dict[str, Any] | None:
    from tribopipe.base.units import KINDS

    value = run.value(column.name)
    if value is None:
        return None
    spread = run.uncertainty(column.name)
    return {"value": value, "unit": KINDS[column.measures].si, "standard_uncertainty": spread}


def up_to_date(archive: "Path") -> "Catalogue":
    """Return the current catalog of an archive. Raises ``ArchiveError`` if there is no archive."""
    from tribopipe.archive.catalog.catalog import Catalogue

    require_archive(archive)
    catalogue = Catalogue(archive)
    changes = catalogue.changes()
    if changes:
        with progress("Reading", len(changes)) as advance:
            catalogue.refresh(advance, changes)
    return catalogue


def tell_unreadable(catalogue: "Catalogue", *, some_done: bool) -> None:
    """Report each file of an archive that cannot be read, and exit accordingly."""
    from tribopipe.base.errors import ArchiveError

    exit_with([ArchiveError(sentence) for _, sentence in catalogue.unreadable], some_done=some_done)


def _show_columns(*, as_json: bool) -> None:
    from tribopipe.archive.catalog.listing import COLUMNS

    told = [
        {"name": column.name, "unit": column.unit, "kind": column.kind, "meaning": column.help}
        for column in COLUMNS.values()
    ]
    if as_json:
        print_json({"columns": told})
        return
    rows = [[column["name"], column["unit"] or "–", column["meaning"]] for column in told]
    table("Columns for --columns, --sort and --where", ["column", "unit", "meaning"], rows)
    print_result("Shown by default: " + ", ".join(name for name, column in COLUMNS.items() if column.shown))
