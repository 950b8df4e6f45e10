"""The command that lists the runs of an archive: ls."""

from typing import TYPE_CHECKING, Annotated, Any

import typer

from tribopipe.cli.options import DEFAULT_ARCHIVE, ArchiveFolder, AsJson, require_archive
from tribopipe.cli.output import exit_with, line_width, print_json, print_result, progress, table
from tribopipe.cli.run_columns import listed_cells, show_runs

if TYPE_CHECKING:
    from pathlib import Path

    from tribopipe.archive.catalog.catalog import Catalogue
    from tribopipe.archive.catalog.columns import ListedColumn
    from tribopipe.archive.catalog.listed import ListedRun

_ROWS = 20
"""As many runs are listed on a terminal."""
Where = Annotated[
    str,
    typer.Option(
        "--where",
        help='Filter, such as "material=Si3N4 load>300mN tag=run-in k_d<1e-8 started>=2006-03 title~wear"; '
        "all conditions must hold; none means no value.",
    ),
]
Sort = Annotated[
    str, typer.Option("--sort", help="Columns to sort by, such as material,-k_d; the largest first after a minus.")
]
Columns = Annotated[
    str | None, typer.Option("--columns", help="Columns to show, such as id,load,k_d; help names them all.")
]


def ls(
    where: Where = "",
    sort: Sort = "id",
    columns: Columns = None,
    archive: ArchiveFolder = DEFAULT_ARCHIVE,
    everything: Annotated[
        bool, typer.Option("--all", help="Show all rows on a terminal; files and pipes always get all.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """List the runs of an archive, or those that --where selects.

    On a terminal columns are left out until the others fit, and rows after the twentieth.
    """
    from tribopipe.archive.catalog.columns import columns_named

    if columns is not None and columns.strip() == "help":
        _show_columns(as_json=as_json)
        return
    chosen = None if columns is None else columns_named(columns)
    catalogue = up_to_date(archive)
    runs = catalogue.runs(where, sort)
    if as_json:
        print_json({"runs": [_document(run) for run in runs]})
    elif runs or not catalogue.unreadable:
        asked = f" where {where}" if where else ""
        title = f"{len(runs)} run{'' if len(runs) == 1 else 's'} in {archive}{asked}"
        shown = runs if everything or line_width() is None else runs[:_ROWS]
        if chosen is None:
            show_runs(title, shown)
        else:
            cells = [listed_cells(shown, column) for column in chosen]
            table(title, [one.heading for one in cells], list(zip(*(one.cells for one in cells), strict=True)))
        if len(shown) < len(runs):
            print_result(f"and {len(runs) - len(shown)} more: add --all, or choose with --where")
    tell_unreadable(catalogue, some_done=bool(runs))


def _document(run: "ListedRun") -> dict[str, Any]:
    """Return all that is known of a run as JSON types, numbers in SI."""
    from tribopipe.archive.catalog.columns import COLUMNS, step_called

    known = {name: _json(run, column) for name, column in COLUMNS.items()}
    return known | {"normal_load": known["load"], "steps": [step_called(words) for words in run.texts("steps")]}


def _json(run: "ListedRun", column: "ListedColumn") -> Any:
    if column.kind == "number":
        return _quantity(run, column)
    if column.kind == "date":
        return run.date(column.name)
    return (run.text(column.name) or None) if column.joint is None else run.texts(column.name)


def _quantity(run: "ListedRun", column: "ListedColumn") -> dict[str, Any] | None:
    from tribopipe.base.units import KINDS

    value = run.value(column.name)
    if value is None:
        return None
    spread = run.uncertainty(column.name)
    return {"value": value, "unit": KINDS[column.measures].si, "standard_uncertainty": spread}


def up_to_date(archive: "Path") -> "Catalogue":
    """Return the catalog of an archive as it is now. Raises ``ArchiveError`` where there is no archive."""
    from tribopipe.archive.catalog.catalog import Catalogue

    require_archive(archive)
    catalogue = Catalogue(archive)
    waiting = len(catalogue.waiting())
    if waiting:
        with progress("Reading", waiting) as advance:
            catalogue.refresh(advance)
    return catalogue


def tell_unreadable(catalogue: "Catalogue", *, some_done: bool) -> None:
    """Report each file of an archive that cannot be read, and exit accordingly."""
    from tribopipe.base.errors import ArchiveError

    exit_with([ArchiveError(sentence) for _, sentence in catalogue.unreadable], some_done=some_done)


def _show_columns(*, as_json: bool) -> None:
    from tribopipe.archive.catalog.columns import COLUMNS

    told = [
        {"name": column.name, "unit": column.unit, "kind": column.kind, "meaning": column.help}
        for column in COLUMNS.values()
    ]
    if as_json:
        print_json({"columns": told})
        return
    rows = [[column["name"], column["unit"] or "–", column["meaning"]] for column in told]
    table("Columns for --columns, --sort and --where", ["column", "unit", "meaning"], rows)
    print_result(
        "Those shown unless you choose: " + ", ".join(name for name, column in COLUMNS.items() if column.shown)
    )
