"""The command that shows an archive in the web browser: browse."""

from pathlib import Path
from typing import Annotated

import typer

from tribopipe.cli.options import DEFAULT_ARCHIVE, ArchiveFolder, load_archive
from tribopipe.cli.output import progress, say


def browse(
    archive: ArchiveFolder = DEFAULT_ARCHIVE,
    port: Annotated[int, typer.Option("--port", help="Port; any free one by default.", min=0, max=65_535)] = 0,
    no_browser: Annotated[bool, typer.Option("--no-browser", help="Only print the address.")] = False,
) -> None:
    """Show an archive in the web browser, until Ctrl-C.

    Only this machine can reach the pages, and they change nothing.
    """
    from tribopipe.browse.bundle import NOT_BUILT, is_built
    from tribopipe.browse.server import serve
    from tribopipe.errors import ArchiveError

    folder = load_archive(archive).folder
    if not is_built():
        raise ArchiveError(NOT_BUILT)
    _list(folder)
    serve(folder, port, lambda address: say(f"{address} shows {folder}; Ctrl-C ends it"), show=not no_browser)


def _list(folder: Path) -> None:
    """Bring the catalogue up to date."""
    from tribopipe.archive.catalogue.catalogue import Catalogue

    catalogue = Catalogue(folder)
    with progress("reading", len(catalogue.waiting())) as advance:
        catalogue.refresh(advance)


COMMANDS = {"browse": browse}
