"""Commands that curate archived runs: mark-bad, tag, note, remove, restore."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from tribopipe.cli.options import DEFAULT_ARCHIVE, ArchivedIds, ArchiveFolder, AsJson, archived_ids, load_archive
from tribopipe.cli.output import attempt_each, exit_with, print_json, print_result, record_json, seen

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping, Sequence

    from tribopipe.archive.store import Archive
    from tribopipe.base.errors import TribopipeError
    from tribopipe.documents.annotation import Annotation, Mark


By = Annotated[str | None, typer.Option("--by", help="Name of the author; default: the current user.")]


def mark_bad(
    run_id: Annotated[str, typer.Argument(help="ID of an archived run.", metavar="ID", autocompletion=archived_ids)],
    reason: Annotated[str, typer.Option("--reason", help="Reason for the mark, stored with the run.")],
    undo: Annotated[bool, typer.Option("--undo", help="Remove the mark.")] = False,
    by: By = None,
    archive: ArchiveFolder = DEFAULT_ARCHIVE,
    as_json: AsJson = False,
) -> None:
    """Mark a run as bad to exclude it from studies and predictions.

    The run and its data stay in the archive. Each mark is kept with author, date and reason.
    """
    store = load_archive(archive)
    mark = _mark(run_id, reason, undo=undo, by=by)
    store.mark(run_id, mark)
    print_result(seen(f"{run_id}: {mark}"))
    if as_json:
        print_json({"id": run_id, "marks": [record_json(kept) for kept in store.marks(run_id)]})


def _mark(run_id: str, reason: str, *, undo: bool, by: str | None) -> "Mark":
    from tribopipe.documents.annotation import Mark
    from tribopipe.documents.record import read_document

    document = {"kind": "good" if undo else "bad", "reason": reason, **_who_and_when(by)}
    return read_document(document, Mark, where=run_id)


def tag(
    run_ids: ArchivedIds,
    add: Annotated[list[str] | None, typer.Option("--add", help="Tag to add; may be repeated.")] = None,
    remove: Annotated[list[str] | None, typer.Option("--remove", help="Tag to remove; may be repeated.")] = None,
    by: By = None,
    archive: ArchiveFolder = DEFAULT_ARCHIVE,
    as_json: AsJson = False,
) -> None:
    """Tag runs, or show their tags.

    `tribopipe ls --where tag=NAME` lists the tagged runs.

    Each change is kept in the run's file with author and date.
    """
    store = load_archive(archive)
    there = {run_id: store.tags(run_id) for run_id in run_ids}
    given = {text: _annotation("tag", text, by) for text in add or ()}
    taken = {text: _annotation("untag", text, by) for text in remove or ()}
    _refuse_what_none_has(taken, there)

    def retag(run_id: str) -> str:
        new = [one for text, one in given.items() if text not in there[run_id]]
        old = [one for text, one in taken.items() if text in there[run_id]]
        if new or old:
            store.annotate(run_id, *new, *old)
        return ", ".join(store.tags(run_id)) or "no tags"

    errors = _change_each(there, retag)
    if as_json:
        print_json({"runs": [{"id": run_id, "tags": list(store.tags(run_id))} for run_id in there]})
    exit_with(errors, some_done=len(errors) < len(there))


def _refuse_what_none_has(taken: "Iterable[str]", there: "Mapping[str, Sequence[str]]") -> None:
    """Raise ``ArchiveError`` for a tag to remove that no run has, such as a mistyped one."""
    from tribopipe.base.errors import ArchiveError, did_you_mean

    known = {text for tags in there.values() for text in tags}
    for text in taken:
        if text not in known:
            raise ArchiveError(
                f"{', '.join(there)}: found no tag {text!r} to remove; expected an existing tag; "
                f"{did_you_mean(text, known)}"
            )


def note(
    run_ids: ArchivedIds,
    text: Annotated[str, typer.Argument(help="Text of the note.", metavar="TEXT")],
    by: By = None,
    archive: ArchiveFolder = DEFAULT_ARCHIVE,
    as_json: AsJson = False,
) -> None:
    """Add a note to runs, kept with its author and date."""
    store, written = load_archive(archive), _annotation("note", text, by)
    for run_id in dict.fromkeys(run_ids):
        store.annotations(run_id)  # all are there before any is changed

    def write(run_id: str) -> str:
        store.annotate(run_id, written)
        return str(written)

    errors = _change_each(dict.fromkeys(run_ids), write)
    if as_json:
        runs = [{"id": run_id, "notes": _notes(store, run_id)} for run_id in dict.fromkeys(run_ids)]
        print_json({"runs": runs})
    exit_with(errors, some_done=len(errors) < len(set(run_ids)))


def _change_each(run_ids: "Iterable[str]", change: "Callable[[str], str]") -> "list[TribopipeError]":
    """Change runs and report the new state of each; return the errors."""
    _, errors = attempt_each(run_ids, lambda run_id: print_result(seen(f"{run_id}: {change(run_id)}")))
    return list(errors.values())


def _notes(store: "Archive", run_id: str) -> list[Any]:
    return [record_json(one) for one in store.annotations(run_id) if one.kind == "note"]


def _annotation(kind: str, text: str, by: str | None) -> "Annotation":
    from tribopipe.documents.annotation import Annotation
    from tribopipe.documents.record import read_document

    where = "the note" if kind == "note" else "the tag"
    return read_document({"kind": kind, "text": text, **_who_and_when(by)}, Annotation, where=where)


def _who_and_when(by: str | None) -> dict[str, str | None]:
    from datetime import UTC, datetime

    return {"date": datetime.now(UTC).isoformat(timespec="seconds"), "operator": logged_in() if by is None else by}


def logged_in() -> str | None:
    """Return the name of the user logged in; none if there is none, as in some containers."""
    import getpass

    try:
        return getpass.getuser().strip() or None
    except (ImportError, KeyError, OSError):  # which of them depends on platform and version of Python
        return None


OfStudies = Annotated[bool, typer.Option("--study", help="Treat the IDs as study IDs instead of run IDs.")]


def removed_ids(context: typer.Context) -> list[str]:
    """Complete ids of removed runs from the archive specified so far, or the one in the current folder."""
    archive = Path(context.params.get("archive") or DEFAULT_ARCHIVE)
    return sorted({path.stem for path in archive.glob("removed/*/*.h5")})


def remove(
    ids: ArchivedIds,
    study: OfStudies = False,
    force: Annotated[bool, typer.Option("--force", help="Also remove runs that are used in a study.")] = False,
    archive: ArchiveFolder = DEFAULT_ARCHIVE,
    as_json: AsJson = False,
) -> None:
    """Remove runs from the archive; they can be restored.

    Their files are kept in the subfolder `removed` of the archive, which all other commands ignore.
    """
    from tribopipe.archive import removal

    store, by = load_archive(archive), logged_in()

    def take_out(name: str) -> Path:
        return removal.remove(store, name, study=study, force=force, by=by)

    _move_each(ids, take_out, "removed; kept as {}", as_json=as_json)


def restore(
    ids: Annotated[list[str], typer.Argument(help="IDs of removed runs.", metavar="ID", autocompletion=removed_ids)],
    study: OfStudies = False,
    archive: ArchiveFolder = DEFAULT_ARCHIVE,
    as_json: AsJson = False,
) -> None:
    """Restore removed runs.

    If several runs with the same ID were removed, the last of them is restored.
    """
    from tribopipe.archive import removal

    store, by = load_archive(archive), logged_in()
    _move_each(ids, lambda name: removal.restore(store, name, study=study, by=by), "restored as {}", as_json=as_json)


def _move_each(ids: "Iterable[str]", move: "Callable[[str], Path]", told: str, *, as_json: bool) -> None:
    """Move the file of each run and report its new path; an error in one does not stop the others."""

    def move_and_tell(name: str) -> Path:
        path = move(name)
        print_result(seen(f"{name}: {told.format(path)}"))
        return path

    moved, errors = attempt_each(ids, move_and_tell)
    if as_json:
        files = [{"id": name, "file": str(moved[name]), "error": None} for name in moved]
        files += [{"id": name, "file": None, "error": str(error)} for name, error in errors.items()]
        print_json({"files": files})
    exit_with(list(errors.values()), some_done=bool(moved))
