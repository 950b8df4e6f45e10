"""The command that processes new files of instruments in a folder: watch."""

import os
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tribopipe.cli.options import DEFAULT_ARCHIVE, ArchiveFolder, Figures, Jobs, RecipeFile, Template, crew, load_recipe
from tribopipe.cli.output import FAILED, PARTLY_FAILED, keep_stdout_for_json, print_json, print_result, say

if TYPE_CHECKING:
    from tribopipe.extras.watch.journal import Event, Kind

_STDERR = 2


def watch(
    folder: Annotated[Path, typer.Argument(help="Folder to which the instruments export; its files are not modified.")],
    template: Template = None,
    runs: Annotated[
        Path | None,
        typer.Option("--runs", help="Folder in which to create run folders; default: runs, next to the archive."),
    ] = None,
    archive: ArchiveFolder = DEFAULT_ARCHIVE,
    recipe: RecipeFile = None,
    settle: Annotated[
        float,
        typer.Option("--settle", help="Idle time in seconds after which an export is considered complete.", min=0.0),
    ] = 10.0,
    together: Annotated[
        bool,
        typer.Option("--together", help="Treat the files in each subfolder as one test; default: each file is a test."),
    ] = False,
    poll: Annotated[bool, typer.Option("--poll", help="Poll the folder, as required on network shares.")] = False,
    once: Annotated[bool, typer.Option("--once", help="Process the existing files and exit.")] = False,
    jobs: Jobs = None,
    figures: Figures = True,
    as_json: Annotated[
        bool,
        typer.Option("--json", callback=keep_stdout_for_json, help="Print one JSON line per event."),
    ] = False,
) -> None:
    """Process new exports in a folder as they arrive. Press Ctrl-C to stop.

    An export is copied when it has not changed for a while; run.toml is drafted from the template. Progress is saved
    with the runs, so that the next `watch` resumes there.
    """
    from tribopipe.base.process_lifecycle import undone_by
    from tribopipe.extras.watch.journal import alone, counted
    from tribopipe.extras.watch.lab import Lab
    from tribopipe.extras.watch.watcher import look_once, watched
    from tribopipe.pipeline.output_paths import require_folder

    lab = Lab(
        folder=_real(folder),
        runs=_real(archive.parent / "runs" if runs is None else runs),
        archive=_real(archive),
        recipe=load_recipe(recipe),
        template=template,
        together=together,
        settle=settle,
        figures=figures,
        crew=crew(jobs, None),
    )
    lab.refuse_what_cannot_be()
    require_folder(lab.runs)
    kinds: list[Kind] = []
    with alone(lab.runs), undone_by(lambda: os.write(_STDERR, f"{counted(kinds)}{os.linesep}".encode())):
        if not once:
            say(f"watching {folder}: run folders in {lab.runs}, archive {archive}; press Ctrl-C to stop")
        for event in look_once(lab) if once else watched(lab, poll=poll):
            kinds.append(event.kind)
            _tell(event, as_json=as_json)
    if kinds:
        say(counted(kinds))
    if {"failed", "left"} & {*kinds}:
        raise typer.Exit(PARTLY_FAILED if "done" in kinds else FAILED)


def _real(path: Path) -> Path:
    return Path(os.path.realpath(path))


def _tell(event: "Event", *, as_json: bool) -> None:
    """Report on stderr, and as JSON on stdout if requested."""
    print_result(event.text)
    for line in event.details:
        print_result(f"  {line}")
    if as_json:
        print_json(event.as_json(), indent=None)
