"""The command that verifies an archive: verify."""

import re
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tribopipe.cli.options import DEFAULT_ARCHIVE, ArchiveFolder, AsJson, archived_ids, load_archive
from tribopipe.cli.output import FAILED, print_json, print_result, progress, seen

if TYPE_CHECKING:
    from collections.abc import Iterable

    from tribopipe.archive.store import Archive

_SHOWN = 16
"""Digits of a hash that people copy."""
_HASH = re.compile("[0-9a-f]{8,64}")


def _hash(text: str) -> str:
    """Read the hash of a line of the history, or its beginning."""
    if not _HASH.fullmatch(text.lower()):
        raise typer.BadParameter(
            f"found {text!r}; expected 8 to 64 of the digits 0 to 9 and a to f, as verify shows them"
        )
    return text.lower()


def verify(
    folder: Annotated[
        Path | None, typer.Argument(help="Archive folder; default: that of --archive.", metavar="ARCHIVE")
    ] = None,
    run_ids: Annotated[
        list[str] | None,
        typer.Option("--run", help="ID of the only run to verify; may be repeated.", autocompletion=archived_ids),
    ] = None,
    recompute: Annotated[
        bool, typer.Option("--recompute", help="Recompute every step from the source files and compare.")
    ] = False,
    against: Annotated[
        str | None,
        typer.Option(
            "--against",
            help="Hash printed by an earlier verify; reports another or an older copy of the archive.",
            metavar="HASH",
            parser=_hash,
        ),
    ] = None,
    accepted: Annotated[
        list[str] | None,
        typer.Option(
            "--accept",
            help="Removed or replaced run or study, or history.jsonl, to accept as it is; may be repeated.",
            metavar="ID",
        ),
    ] = None,
    archive: ArchiveFolder = DEFAULT_ARCHIVE,
    as_json: AsJson = False,
) -> None:
    """Verify an archive: checksums, structure and history.

    No run and no study is changed. Exit code 1 on errors and warnings.
    """
    from tribopipe.pipeline.verify.archive import files_of, verify

    if folder is not None and archive not in (DEFAULT_ARCHIVE, folder):
        raise typer.BadParameter(f"found two archives, {folder} and {archive}; expected one")
    store, chosen = load_archive(folder or archive), run_ids or []
    _accept(store, accepted or ())
    with progress("verify", len(files_of(store.folder, chosen)) * (1 + recompute)) as advance:
        verified = verify(store, chosen, again=recompute, against=against or "", advance=advance)
    for finding in verified.findings:
        print_result(f"{finding.severity}: {seen(str(finding))}")
    if verified.lines:
        print_result(f"{store.folder}: history of {verified.lines} lines, head {verified.head[:_SHOWN]}")
    print_result(f"{store.folder}: {verified}")
    if as_json:
        print_json({"archive": str(store.folder)} | verified.as_json())
    if not verified.sound:
        raise typer.Exit(FAILED)


def _accept(store: "Archive", wanted: "Iterable[str]") -> None:
    from tribopipe.cli.marks import logged_in
    from tribopipe.pipeline.verify.history import accept

    for one in wanted:
        for name in accept(store.folder, one, logged_in()):
            print_result(seen(f"{name}: accepted as it is"))
