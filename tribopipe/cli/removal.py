"""Commands that take runs and studies out of an archive and put them back: remove, restore."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tribopipe.cli.options import DEFAULT_ARCHIVE, ArchiveFolder, AsJson, archived_ids, load_archive
from tribopipe.cli.output import exit_with, print_json, print_result, seen

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

Study = Annotated[bool, typer.Option("--study", help="The ids are those of studies.")]


def removed_ids(context: typer.Context) -> list[str]:
    """Complete ids of removed runs from the archive named so far, or the one in the current folder."""
    archive = Path(context.params.get("archive") or DEFAULT_ARCHIVE)
    return sorted({path.stem for path in archive.glob("removed/*/*.h5")})


def remove(
    ids: Annotated[list[str], typer.Argument(help="IDs of archived runs.", metavar="ID", autocompletion=archived_ids)],
    study: Study = False,
    force: Annotated[bool, typer.Option("--force", help="Also runs that a study names.")] = False,
    archive: ArchiveFolder = DEFAULT_ARCHIVE,
    as_json: AsJson = False,
) -> None:
    """Remove runs from the archive; they can be restored.

    Their files are kept in the folder removed of the archive, where no other command looks.
    """
    from tribopipe.archive import removal
    from tribopipe.cli.marks import logged_in

    store, by = load_archive(archive), logged_in()

    def take_out(name: str) -> Path:
        return removal.remove(store, name, study=study, force=force, by=by)

    _each(ids, take_out, "removed; kept as {}", as_json=as_json)


def restore(
    ids: Annotated[list[str], typer.Argument(help="IDs of removed runs.", metavar="ID", autocompletion=removed_ids)],
    study: Study = False,
    archive: ArchiveFolder = DEFAULT_ARCHIVE,
    as_json: AsJson = False,
) -> None:
    """Restore removed runs.

    Of several that were removed under one id the last one is restored.
    """
    from tribopipe.archive import removal
    from tribopipe.cli.marks import logged_in

    store, by = load_archive(archive), logged_in()
    _each(ids, lambda name: removal.restore(store, name, study=study, by=by), "restored as {}", as_json=as_json)


def _each(ids: "Iterable[str]", move: "Callable[[str], Path]", told: str, *, as_json: bool) -> None:
    """Move the file of each and report where it is; an error with one does not stop the others."""
    from tribopipe.base.failures import in_a_sentence

    moved, errors = {}, {}
    for name in dict.fromkeys(ids):
        try:
            moved[name] = move(name)
            print_result(seen(f"{name}: {told.format(moved[name])}"))
        except Exception as error:  # noqa: BLE001 - the others can still be moved
            errors[name] = in_a_sentence(error, name)
    if as_json:
        files = [{"id": name, "file": str(moved[name]), "error": None} for name in moved]
        files += [{"id": name, "file": None, "error": str(error)} for name, error in errors.items()]
        print_json({"files": files})
    exit_with(list(errors.values()), some_done=bool(moved))
