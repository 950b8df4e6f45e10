"""The command that makes a run folder from an instrument's files: new."""

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from tribopipe.base.errors import ManifestError
from tribopipe.cli.formats import ReaderName, SheetName
from tribopipe.cli.options import AsJson
from tribopipe.cli.output import PARTLY_FAILED, print_json, say

if TYPE_CHECKING:
    from tribopipe.readers.draft.export_folder import LeftOut
    from tribopipe.readers.draft.folder import NewRun
    from tribopipe.readers.draft.questions import Ask


def new(
    files: Annotated[
        list[Path],
        typer.Argument(
            help="Files that an instrument wrote during one test: one, several that continue each other, or one per "
            "channel; or a folder of exports, one per run.",
            metavar="FILE",
        ),
    ],
    into: Annotated[Path, typer.Option("--into", help="Folder to make the run's folder in.")] = Path(),
    run_id: Annotated[
        str | None, typer.Option("--id", help="Id of the run; by default made from the first file's name.")
    ] = None,
    template: Annotated[
        Path | None, typer.Option("--template", help="TOML file of what is the same in all runs of the lab.")
    ] = None,
    reader: ReaderName = None,
    settings: Annotated[
        list[str] | None,
        typer.Option(
            "--set", help="Key of run.toml with its value: conditions.normal_load='5 N'.", metavar="KEY=VALUE"
        ),
    ] = None,
    profiles: Annotated[
        list[str] | None,
        typer.Option("--profile", help="Profile measured on a body: disc=track.txt.", metavar="BODY=FILE"),
    ] = None,
    sheet: SheetName = None,
    each_sheet: Annotated[
        bool, typer.Option("--each-sheet", help="Make a run folder of each sheet of a workbook that holds a test.")
    ] = False,
    each_row: Annotated[
        bool,
        typer.Option(
            "--each-row",
            help="Make a run folder of each row of a table of finished tests, .csv or .xlsx, without recordings.",
        ),
    ] = False,
    split: Annotated[
        str | None,
        typer.Option(
            "--split", help="Make a run folder of each step, by the column that numbers them.", metavar="COLUMN"
        ),
    ] = None,
    accept: Annotated[
        bool,
        typer.Option(
            "--accept", help="Take the values that the file's name and the recording offer, where they agree."
        ),
    ] = False,
    ends: Annotated[
        Path | None,
        typer.Option(
            "--ends",
            help="Table, .csv or .xlsx, of loads, scars and volumes of many runs, one row each; each file is a run.",
        ),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Make a run folder from the files of an instrument.

    The files are copied, and run.toml is written with everything that they contain.

    Of a folder it makes a run folder of each export, and names duplicates, tests that are much shorter than the others,
    and what is no export. With --each-sheet or --split it makes a folder of each test in the file, each with its own
    copy of it. With --each-row it makes one of each row of a table of tests that were not recorded.

    On a terminal it asks for what only the lab knows; elsewhere, and where nothing is answered, run.toml has a
    commented line for it. The files themselves stay as they are.
    """
    from tribopipe.pipeline.output_paths import require_folder
    from tribopipe.readers.draft.export_folder import are_many, make_each
    from tribopipe.readers.draft.finished_tests import make_of_rows
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
        say(f"left out: {file.file}: {file.why}")
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
            f"--each-row: found {given[0]} with it; expected one table alone, of which each row is a run; remove "
            f"{given[0]}"
        )


def _document(made: "NewRun") -> dict[str, Any]:
    return {
        "id": made.folder.name,
        "folder": str(made.folder),
        "files": [{"format": group.first.reader.name, "names": group.names} for group in made.groups],
        "still_to_be_filled_in": made.lacks,
        "problem": made.problem,
        "notes": made.notes,
        "accepted": made.accepted,
    }


def _somebody_to_ask() -> "Ask | None":
    """Give what asks a question, on a terminal alone; Ctrl-C and the end of input stop the command."""
    if not (sys.stdin.isatty() and sys.stderr.isatty()):
        return None
    return _answer


def _answer(question: str) -> str:
    typer.echo(f"{question}: ", nl=False, err=True)  # stdout is for programs
    return input()


def _tell(made: "NewRun") -> None:
    for group in made.groups:
        say(f"{made.folder}: {group}: {group.rows} rows, {group.first.reader.title}")
    for note in made.notes:
        say(f"  note: {note}")
    for value in made.accepted:
        say(f"  accepted: {value}")
    if made.lacks:
        say(f"still to be filled in: {', '.join(made.lacks)}")
    if made.problem:
        say(f"still to be corrected: {made.problem}")
    if made.bodies_lack:
        say(f"friction alone is evaluated until run.toml describes the bodies: {', '.join(made.bodies_lack)}")
    first = f"see to that in {made.folder / 'run.toml'}, then " if made.lacks or made.problem else ""
    say(f"Next: {first}tribopipe process {made.folder}")


COMMANDS = {"new": new}
