"""The command that makes a run folder from an instrument's files: new."""

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from tribopipe.base.errors import ManifestError, counted
from tribopipe.cli.formats import ReaderName, SheetName
from tribopipe.cli.options import AsJson, Template
from tribopipe.cli.output import PARTLY_FAILED, print_json, say

if TYPE_CHECKING:
    from tribopipe.readers.draft.batch import LeftOut
    from tribopipe.readers.draft.blanks import Ask
    from tribopipe.readers.draft.folder import NewRun


def new(
    files: Annotated[
        list[Path],
        typer.Argument(
            help=(
                "Instrument files of one test: a single file, consecutive files, or one file per channel; or a "
                "folder with one export per run."
            ),
            metavar="FILE",
        ),
    ],
    into: Annotated[Path, typer.Option("--into", help="Folder in which to create the run folder.")] = Path(),
    run_id: Annotated[
        str | None, typer.Option("--id", help="ID of the run; default: derived from the name of the first file.")
    ] = None,
    template: Template = None,
    reader: ReaderName = None,
    settings: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            help="Key of run.toml and its value, for example conditions.normal_load='5 N'.",
            metavar="KEY=VALUE",
        ),
    ] = None,
    profiles: Annotated[
        list[str] | None,
        typer.Option("--profile", help="Body and its profile file, for example disc=track.txt.", metavar="BODY=FILE"),
    ] = None,
    sheet: SheetName = None,
    each_sheet: Annotated[
        bool,
        typer.Option("--each-sheet", help="Create a run folder for each sheet that contains a test."),
    ] = False,
    each_row: Annotated[
        bool,
        typer.Option(
            "--each-row",
            help="Create a run folder for each row of a table (.csv or .xlsx) of tests without recorded signals.",
        ),
    ] = False,
    split: Annotated[
        str | None,
        typer.Option(
            "--split", help="Column with step numbers; a run folder is created for each step.", metavar="COLUMN"
        ),
    ] = None,
    accept: Annotated[
        bool,
        typer.Option("--accept", help="Accept suggested values (file name, recording, typical of the material)."),
    ] = False,
    ends: Annotated[
        Path | None,
        typer.Option(
            "--ends",
            help=(
                "Table (.csv or .xlsx) of loads, scar sizes and wear volumes, one row per run; a run is created "
                "from each recording."
            ),
        ),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Create a run folder from the files of an instrument.

    The files are copied, and their metadata are written to run.toml.

    For a folder, it creates one run folder per export and lists duplicates, unusually short tests and files that are
    not exports. With --each-sheet or --split, it creates one run folder per test in the file, each with its own copy of
    the file. With --each-row, it creates one run folder per row of a table of tests without recorded signals.

    In a terminal, it prompts for values that the files do not contain; unanswered values become commented lines in
    run.toml. The original files are not modified.
    """
    from tribopipe.pipeline.output_paths import require_folder
    from tribopipe.readers.draft.batch import are_many, make_each, make_of_rows
    from tribopipe.readers.draft.folder import Wanted, make_runs

    require_folder(into)
    wanted = Wanted(
        files,
        into,
        run_id,
        template,
        reader,
        settings or (),
        profiles or (),
        sheet,
        each_sheet=each_sheet,
        each_row=each_row,
        split=split,
        accept=accept,
    )
    many = are_many(files) or ends is not None
    left_out: list[LeftOut] = []
    if each_row:
        _refuse_next_to_rows(
            {"--ends": ends, "--id": run_id, "--reader": reader, "--profile": profiles, "--sheet": sheet}
            | {"--each-sheet": each_sheet, "--split": split}
        )
        made = make_of_rows(wanted, _somebody_to_ask(), say)
    elif many:
        made, left_out = make_each(wanted, ends, _somebody_to_ask(), say)
    else:
        made = make_runs(wanted, _somebody_to_ask(), say)
    for one in made:
        _tell(one)
    for file in left_out:
        say(f"skipped: {file.file}: {file.why}")
    if as_json:
        documents = [_document(one) for one in made]
        outside = [{"file": file.file, "why": file.why} for file in left_out]
        both = {"runs": documents, "left_out": outside}
        print_json(both if many else {"runs": documents} if each_sheet or split or each_row else documents[0])
    if any(file.is_broken for file in left_out):
        raise typer.Exit(PARTLY_FAILED)


def _refuse_next_to_rows(options: Mapping[str, object]) -> None:
    given = [name for name, value in options.items() if value]
    if given:
        raise ManifestError(
            f"--each-row: found {given[0]} in addition to this option; expected only a table with one run per row; "
            f"remove {given[0]}"
        )


def _document(made: "NewRun") -> dict[str, Any]:
    return {
        "id": made.folder.name,
        "folder": str(made.folder),
        "files": [{"format": group.first.reader.name, "names": group.names} for group in made.groups],
        "still_to_be_filled_in": made.missing,
        "problem": made.problem,
        "notes": made.notes,
        "accepted": made.accepted,
    }


def _somebody_to_ask() -> "Ask | None":
    """Return the function that asks a question, on a terminal only; Ctrl-C and the end of input stop the command."""
    if not (sys.stdin.isatty() and sys.stderr.isatty()):
        return None
    return _answer


def _answer(question: str) -> str:
    typer.echo(f"{question}: ", nl=False, err=True)  # stdout is for programs
    return input()


def _tell(made: "NewRun") -> None:
    for group in made.groups:
        say(f"{made.folder}: {group}: {counted(group.rows, 'row')}, {group.first.reader.title}")
    for note in made.notes:
        say(f"  note: {note}")
    for value in made.accepted:
        say(f"  accepted: {value}")
    if made.missing:
        say(f"still missing: {', '.join(made.missing)}")
    if made.problem:
        say(f"still to be corrected: {made.problem}")
    if made.bodies_lack:
        say(f"only friction is evaluated until run.toml describes the bodies; missing: {', '.join(made.bodies_lack)}")
    if made.suggested:
        say(
            f"suggested in run.toml: {', '.join(made.suggested)}; to accept, remove the # from these lines, or delete "
            "this folder and repeat the command with --accept"
        )
    first = f"edit {made.folder / 'run.toml'}, then " if made.missing or made.problem else ""
    say(f"Next: {first}tribopipe process {made.folder}")
