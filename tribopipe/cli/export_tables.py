"""Commands that write tables for spreadsheets, scripts and papers: export csv, export runs."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tribopipe.cli.listing import Columns, Sort, Where, tell_unreadable, up_to_date
from tribopipe.cli.options import DEFAULT_ARCHIVE, ArchivedIds, ArchiveFolder, AsJson, Replace, load_archive
from tribopipe.cli.output import attempt_each, exit_with, print_file, print_json, print_result, say

if TYPE_CHECKING:
    from tribopipe.archive.store import Archive
    from tribopipe.base.errors import TribopipeError


_Job = tuple[str, str, Path]
"""Id, kind of table, and output file."""


def export_csv(
    ids: ArchivedIds,
    what: Annotated[
        str | None,
        typer.Option(
            help="raw, cleaned, other-columns, corrected, friction, wear, fit, prediction or local-wear; separate "
            "several with commas; default: all tables of the run."
        ),
    ] = None,
    output: Annotated[Path, typer.Option("--output", "-o", help="Output folder.")] = Path("csv"),
    archive: ArchiveFolder = DEFAULT_ARCHIVE,
    force: Replace = False,
    as_json: AsJson = False,
) -> None:
    """Write columns of runs as CSV.

    The files are called <id>-<what>.csv. Numbers have full precision and the units of the archive.

    A run folder made of the raw columns and the run.toml of the run yields the same run.
    """
    from tribopipe.pipeline.output_paths import require_free

    store, wanted = load_archive(archive), None if what is None else _chosen(what)
    jobs: list[_Job] = []
    errors: list[TribopipeError] = []
    for run_id in dict.fromkeys(ids):
        found, lacking = _jobs(store, run_id, wanted, output)
        jobs += found
        errors += lacking
    require_free((path for _, _, path in jobs), force=force)
    written = _written(store, jobs, output, errors)
    if as_json:
        print_json({"files": [{"id": run_id, "what": kind, "file": str(path)} for run_id, kind, path in written]})
    exit_with(errors, some_done=bool(written))


def _written(store: "Archive", jobs: Sequence[_Job], folder: Path, errors: "list[TribopipeError]") -> list[_Job]:
    """Write files, and return those that were written; the reason for each failure is added to the errors."""
    folder.mkdir(parents=True, exist_ok=True)
    of_path = {path: (run_id, kind) for run_id, kind, path in jobs}
    done, failed = attempt_each(of_path, lambda path: _write(store, *of_path[path], path), "csv")
    errors += failed.values()
    for path in done:
        print_result(str(path))
    return [(*of_path[path], path) for path in done]


def _chosen(text: str) -> list[tuple[str, ...]]:
    """Return the kinds that each word selects: "fit" for the fits of all laws."""
    from tribopipe.base.errors import did_you_mean
    from tribopipe.views.csv_files import CSV_KINDS

    chosen = []
    for word in (part.strip() for part in text.split(",")):
        kinds = tuple(kind for kind in CSV_KINDS if kind == word or kind.startswith(f"{word}-"))
        if not kinds:
            raise typer.BadParameter(f"--what: found {word!r}; expected a table; {did_you_mean(word, CSV_KINDS)}")
        chosen.append(kinds)
    return chosen


def _jobs(
    store: "Archive", run_id: str, wanted: "Sequence[tuple[str, ...]] | None", folder: Path
) -> "tuple[list[_Job], list[TribopipeError]]":
    """Return the tables of a run to write, and an error for each requested kind that is missing."""
    from tribopipe.base.errors import TribopipeError
    from tribopipe.views.csv_files import csv_kinds, lacking

    try:
        there = csv_kinds(store, run_id)
    except TribopipeError as error:
        return [], [error]
    asked = [(kind,) for kind in there] if wanted is None else wanted
    found = dict.fromkeys(kind for kinds in asked for kind in kinds if kind in there)
    missing: list[TribopipeError] = [lacking(run_id, kinds[0], there) for kinds in asked if not set(kinds) & set(there)]
    return [(run_id, kind, folder / f"{run_id}-{kind}.csv") for kind in found], missing


def _write(store: "Archive", run_id: str, kind: str, path: Path) -> None:
    from tribopipe.base.files import replacing
    from tribopipe.views.csv_files import csv_parts

    parts: Iterator[bytes] = csv_parts(store, run_id, kind)
    with replacing(path) as part, part.open("wb") as file:
        file.writelines(parts)


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
            help="Write 0,5 instead of 0.5: in LaTeX, or in CSV with semicolons, as Excel expects in most European "
            "languages.",
        ),
    ] = False,
    archive: ArchiveFolder = DEFAULT_ARCHIVE,
    force: Replace = False,
) -> None:
    """Write the list of runs for spreadsheets, scripts and papers.

    Numbers are in the unit of the heading, with their standard uncertainties u. CSV files and workbooks have all
    columns, with u in separate
    columns; LaTeX and Markdown have the columns that ls shows.
    """
    from tribopipe.archive.catalog.listing import columns_named
    from tribopipe.base.files import write_file
    from tribopipe.pipeline.output_paths import require_free
    from tribopipe.views.run_tables import FORMS, WITH_COMMAS

    suffix = ".csv" if output is None else output.suffix.lower() or ".csv"
    if suffix not in FORMS:
        raise typer.BadParameter(f"--output: found the suffix {suffix}; expected one of {', '.join(FORMS)}")
    if decimal_comma and suffix not in WITH_COMMAS:
        raise typer.BadParameter(
            f"--decimal-comma: found a {suffix} file; expected {' or '.join(WITH_COMMAS)}; the decimal sign in a "
            "workbook depends on the program that opens it"
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
