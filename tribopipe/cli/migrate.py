"""The command that brings an archive up to date: migrate."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from tribopipe.cli.options import DEFAULT_ARCHIVE, ArchiveFolder, AsJson, archived_ids, load_archive
from tribopipe.cli.output import exit_with, print_json, progress, say

if TYPE_CHECKING:
    from tribopipe.archive.migrate import Migrated

ArchivedIds = Annotated[
    list[str] | None,
    typer.Argument(help="Ids of archived runs and studies; none for all.", metavar="ID", autocompletion=archived_ids),
]


def migrate(ids: ArchivedIds = None, archive: ArchiveFolder = DEFAULT_ARCHIVE, as_json: AsJson = False) -> None:
    """Bring files that an older tribopipe archived to the present format; nothing is computed anew.

    The originals stay in the archive, in the folder before-format-3, until you delete it.
    """
    from tribopipe.archive.migrate import files_of
    from tribopipe.archive.migrate import migrate as bring_up
    from tribopipe.base.failures import in_a_sentence

    store = load_archive(archive)
    files, done, errors = files_of(store, ids or ()), {}, {}
    with progress("migrate", len(files)) as advance:
        for path in files:
            try:
                done[path] = bring_up(store, path)
                _say(path, done[path])
            except Exception as error:  # noqa: BLE001 - the others go on, whatever it is
                errors[path] = in_a_sentence(error, str(path))
            advance(path.stem)
    if as_json:
        print_json({"files": [_document(path, done.get(path), errors.get(path)) for path in files]})
    _say_what_was_done(archive, list(done.values()), failed=bool(errors))
    exit_with(list(errors.values()), some_done=bool(done))


def _say(path: Path, found: "Migrated") -> None:
    if found.kept is not None:
        say(f"{path.stem}: format {found.before.version} brought to {found.after.version}")


def _document(path: Path, found: "Migrated | None", error: Exception | None) -> dict[str, Any]:
    if found is None:
        return {"file": str(path), "status": "failed", "error": str(error)}
    status = "unchanged" if found.kept is None else "migrated"
    formats = {"before": str(found.before), "format": str(found.after)}
    return {"file": str(path), "status": status, **formats, "original": found.kept and str(found.kept), "error": None}


def _say_what_was_done(archive: Path, done: "list[Migrated]", *, failed: bool) -> None:
    brought = [found.after.version for found in done if found.kept is not None]
    if brought:
        where = " and ".join(str(archive / f"before-format-{version}") for version in sorted(set(brought)))
        say(f"{len(brought)} files brought up to date; their originals stay in {where} until you delete it")
    elif not failed:
        say("Nothing to do: every file is of the present format.")


COMMANDS = {"migrate": migrate}
