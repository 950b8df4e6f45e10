"""The command that writes the list of runs for other programs: export runs."""

from pathlib import Path
from typing import Annotated

import typer

from tribopipe.cli.listing import Columns, Sort, Where, tell_unreadable, up_to_date
from tribopipe.cli.options import DEFAULT_ARCHIVE, ArchiveFolder
from tribopipe.cli.output import print_file, say


def export_runs(
    where: Where = "",
    sort: Sort = "id",
    columns: Columns = None,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            "-o",
            help="File to write: .csv, .xlsx (Excel, Origin), .tex (LaTeX with booktabs and siunitx) or .md "
            "(Markdown); by default CSV on stdout.",
        ),
    ] = None,
    decimal_comma: Annotated[
        bool,
        typer.Option(
            "--decimal-comma",
            help="Write 0,5 for 0.5: CSV with semicolons, as Excel opens it in German and most European languages, or "
            "LaTeX.",
        ),
    ] = False,
    archive: ArchiveFolder = DEFAULT_ARCHIVE,
    force: Annotated[bool, typer.Option("--force", help="Replace an existing file.")] = False,
) -> None:
    """Write the list of runs for spreadsheets, scripts and papers.

    Numbers are in the unit of the heading, with their u. CSV files and workbooks have all columns, with u in separate
    columns; LaTeX and Markdown have the columns that ls shows.
    """
    from tribopipe.archive.catalog.columns import columns_named
    from tribopipe.base.files import write_file
    from tribopipe.pipeline.output_paths import require_free
    from tribopipe.views.run_tables import FORMS, WITH_COMMAS

    suffix = ".csv" if output is None else output.suffix.lower() or ".csv"
    if suffix not in FORMS:
        raise typer.BadParameter(f"--output: found a name that ends in {suffix}; expected one in {', '.join(FORMS)}")
    if decimal_comma and suffix not in WITH_COMMAS:
        raise typer.BadParameter(
            f"--decimal-comma: found it with a {suffix} file; expected {' or '.join(WITH_COMMAS)}; a workbook has "
            "the decimal sign of the program that opens it"
        )
    require_free([] if output is None else [output], force=force)
    chosen = None if columns is None else columns_named(columns)
    catalogue = up_to_date(archive)
    runs = catalogue.runs(where, sort)
    written = FORMS[suffix](runs, chosen, **({"decimal_comma": True} if decimal_comma else {}))
    if output is None:
        print_file(written)
    else:
        write_file(output, written)
        say(f"{len(runs)} run{'' if len(runs) == 1 else 's'} written to {output}")
    tell_unreadable(catalogue, some_done=bool(runs))
