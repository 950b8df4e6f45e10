"""The command that looks an archive over: verify."""

from pathlib import Path
from typing import Annotated

import typer

from tribopipe.cli.options import DEFAULT_ARCHIVE, ArchiveFolder, AsJson, archived_ids, load_archive
from tribopipe.cli.output import FAILED, print_json, progress, say, seen


def verify(
    folder: Annotated[
        Path | None, typer.Argument(help="Archive folder; by default that of --archive.", metavar="ARCHIVE")
    ] = None,
    run_ids: Annotated[
        list[str] | None,
        typer.Option("--run", help="Id of a run to look at alone; may be said again.", autocompletion=archived_ids),
    ] = None,
    recompute: Annotated[
        bool, typer.Option("--recompute", help="Compute every step again from what was ingested, and compare.")
    ] = False,
    archive: ArchiveFolder = DEFAULT_ARCHIVE,
    as_json: AsJson = False,
) -> None:
    """Look an archive over: every byte, checksum and fingerprint, NeXus, what lies around. Nothing is changed.

    Exit code 1 on errors and warnings.
    """
    from tribopipe.verify.archive import files_of, verify

    if folder is not None and archive not in (DEFAULT_ARCHIVE, folder):
        raise typer.BadParameter(f"found two archives, {folder} and {archive}; expected one")
    store, chosen = load_archive(folder or archive), run_ids or []
    with progress("verify", len(files_of(store.folder, chosen)) * (1 + recompute)) as advance:
        verified = verify(store, chosen, again=recompute, advance=advance)
    for finding in verified.findings:
        say(f"{finding.severity}: {seen(str(finding))}")
    say(f"{store.folder}: {verified}")
    if as_json:
        print_json({"archive": str(store.folder)} | verified.as_json())
    if not verified.sound:
        raise typer.Exit(FAILED)


COMMANDS = {"verify": verify}
