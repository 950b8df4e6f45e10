"""Commands that open the web browser: browse, demo."""

import shutil
import signal
from importlib import import_module
from pathlib import Path
from typing import Annotated

import typer

from tribopipe.cli.listing import up_to_date
from tribopipe.cli.options import DEFAULT_ARCHIVE, ReadableArchive, crew, require_archive
from tribopipe.cli.output import finish, progress, say

Port = Annotated[int, typer.Option("--port", help="Port number; default: any free port.", min=0, max=65_535)]
NoBrowser = Annotated[bool, typer.Option("--no-browser", help="Print the address without opening a browser.")]
SERVER_PACKAGES = ("anyio", "fastapi", "h5grove", "starlette", "uvicorn")
"""Packages of the extra web."""


def browse(archive: ReadableArchive = DEFAULT_ARCHIVE, port: Port = 0, no_browser: NoBrowser = False) -> None:
    """Show an archive in the web browser. Press Ctrl-C to stop.

    The pages are accessible only from this computer, at the printed address, and are read-only.
    """
    require_archive(archive)
    require_server()
    from tribopipe.browse.server import serve

    up_to_date(archive)
    signal.signal(signal.SIGINT, signal.default_int_handler)  # the server ends by itself, with nothing to resume
    serve(
        archive,
        port,
        lambda address: say(f"serving {archive} at {address} (press Ctrl-C to stop)"),
        open_browser=not no_browser,
    )


def require_server() -> None:
    """Raise ``ArchiveError`` if the packages of the server, or the pages that it serves, are not installed."""
    from tribopipe.base.errors import ArchiveError

    for name in SERVER_PACKAGES:
        try:
            import_module(name)
        except ImportError:
            raise ArchiveError(
                f'found no package {name}; expected the web server packages; run `pip install "tribopipe[web]"`'
            ) from None
    from tribopipe.browse.app import NOT_BUILT, is_built

    if not is_built():
        raise ArchiveError(NOT_BUILT)


_PLAN, _RUNS, _ARCHIVE = "plan.toml", "runs", "archive"


def demo(
    folder: Annotated[Path, typer.Option("--folder", help="Output folder.")] = Path("tribopipe-demo"),
    port: Port = 0,
    no_browser: NoBrowser = False,
) -> None:
    """Simulate, process and browse sample runs.

    Everything is written to one folder, which can be deleted afterwards. Existing results are opened.
    """
    require_server()
    _begin_demo(folder)
    _simulate_samples(folder)
    _process_samples(folder / _RUNS, folder / _ARCHIVE)
    say(
        f"Run folders are in {folder / _RUNS}, their archive in {folder / _ARCHIVE}; delete {folder} when you are done."
    )
    browse(folder / _ARCHIVE, port, no_browser)


def _begin_demo(folder: Path) -> None:
    """Create the folder, which is recognized by its plan. Raises ``OutputError`` if it contains other files."""
    from tribopipe.base.errors import OutputError
    from tribopipe.pipeline.output_paths import require_folder
    from tribopipe.shipped import shipped

    require_folder(folder)
    if folder.exists() and not (folder / _PLAN).is_file() and any(folder.iterdir()):
        raise OutputError(
            f"{folder}: found a folder with other files; expected a new folder or the folder of an earlier demo; "
            "specify another folder with --folder"
        )
    folder.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(shipped(f"sample_runs/{_PLAN}"), folder / _PLAN)


def _simulate_samples(folder: Path) -> None:
    """Simulate the sample runs, all or none; existing ones are kept, even if they have been edited."""
    from tribopipe.documents.plan import Plan
    from tribopipe.documents.record import load_toml
    from tribopipe.extras.simulate import simulate_plan
    from tribopipe.shipped import shipped

    runs, begun = folder / _RUNS, folder / f".{_RUNS}.part"
    if runs.exists():
        return
    say(f"Simulating sample runs in {runs}")
    simulate_plan(load_toml(folder / _PLAN, Plan), begun)
    for study in shipped("sample_runs").glob("*.study.toml"):
        shutil.copyfile(study, begun / study.name)
    begun.rename(runs)


def _process_samples(runs: Path, archive: Path) -> None:
    """Process the runs that have not been processed yet. Exits if any of them fails."""
    from tribopipe.archive.store import Archive
    from tribopipe.base.executor import at_work
    from tribopipe.documents.recipe import Recipe
    from tribopipe.pipeline import stages
    from tribopipe.pipeline.studies import find_studies, load_studies, process_studies

    say("Processing the runs: drift, friction, wear coefficients with uncertainties, predictions, studies")
    store, how, folders = Archive(archive), Recipe(), stages.find_runs(runs)
    studies = load_studies(find_studies(runs))
    studied = {run_id for study in studies for run_id in (*study.fit, *study.predict)}
    outcomes = []
    with at_work(crew(0, None)) as who, progress("process", len(folders)) as advance:
        for outcome in stages.process(folders, store, how, studied=studied, crew=who):
            advance(outcome.run_id, by=int(outcome.stage == "ingest"))
            outcomes.append(outcome)
        outcomes += process_studies(store, studies, how, crew=who)
    finish(outcomes)
