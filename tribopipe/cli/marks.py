"""The command that says of a run as a whole what to think of it: mark-bad."""

from typing import TYPE_CHECKING, Annotated

import typer

from tribopipe.cli.options import DEFAULT_ARCHIVE, ArchiveFolder, AsJson, archived_ids, load_archive
from tribopipe.cli.output import print_json, record_json, say

if TYPE_CHECKING:
    from tribopipe.records.mark import Mark


def mark_bad(
    run_id: Annotated[str, typer.Argument(help="Id of an archived run.", metavar="ID", autocompletion=archived_ids)],
    reason: Annotated[str, typer.Option("--reason", help="Why; kept with the run.")],
    undo: Annotated[bool, typer.Option("--undo", help="Take the mark back.")] = False,
    by: Annotated[str | None, typer.Option("--by", help="Who marks it; by default the user logged in.")] = None,
    archive: ArchiveFolder = DEFAULT_ARCHIVE,
    as_json: AsJson = False,
) -> None:
    """Mark a run as an outlier: left out of studies, and no reference of predictions.

    It stays in the archive with everything it holds, and so does each mark: who, when, what and why.
    """
    store = load_archive(archive)
    mark = _mark(run_id, reason, undo=undo, by=by)
    store.mark(run_id, mark)
    say(f"{run_id}: {mark}")
    if as_json:
        print_json({"id": run_id, "marks": [record_json(kept) for kept in store.marks(run_id)]})


def _mark(run_id: str, reason: str, *, undo: bool, by: str | None) -> "Mark":
    from datetime import UTC, datetime

    from tribopipe.records.base import read_document
    from tribopipe.records.mark import Mark

    document = {
        "kind": "good" if undo else "bad",
        "reason": reason,
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
        "operator": _user() if by is None else by,
    }
    return read_document(document, Mark, where=run_id)


def _user() -> str | None:
    """Return the name of the user logged in; none where there is none, as in some containers."""
    import getpass

    try:
        return getpass.getuser().strip() or None
    except (ImportError, KeyError, OSError):  # which of them depends on platform and version of Python
        return None


COMMANDS = {"mark-bad": mark_bad}
