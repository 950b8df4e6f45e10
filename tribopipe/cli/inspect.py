"""Commands that look into a run: show, schema."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tribopipe.cli.help_panels import HelpPanels
from tribopipe.cli.options import DEFAULT_ARCHIVE, ArchiveFolder, AsJson, Verbose, archived_ids, load_archive
from tribopipe.cli.output import print_json, print_result, record_json
from tribopipe.cli.pages import show_run_page
from tribopipe.cli.profiles import (
    HeightUnit,
    Plot,
    PositionUnit,
    ProfileOptions,
    Radius,
    show_profile_file,
    show_run_profiles,
)

if TYPE_CHECKING:
    from tribopipe.archive.store import Archive
    from tribopipe.base.errors import ArchiveError

schema_app = typer.Typer(
    cls=HelpPanels, help="Write the schemas of documents and of archived files.", no_args_is_help=True
)


def show(
    run_id: Annotated[
        str,
        typer.Argument(
            help="ID of an archived run, or a file with a profile.", metavar="ID|FILE", autocompletion=archived_ids
        ),
    ],
    archive: ArchiveFolder = DEFAULT_ARCHIVE,
    path: Annotated[
        str | None, typer.Option(help="Part of the run's HDF5 file to show, such as /entry/wear.", metavar="PATH")
    ] = None,
    rows: Annotated[int, typer.Option(help="Number of first and last rows to show of a part.", min=1)] = 5,
    plot: Plot = False,
    radius: Radius = None,
    position_unit: PositionUnit = None,
    height_unit: HeightUnit = None,
    verbose: Verbose = 0,
    as_json: AsJson = False,
) -> None:
    """Show an archived run, or a measured profile."""
    if path is not None:
        _show_part(load_archive(archive), run_id, path, rows, as_json=as_json)
        return
    archived = (archive / f"{run_id}.h5").exists()
    if Path(run_id).is_file() and not archived:
        asked = ProfileOptions(plot, radius, position_unit, height_unit)
        show_profile_file(Path(run_id), asked, as_json=as_json)
        return
    if not archived and Path(run_id).suffix:
        raise _neither_file_nor_run(run_id, archive)
    _show_run(load_archive(archive), run_id, plot=plot, in_full=bool(verbose), as_json=as_json)


def _neither_file_nor_run(name: str, archive: Path) -> "ArchiveError":
    """Refuse what may have been meant as a file as well as a run."""
    from tribopipe.base.errors import ArchiveError, did_you_mean

    there, folder = load_archive(archive, must_exist=False).ids() if archive.is_dir() else [], Path(name).parent
    beside = [str(path) for path in folder.iterdir() if path.is_file()] if folder.is_dir() else []
    return ArchiveError(
        f"{name}: found no such file, and no such run in {archive}; expected a file with a profile, or the id of an "
        f"archived run; {did_you_mean(name, [*there, *beside])}"
    )


def _show_part(store: "Archive", run_id: str, path: str, rows: int, *, as_json: bool) -> None:
    from tribopipe.cli.hdf5_part import part_json, show_part

    if as_json:
        print_json(part_json(store, run_id, path))
    else:
        show_part(store, run_id, path, rows)


def _show_run(store: "Archive", run_id: str, *, plot: bool, in_full: bool, as_json: bool) -> None:
    from tribopipe.cli.run_overview import show_run_overview
    from tribopipe.cli.summary import run_summary
    from tribopipe.views.run_page import run_page

    if not as_json:
        if in_full:
            show_run_page(run_page(store, run_id))
            print_result(f"\n{store.path(run_id)}")
        else:
            show_run_overview(store, run_id)
        if plot:
            show_run_profiles(store, run_id)
        return
    run = store.outline(run_id)
    told = {
        "manifest": record_json(run.manifest),
        "findings": [record_json(finding) for finding in run.findings],
        "steps": list(run.steps),
        "marks": [record_json(mark) for mark in run.marks],
        "tags": list(store.tags(run_id)),
        "annotations": [record_json(one) for one in store.annotations(run_id)],
        "amended": [
            {"date": one.date, "changes": one.changes, "earlier_sha256": one.checksum}
            for one in store.earlier_manifests(run_id)
        ],
    }
    if plot:
        told["profiles"] = show_run_profiles(store, run_id)
    print_json(run_summary(store, run_id) | told)


@schema_app.command("export")
def export_schemas(
    folder: Annotated[Path, typer.Argument(help="Output folder for *.schema.json and *.nxdl.xml.")] = Path("schemas"),
) -> None:
    """Write JSON Schemas and NeXus definitions.

    Editors complete and check run.toml, recipes and plans with the schemas; nxvalidate checks archived files with the
    NeXus application definitions.
    """
    from tribopipe.archive.definitions.nxdl import definition_files, write_definitions
    from tribopipe.pipeline.output_paths import made_here, require_free
    from tribopipe.results.json_schema import schema_files, write_schemas

    require_free([folder / name for name in (*schema_files(), *definition_files())], own=made_here)
    for path in (*write_schemas(folder), *write_definitions(folder)):
        print_result(str(path))
