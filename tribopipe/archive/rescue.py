"""Source files saved from a damaged archived run: each has its SHA-256 next to it, by which what is whole is known."""

import json
from collections.abc import Sequence
from functools import partial
from pathlib import Path, PurePath
from shutil import rmtree
from tempfile import TemporaryDirectory
from typing import NamedTuple

from pydantic import TypeAdapter, ValidationError

from tribopipe.base.errors import ArchiveError
from tribopipe.base.files import move, stored_size, write_file
from tribopipe.base.process_lifecycle import undone_by
from tribopipe.documents.manifest import FileName
from tribopipe.readers.subprocess_readers import answer_about
from tribopipe.results.run import SourceFile

_REMEDY = "nothing can be saved from this file; restore it from a backup, or ingest the instrument files again"
_FILE_NAME: TypeAdapter[str] = TypeAdapter(FileName)


class Rescued(NamedTuple):
    """What was saved from one file."""

    folder: Path
    """The run folder it is in."""
    whole: tuple[str, ...]
    """Names of the source files in it."""
    damaged: tuple[str, ...]
    """Names of those that are not, as far as they can be read."""
    listed: bool
    """Whether these are all; where their list is damaged, some may have been overlooked."""


def rescue(path: Path, into: Path) -> Rescued:
    """Write the intact source files of an archived run to a run folder named after the file.

    The archived file is only read. Raises ``TribopipeError`` where it cannot be opened any more, no source is whole,
    or the run folder is there already or cannot be written.
    """
    folder = into / path.stem
    if folder.exists():
        raise ArchiveError(
            f"{folder}: found an existing folder; expected a new folder, since existing files are never overwritten; "
            "specify another with --to"
        )
    whole, damaged, listed = _sources(path)
    if not whole:
        raise ArchiveError(f"{path}: found no intact source file; expected an archived run; {_REMEDY}")
    try:
        _write(whole, folder)
    except OSError as error:
        raise ArchiveError(
            f"{folder}: cannot be written ({error.strerror or error}); expected a folder with free space and "
            "write permission; specify another with --to"
        ) from None
    return Rescued(folder, tuple(source.name for source in whole), damaged, listed)


def _write(sources: Sequence[SourceFile], folder: Path) -> None:
    """Write a run folder whole or not at all."""
    folder.parent.mkdir(parents=True, exist_ok=True)
    beside = TemporaryDirectory(prefix=f".{folder.name}.", suffix=".part", dir=folder.parent)
    with beside as part, undone_by(partial(rmtree, part, ignore_errors=True)):
        made = Path(part) / folder.name
        made.mkdir()
        for source in sources:
            (made / source.name).parent.mkdir(parents=True, exist_ok=True)
            write_file(made / source.name, source.content)
        move(made, folder)


def _sources(path: Path) -> tuple[list[SourceFile], tuple[str, ...], bool]:
    """Return the intact source files, the names of the damaged ones, and whether this list is complete."""
    try:
        size = stored_size(path)
    except OSError as error:
        raise ArchiveError(
            f"{path}: cannot be read ({error.strerror or error}); expected the file of an archived run; check its name "
            "and permissions"
        ) from None
    line, _, contents = answer_about("archived_sources.py", path, size, remedy=_REMEDY).partition(b"\n")
    found = json.loads(line)
    whole: dict[str, SourceFile] = {}
    damaged: list[str] = []
    start = 0
    for said in found["sources"]:
        source = SourceFile(said["name"], contents[start : start + said["size"]])
        start += said["size"]
        sound = said["problem"] is None and source.sha256 == said["sha256"]
        if sound and _stays_inside(source.name) and source.name.casefold() not in whole:
            whole[source.name.casefold()] = source
        else:
            damaged.append(source.name)
    return list(whole.values()), tuple(damaged), found["listed"]


def _stays_inside(name: str) -> bool:
    """Return whether a file of a name lies in the folder that it is written into."""
    try:
        _FILE_NAME.validate_python(name)
    except ValidationError:
        return False
    return PurePath(name).name != ""
