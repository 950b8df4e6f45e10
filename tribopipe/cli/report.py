"""The command that writes what can be sent to someone: report."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tribopipe.cli.options import DEFAULT_ARCHIVE, ArchiveFolder, archived_ids, load_archive
from tribopipe.cli.output import say
from tribopipe.cli.studies import archived_studies

if TYPE_CHECKING:
    from collections.abc import Sequence

    from tribopipe.archive.store import Archive


def _archived(context: typer.Context) -> list[str]:
    """Complete ids of archived runs and studies."""
    return [*archived_ids(context), *archived_studies(context)]


def report(
    ids: Annotated[
        list[str],
        typer.Argument(help="Ids of archived runs, or of one study.", metavar="ID|STUDY", autocompletion=_archived),
    ],
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="File to write; ID.html, or report.html of several.")
    ] = None,
    run: Annotated[bool, typer.Option("--run", help="Take the run where a study has the same id.")] = False,
    archive: ArchiveFolder = DEFAULT_ARCHIVE,
    force: Annotated[bool, typer.Option("--force", help="Replace an existing file.")] = False,
) -> None:
    """Write a report of runs, or of a study, as one HTML file.

    It holds figures, tables, methods with their equations, provenance, and the items customary under ASTM G99 with what
    is missing of them. It loads nothing; a browser prints it, or makes a PDF of it.
    """
    from tribopipe.base.files import write_file
    from tribopipe.pipeline.output_paths import require_free

    path = output or Path(f"{ids[0]}.html" if len(ids) == 1 else "report.html")
    store = load_archive(archive)
    study = _is_study(store, ids, as_run=run)
    require_free([path], force=force)
    document = _document(store, ids, study=study)
    path.parent.mkdir(parents=True, exist_ok=True)
    write_file(path, document.encode("utf-8"))
    say(f"{', '.join(ids)}: report written to {path}")


def _is_study(store: "Archive", ids: "Sequence[str]", *, as_run: bool) -> bool:
    """Return whether one study is meant. Raises ``ArchiveError`` where an id is not known, or a study is not alone."""
    from tribopipe.base.errors import ArchiveError, did_you_mean

    runs, studies = set(store.ids()), set(store.study_ids())
    unknown = next((one for one in ids if one not in runs | studies), None)
    if unknown is not None:
        raise ArchiveError(
            f"{store.folder}: found neither a run nor a study {unknown!r}; expected one in the archive; "
            f"{did_you_mean(unknown, runs | studies)}"
        )
    if len(ids) == 1:
        return ids[0] in studies and not (as_run and ids[0] in runs)
    study = next((one for one in ids if one not in runs), None)
    if study is not None:
        raise ArchiveError(
            f"{store.folder}: found the study {study!r} among several ids; expected runs, or one study by itself; "
            "write a report of each"
        )
    return False


def _document(store: "Archive", ids: "Sequence[str]", *, study: bool) -> str:
    from tribopipe.views.html.document import run_report, study_report

    return study_report(store, ids[0]) if study else run_report(store, ids)


COMMANDS = {"report": report}
