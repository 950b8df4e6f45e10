"""The command that writes the list of runs as CSV: export runs."""

from pathlib import Path
from typing import Annotated

import typer

from tribopipe.cli.listing import Columns, Sort, Where, tell_unreadable, up_to_date
from tribopipe.cli.options import DEFAULT_ARCHIVE, ArchiveFolder
from tribopipe.cli.output import say


def export_runs(
    where: Where = "",
    sort: Sort = "id",
    columns: Columns = None,
    output: Annotated[Path | None, typer.Option("--output", "-o", help="File to write; on stdout unless said.")] = None,
    archive: ArchiveFolder = DEFAULT_ARCHIVE,
    force: Annotated[bool, typer.Option("--force", help="Replace a file that is there already.")] = False,
) -> None:
    """Write the list of runs as CSV: every column, numbers in the unit of the heading, each with its uncertainty."""
    from tribopipe.archive.catalog.columns import COLUMNS, columns_named
    from tribopipe.base.files import write_file
    from tribopipe.pipeline.output_paths import require_free
    from tribopipe.views.runs_csv import runs_csv

    require_free([] if output is None else [output], force=force)
    chosen = list(COLUMNS.values()) if columns is None else columns_named(columns)
    catalogue = up_to_date(archive)
    runs = catalogue.runs(where, sort)
    written = runs_csv(runs, chosen)
    if output is None:
        typer.echo(written, nl=False)
    else:
        write_file(output, written)
        say(f"{len(runs)} run{'' if len(runs) == 1 else 's'} written to {output}")
    tell_unreadable(catalogue, some_done=bool(runs))
