"""The command that shows an archive in the web browser: browse."""

import signal
from importlib import import_module
from typing import Annotated

import typer

from tribopipe.cli.listing import up_to_date
from tribopipe.cli.options import DEFAULT_ARCHIVE, ArchiveFolder, require_archive
from tribopipe.cli.output import say

Port = Annotated[int, typer.Option("--port", help="Port; default: any free port.", min=0, max=65_535)]
NoBrowser = Annotated[bool, typer.Option("--no-browser", help="Only print the address.")]
SERVER_PACKAGES = ("anyio", "fastapi", "h5grove", "starlette", "uvicorn")
"""Packages of the extra web."""


def browse(archive: ArchiveFolder = DEFAULT_ARCHIVE, port: Port = 0, no_browser: NoBrowser = False) -> None:
    """Show an archive in the web browser. Press Ctrl-C to stop.

    The pages are accessible only from this computer, at the printed address, and are read-only.
    """
    require_archive(archive)
    require_server()
    from tribopipe.browse.server import serve

    up_to_date(archive)
    signal.signal(signal.SIGINT, signal.default_int_handler)  # the server ends by itself, with nothing to resume
    serve(archive, port, lambda address: say(f"{address} shows {archive}; Ctrl-C ends it"), open_browser=not no_browser)


def require_server() -> None:
    """Raise ``ArchiveError`` where the packages of the server, or the pages that it serves, are not installed."""
    from tribopipe.base.errors import ArchiveError

    for name in SERVER_PACKAGES:
        try:
            import_module(name)
        except ImportError:
            raise ArchiveError(
                f"found no package {name}, which the server of the web pages needs; expected it to be installed; run "
                '`pip install "tribopipe[web]"`'
            ) from None
    from tribopipe.browse.bundle import NOT_BUILT, is_built

    if not is_built():
        raise ArchiveError(NOT_BUILT)
