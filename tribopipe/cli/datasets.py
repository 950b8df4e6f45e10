"""Commands that pack runs for a repository or a lab notebook, and import them again: export dataset, import."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from tribopipe.base.errors import counted
from tribopipe.cli.options import (
    DEFAULT_ARCHIVE,
    ArchiveFolder,
    AsJson,
    HelpPanels,
    ReadableArchive,
    Replace,
    archived_names,
    load_archive,
)
from tribopipe.cli.output import exit_with, print_json, print_result, progress, say

if TYPE_CHECKING:
    from tribopipe.documents.dataset import Dataset
    from tribopipe.extras.fair.export import Exported
    from tribopipe.extras.fair.restore import Restored


NAME = "dataset"
_PACKED = ("ro_crate", "eln")
_OPTIONS = ("--ro-crate", "--eln")


class ExportGroup(HelpPanels):
    """The subcommands of export, and two options that are short for one of them: `export --ro-crate OUT [ID]...`."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Read the command line; with one of the options and no subcommand before it, as that of the subcommand."""
        packs = any(arg.partition("=")[0] in _OPTIONS for arg in args)
        if packs and args[0] not in self.commands:
            args = [NAME, *args]
        return super().parse_args(ctx, args)

    def get_params(self, ctx: Any) -> list[Any]:
        """Return the commands shown by help and completion."""
        own = [one for one in self.commands[NAME].params if one.name in _PACKED] if NAME in self.commands else []
        return [*super().get_params(ctx), *own]


def export_dataset(
    ids: Annotated[
        list[str] | None,
        typer.Argument(
            help="IDs of archived runs and studies; a study includes its runs; default: all.",
            metavar="ID",
            autocompletion=archived_names,
        ),
    ] = None,
    ro_crate: Annotated[
        Path | None,
        typer.Option(
            "--ro-crate", help="RO-Crate to write: a folder, or a ZIP file if OUT ends in .zip.", metavar="OUT"
        ),
    ] = None,
    eln: Annotated[Path | None, typer.Option("--eln", help="ELN archive to write (.eln).", metavar="OUT.eln")] = None,
    dataset: Annotated[
        Path | None,
        typer.Option(
            "--dataset", help="TOML file with title, people and license; default: dataset.toml next to the archive."
        ),
    ] = None,
    report: Annotated[bool, typer.Option("--report/--no-report", help="Include a report of each run.")] = True,
    archive: ReadableArchive = DEFAULT_ARCHIVE,
    force: Replace = False,
    as_json: AsJson = False,
) -> None:
    """Pack runs and studies for a repository or a lab notebook.

    `tribopipe export --ro-crate OUT` is short for `tribopipe export dataset --ro-crate OUT`; the same applies to
    --eln. The data set contains the archive files byte for byte, the instrument files, all data as CSV and JSON,
    reports, a codebook, and machine-readable metadata. Use `tribopipe import` to reimport it.
    """
    from tribopipe.base.errors import OutputError
    from tribopipe.extras.fair.export import choose, export_crate
    from tribopipe.pipeline.output_paths import require_free

    path = _path(ro_crate, eln)
    if path == ro_crate and path.is_dir():
        raise OutputError(
            f"{path}: found an existing folder; expected a folder that does not exist, since folders are never "
            "replaced; specify another folder"
        )
    require_free([path], force=force)
    store = load_archive(archive)
    chosen = choose(store, ids or ())
    said, document = _said(dataset, archive)
    with progress("pack", len(chosen.runs) + len(chosen.studies)) as advance:
        exported = export_crate(
            store,
            chosen,
            path,
            eln=eln is not None,
            dataset=said,
            document=document,
            reports=report,
            advance=advance,
        )
    _tell(exported)
    if as_json:
        print_json(_exported_document(exported))


def _path(ro_crate: Path | None, eln: Path | None) -> Path:
    """Return the path of the data set to write."""
    if (ro_crate is None) == (eln is None):
        raise typer.BadParameter("specify the file to write: --ro-crate OUT or --eln OUT.eln")
    if eln is not None and eln.suffix.lower() != ".eln":
        raise typer.BadParameter(f"--eln: found {str(eln)!r}; expected a file name that ends in .eln")
    return ro_crate or eln or Path()


def _said(path: Path | None, archive: Path) -> "tuple[Dataset, bytes | None]":
    """Return the content of dataset.toml and its bytes; nothing if none is specified or next to the archive."""
    from tribopipe.documents.dataset import DATASET_NAME, NOTHING_SAID, Dataset
    from tribopipe.documents.record import read_document
    from tribopipe.documents.toml import parse_toml, read_bytes

    beside = archive.resolve().parent / DATASET_NAME
    if path is None and not beside.is_file():
        return NOTHING_SAID, None
    named = path or beside
    content = read_bytes(named)
    return read_document(parse_toml(named, content), Dataset, where=str(named)), content


def _tell(exported: "Exported") -> None:
    runs, studies = exported.chosen
    beside = f" and {len(studies)} {'study' if len(studies) == 1 else 'studies'}" if studies else ""
    say(f"{counted(len(runs), 'run')}{beside} written to {exported.path}")
    if exported.lacking:
        say(f"note: repositories require {', '.join(exported.lacking)}; add this to dataset.toml next to the archive")


def _exported_document(exported: "Exported") -> dict[str, Any]:
    return {
        "file": str(exported.path),
        "runs": list(exported.chosen.runs),
        "studies": list(exported.chosen.studies),
        "lacking": list(exported.lacking),
    }


def import_crate(
    crate: Annotated[
        Path,
        typer.Argument(
            help="RO-Crate or .eln file written by `tribopipe export`, packed or unpacked.", metavar="CRATE"
        ),
    ],
    archive: ArchiveFolder = DEFAULT_ARCHIVE,
    as_json: AsJson = False,
) -> None:
    """Import the runs and studies of an exported data set.

    Every file is checked against its SHA-256 in the crate and against its seal. Runs and studies that are already in
    the archive are left unchanged; an ID that is already used for different content is an error. The dataset.toml of
    the crate is written next to the archive if none exists.
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
        print_json(_imported_document(restored))
    refused = [restored.refused_dataset] if restored.refused_dataset else []
    exit_with([*restored.failed.values(), *refused], some_done=bool(restored.done))


def _imported_document(restored: "Restored") -> dict[str, Any]:
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
