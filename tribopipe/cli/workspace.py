"""What lies in and below a folder: run folders, studies, exports, and how far the archive next to them has got."""

import os
from collections import deque
from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from tribopipe.cli.options import RUN_TOML

if TYPE_CHECKING:
    from tribopipe.archive.catalog.listed import ListedRun

_OF_INSTRUMENTS = {".asc", ".csv", ".dat", ".dwf", ".lvm", ".tdms", ".tsv", ".txt", ".xls", ".xlsx"}
"""How names of exports end; their readers identify the content."""
_LEVELS, _MOST_ENTRIES = 2, 20_000
"""How deep is looked, and at how much: nobody waits for a home folder to be walked through."""


@dataclass
class Whereabouts:
    """What was found."""

    runs: dict[Path, str] = field(default_factory=dict)
    """SHA-256 of the run.toml in each run folder."""
    studies: list[Path] = field(default_factory=list)
    exports: list[Path] = field(default_factory=list)
    """Files outside of run folders that are called as instruments call what they export."""
    archived: "list[ListedRun]" = field(default_factory=list)
    studied: set[str] = field(default_factory=set)
    """Ids of the studies in the archive."""
    unreadable: dict[str, str] = field(default_factory=dict)
    """Why files of the archive cannot be read, and what to do, by the ids in their names."""

    def folder_of(self, run: "ListedRun") -> Path | None:
        """Return the folder of an archived run: the one with its run.toml, or that is called as the run is."""
        same = (path for path, sha256 in self.runs.items() if sha256 == run.text("run_toml"))
        called = (path for path in self.runs if path.name == run.id)
        return next(same, None) or next(called, None)


def look_around(folder: Path, archive: Path) -> Whereabouts:
    """Look at a folder, and at the catalog of an archive if there is one."""
    from tribopipe.base.files import sha256_of

    found = Whereabouts()
    for files in _below(folder, archive):
        manifest = next((path for path in files if path.name == RUN_TOML), None)
        if manifest is not None:
            with suppress(OSError):
                found.runs[manifest.parent] = sha256_of(manifest)
        else:
            found.exports += [path for path in files if path.suffix.lower() in _OF_INSTRUMENTS]
        found.studies += [path for path in files if path.name == "study.toml" or path.name.endswith(".study.toml")]
    if archive.is_dir():
        _look_into(archive, found)
    return found


def _look_into(archive: Path, found: Whereabouts) -> None:
    from tribopipe.archive.file_signature import STUDIES, SUFFIX
    from tribopipe.cli.listing import up_to_date

    catalogue = up_to_date(archive)
    found.archived = catalogue.runs()
    found.unreadable = {Path(name).stem: error for name, error in catalogue.unreadable}
    found.studied = {path.stem for path in (archive / STUDIES).glob(f"*{SUFFIX}")}


def _below(folder: Path, archive: Path) -> Iterator[list[Path]]:
    """Give the files in a folder, and in each a little below; nothing below a run folder, and nothing hidden."""
    left, room = deque([(folder, 0)]), _MOST_ENTRIES
    while left and room > 0:
        here, level = left.popleft()
        files, folders = _in(here)
        room -= len(files) + len(folders)
        yield files
        if level < _LEVELS and not any(path.name == RUN_TOML for path in files):
            left += [(path, level + 1) for path in folders if path != archive]


def _in(folder: Path) -> tuple[list[Path], list[Path]]:
    """Return the visible files and folders in a folder, sorted by name; none if it cannot be read."""
    try:
        with os.scandir(folder) as entries:
            seen = [entry for entry in entries if not entry.name.startswith(".")]
            folders = {entry.path for entry in seen if entry.is_dir(follow_symlinks=False)}
    except OSError:
        return [], []
    paths = sorted(entry.path for entry in seen)
    return [Path(path) for path in paths if path not in folders], [Path(path) for path in paths if path in folders]


def ids_in(documents: Iterable[Path]) -> dict[Path, str]:
    """Return the id of each document; documents that cannot be read are skipped."""
    import tomllib

    from tribopipe.base.files import read_file

    said = {}
    for path in documents:
        with suppress(OSError, ValueError, LookupError):
            said[path] = str(tomllib.loads(read_file(path).decode("utf-8"))["id"])
    return said
