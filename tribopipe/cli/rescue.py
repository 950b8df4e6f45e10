"""The command that saves source files from damaged files of an archive: rescue."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from tribopipe.cli.options import AsJson
from tribopipe.cli.output import exit_with, print_json, progress, say, seen

if TYPE_CHECKING:
    from tribopipe.archive.rescue import Rescued
    from tribopipe.base.errors import TribopipeError

Files = Annotated[list[Path], typer.Argument(help="Files of archived runs.", metavar="FILE")]
Into = Annotated[Path, typer.Option("--to", help="Folder to write run folders into.")]


def rescue(files: Files, into: Into, as_json: AsJson = False) -> None:
    """Save the source files inside damaged files of an archive.

    Each that is whole goes into a run folder.
    The damaged files are only read. What was computed from a run is computed again by `tribopipe process`; marks, tags
    and notes are not in the source files.
    """
    from tribopipe.archive.rescue import rescue as save
    from tribopipe.base.failures import in_a_sentence
    from tribopipe.pipeline.output_paths import require_folder

    require_folder(into)
    saved: dict[Path, Rescued] = {}
    errors: dict[Path, TribopipeError] = {}
    with progress("rescue", len(files)) as advance:
        for path in dict.fromkeys(files):
            try:
                saved[path] = save(path, into)
            except Exception as error:  # noqa: BLE001 - the others go on, whatever it is
                errors[path] = in_a_sentence(error, str(path))
            advance(path.stem)
    for path, found in saved.items():
        say(f"{path}: {len(found.whole)} source files saved in {found.folder}")
        if found.damaged or not found.listed:
            errors[path] = _lacking(path, found)
    if as_json:
        print_json({"runs": [_document(path, saved.get(path), errors.get(path)) for path in dict.fromkeys(files)]})
    if saved:
        say(f"Next: move the damaged files out of the archive, then `tribopipe process {into}` into it again.")
    exit_with([errors[path] for path in dict.fromkeys(files) if path in errors], some_done=bool(saved))


def _lacking(path: Path, found: "Rescued") -> "TribopipeError":
    from tribopipe.base.errors import ArchiveError

    if not found.listed:
        lacking = "the list of its source files damaged"
        mend = f"compare the files in {found.folder} with those named in its run.toml, and copy the missing ones"
    else:
        lacking = f"{', '.join(map(seen, found.damaged))} damaged in it"
        mend = f"copy the missing ones into {found.folder}"
    return ArchiveError(f"{path}: found {lacking}; expected every source file whole; {mend} from the instrument")


def _document(path: Path, found: "Rescued | None", error: Exception | None) -> dict[str, Any]:
    return {
        "file": str(path),
        "folder": None if found is None else str(found.folder),
        "saved": [] if found is None else list(found.whole),
        "damaged": [] if found is None else list(found.damaged),
        "listed": found is not None and found.listed,
        "error": None if error is None else str(error),
    }
