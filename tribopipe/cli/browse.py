"""The command that shows an archive in the web browser: browse."""

import signal
from typing import Annotated

import typer

from tribopipe.cli.listing import up_to_date
from tribopipe.cli.options import DEFAULT_ARCHIVE, ArchiveFolder, require_archive
from tribopipe.cli.output import say

Port = Annotated[int, typer.Option("--port", help="Port; any free one by default.", min=0, max=65_535)]
NoBrowser = Annotated[bool, typer.Option("--no-browser", help="Only print the address.")]


def browse(archive: ArchiveFolder = DEFAULT_ARCHIVE, port: Port = 0, no_browser: NoBrowser = False) -> None:
    """Show an archive in the web browser, until Ctrl-C.

    Only this machine can reach the pages, with the printed address, and they change nothing.
    """
    from tribopipe.base.errors import ArchiveError
    from tribopipe.browse.bundle import NOT_BUILT, is_built
    from tribopipe.browse.server import serve

    require_archive(archive)
    if not is_built():
        raise ArchiveError(NOT_BUILT)
    up_to_date(archive)
    signal.signal(signal.SIGINT, signal.default_int_handler)  # the server ends by itself, with nothing to resume
    serve(archive, port, lambda address: say(f"{address} shows {archive}; Ctrl-C ends it"), open_browser=not no_browser)


COMMANDS = {"browse": browse}
