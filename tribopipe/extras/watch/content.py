"""Which bytes a drop holds, and whether they are those of a run that is there."""

import hashlib
import shutil
from collections.abc import Iterable, Iterator
from contextlib import suppress
from itertools import chain, count
from pathlib import Path

from tribopipe.archive.store import Archive
from tribopipe.base.errors import ArchiveError
from tribopipe.base.files import sha256_of
from tribopipe.extras.watch.drops import Drop
from tribopipe.readers.draft.folder import fit_for_id

_ROOM = 90
"""Characters of an id, of the hundred it may have, before a number."""
_CHUNK = 1 << 20


def content_of(drop: Drop) -> str:
    """Return the SHA-256 of a file, or that of the checksums of several. Raises ``OSError``."""
    sums = sorted(map(sha256_of, drop.files))
    return sums[0] if len(sums) == 1 else hashlib.sha256("".join(sums).encode()).hexdigest()


def id_for(drop: Drop, runs: Path, archive: Archive, begun: str | None = None) -> str:
    """Return the id of the run that was begun of a drop, or else one made of its name that nothing else has."""
    name = fit_for_id(Path(drop.name).name)
    numbered: Iterator[str] = (f"{name[:_ROOM]}-{number}" for number in count(2))
    candidates = chain([begun] if begun else [], [name], numbered)
    return next(one for one in candidates if _is_free(one, drop, runs, archive))


def clear_begun(run_id: str, runs: Path) -> None:
    """Remove what a crash left of a run folder that was being made."""
    for part in runs.glob(f".{run_id}.????????.part"):
        shutil.rmtree(part, ignore_errors=True)


def goes_on(drop: Drop, run: Path) -> bool:
    """Return whether a drop holds all that a run folder was made of, and more after it."""
    now = {path.name: path for path in drop.files}
    with suppress(OSError):
        copies = [path for path in run.iterdir() if path.suffix != ".toml"]
        return bool(copies) and all(copy.name in now and _begins(copy, now[copy.name]) for copy in copies)
    return False


def _is_free(run_id: str, drop: Drop, runs: Path, archive: Archive) -> bool:
    """Return whether an id is nobody's, or that of a run which was made of the same bytes."""
    folder = runs / run_id
    if folder.exists():
        return _sums(drop.files) <= _sums(folder.iterdir())
    if not archive.path(run_id).exists():
        return True
    with suppress(ArchiveError):
        return _sums(drop.files) <= {source.sha256 for source in archive.outline(run_id).sources}
    return False


def _sums(paths: Iterable[Path]) -> set[str]:
    return {sha256_of(path) for path in paths if path.is_file()}


def _begins(copy: Path, export: Path) -> bool:
    """Return whether an export begins with all that a copy of it holds."""
    with copy.open("rb") as old, export.open("rb") as new:
        while part := old.read(_CHUNK):
            if new.read(len(part)) != part:
                return False
    return True
