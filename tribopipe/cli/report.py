"""The command that writes reports: report."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from tribopipe.cli.options import DEFAULT_ARCHIVE, ReadableArchive, Replace, archived_names, load_archive
from tribopipe.cli.output import say

if TYPE_CHECKING:
    from collections.abc import Sequence

    from tribopipe.archive.store import Archive
    from tribopipe.documents.report_details import StandardName
    from tribopipe.views.html.particulars import Addressed


def report(
    ids: Annotated[
        list[str],
        typer.Argument(
            help="IDs of archived runs, or of one study.", metavar="ID|STUDY", autocompletion=archived_names
        ),
    ],
    output: Annotated[
        Path | None,
        typer.Option(
            "--output", "-o", help="File to write: .html or .pdf; default: ID.html, or report.html for several."
        ),
    ] = None,
    details: Annotated[
        list[Path] | None,
        typer.Option(
            "--details", help="TOML file with laboratory, customer, samples and signatories; may be repeated."
        ),
    ] = None,
    standard: Annotated[
        Literal["g99", "g133", "g77", "d4172", "d5183", "d6425", "iso20808", "iso7148"] | None,
        typer.Option("--standard", help="Standard whose reporting items are listed."),
    ] = None,
    customer: Annotated[
        bool, typer.Option("--customer", help="Omit internal advice, tags, notes and options.")
    ] = False,
    pdf: Annotated[
        bool, typer.Option("--pdf", help="Write a PDF file, using an installed Chromium, Chrome or Edge.")
    ] = False,
    run: Annotated[bool, typer.Option("--run", help="Report on the run if a study has the same ID.")] = False,
    archive: ReadableArchive = DEFAULT_ARCHIVE,
    force: Replace = False,
) -> None:
    """Write a report of runs, or of a study, as one HTML or PDF file.

    It contains figures, tables, methods with their equations, provenance, and the reporting items of ASTM G99, G133,
    G77 or D4172, with missing items marked. A file given with --details adds letterhead, customer, samples and
    signatures.
    """
    from tribopipe.base.files import write_file
    from tribopipe.pipeline.output_paths import require_free
    from tribopipe.views.html.rendering import printed

    as_pdf = pdf or (output is not None and output.suffix.lower() == ".pdf")
    path = output or Path(f"{ids[0] if len(ids) == 1 else 'report'}.{'pdf' if as_pdf else 'html'}")
    store = load_archive(archive)
    study = _is_study(store, ids, as_run=run)
    require_free([path], force=force)
    addressed = _addressed(details or [], standard, for_customer=customer)
    document = _document(store, ids, addressed, study=study)
    content = printed(document) if as_pdf else document.encode("utf-8")
    path.parent.mkdir(parents=True, exist_ok=True)
    write_file(path, content)
    say(f"{', '.join(ids)}: report written to {path}")


def _addressed(details: "Sequence[Path]", standard: "StandardName | None", *, for_customer: bool) -> "Addressed":
    from tribopipe.documents.report_details import read_details
    from tribopipe.views.html.particulars import Addressed

    if not details:
        return Addressed(standard=standard, for_customer=for_customer)
    return Addressed(*read_details(details), standard, for_customer)


def _is_study(store: "Archive", ids: "Sequence[str]", *, as_run: bool) -> bool:
    """Return whether a study is requested. Raises ``ArchiveError`` for unknown ids and for a study among other ids."""
    from tribopipe.base.errors import ArchiveError, did_you_mean

    runs, studies = set(store.ids()), set(store.study_ids())
    unknown = next((one for one in ids if one not in runs | studies), None)
    if unknown is not None:
        raise ArchiveError(
            f"{store.folder}: found no run or study {unknown!r}; expected the ID of an archived run or study; "
            f"{did_you_mean(unknown, runs | studies)}"
        )
    if len(ids) == 1:
        return ids[0] in studies and not (as_run and ids[0] in runs)
    study = next((one for one in ids if one not in runs), None)
    if study is not None:
        raise ArchiveError(
            f"{store.folder}: found the study {study!r} among several IDs; expected only runs, or a single study; "
            "write a separate report of the study"
        )
    return False


def _document(store: "Archive", ids: "Sequence[str]", addressed: "Addressed", *, study: bool) -> str:
    from tribopipe.views.html.document import run_report, study_report

    if study:
        return study_report(store, ids[0], addressed=addressed)
    return run_report(store, ids, addressed=addressed)
