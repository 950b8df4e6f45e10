"""The command that takes archived runs out of an RO-Crate or a .eln file: import."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from tribopipe.cli.options import DEFAULT_ARCHIVE, ArchiveFolder, AsJson, load_archive
from tribopipe.cli.output import exit_with, print_json, print_result, progress, say

if TYPE_CHECKING:
    from tribopipe.extras.fair.restore import Restored


def import_crate(
    crate: Annotated[
        Path,
        typer.Argument(
            help="RO-Crate or .eln file that `tribopipe export` wrote, packed or unpacked.", metavar="CRATE"
        ),
    ],
    archive: ArchiveFolder = DEFAULT_ARCHIVE,
    as_json: AsJson = False,
) -> None:
    """Import the runs and studies of an exported dataset.

    Every file is held against the SHA-256 that the crate shows, and against the seal in it. One that is in the archive
    already and the same stays; one of the same id and other content is refused. A dataset.toml of the crate is written
    next to the archive where there is none.
    """
    from tribopipe.extras.fair.restore import restore

    store = load_archive(archive, must_exist=False)
    with progress("import", None) as advance:
        restored = restore(crate, store, advance)
    for one, done in restored.done.items():
        kind = "study" if one.study else "run"
        print_result(f"{one.id}: {f'{kind} archived' if done == 'added' else 'unchanged, nothing to do'}")
    if restored.dataset is not None:
        say(f"{restored.dataset} written")
    if as_json:
        print_json(_document(restored))
    refused = [restored.refused_dataset] if restored.refused_dataset else []
    exit_with([*restored.failed.values(), *refused], some_done=bool(restored.done))


def _document(restored: "Restored") -> dict[str, Any]:
    files = [(one, done, None) for one, done in restored.done.items()]
    failed = [(one, "failed", str(error)) for one, error in restored.failed.items()]
    return {
        "dataset": None if restored.dataset is None else str(restored.dataset),
        "dataset_error": None if restored.refused_dataset is None else str(restored.refused_dataset),
        "files": [
            {"id": one.id, "kind": "study" if one.study else "run", "status": status, "error": error}
            for one, status, error in [*files, *failed]
        ],
    }
