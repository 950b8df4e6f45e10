"""Whether `process` has anything to do since its last pass, by the signatures of files alone, without reading them.

A pass that found every step and figure unchanged is kept in the archive folder with the signatures of all that it
read: the run folders, the recipe, the archive, its figures, and the program. While these are the same, the next one
would find the same. What is kept can be deleted at any time.
"""

import hashlib
import json
import os
import sysconfig
import time
from collections.abc import Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from tribopipe.archive.file_signature import FIGURES, Stamp, stamp_of, stamps

FILE_NAME = "processed.json"
_KEPT = 20
"""Passes kept per archive, each over other run folders or with another recipe."""
_PLUGINS = ("tribopipe.checks", "tribopipe.contacts", "tribopipe.laws", "tribopipe.readers")
_PACKAGE = Path(__file__).parents[1]
_NO_PYTHON = ("__pycache__", "browse")
"""What is in the package's folder and takes no part in processing."""


class Pass(NamedTuple):
    """What a pass is asked to do, and the state of all that it will read, before it begins."""

    asked: str
    """Run folders, recipe and figures wanted."""
    state: str
    """SHA-256 of the signatures of all files."""
    settled: bool
    """Whether any later change of a run folder would change the state."""


def state_before(paths: Sequence[Path], archive: Path, recipe: Path | None, *, figures: Sequence[str]) -> Pass:
    """Return what a pass over run folders at or below ``paths`` is asked to do, and the state it begins with.

    ``figures`` are the formats in which figures are drawn.
    """
    now = time.time_ns()
    read = [*paths, *([recipe] if recipe else [])]
    inputs = [seen for path in read for seen in _below(path.absolute(), archive.resolve())]
    stored = [*stamps(archive).items(), *(_below(archive / FIGURES) if figures else ())]
    files = [sorted(one, key=str) for one in (inputs, stored, _program())]
    asked = [[str(path.absolute()) for path in paths], recipe and str(recipe.absolute()), *figures]
    settled = all(stamp is not None and stamp.settled(now) for _, stamp in inputs)
    return Pass(json.dumps(asked), hashlib.sha256(repr(files).encode("utf-8", "replace")).hexdigest(), settled)


def steps_unchanged(archive: Path, now: Pass) -> int | None:
    """Return how many steps the last pass found unchanged, if it would find them so again; none if it must look."""
    match _kept(archive).get(now.asked):
        case {"state": now.state, "steps": int(steps)} if now.settled:
            return steps
    return None


def keep_pass(archive: Path, before: Pass, steps: int) -> None:
    """Keep that a pass found all its steps unchanged; nothing where a later change might go unseen."""
    from tribopipe.base.files import write_file
    from tribopipe.base.plugins import declared, is_own

    if not before.settled or not all(is_own(entry) for group in _PLUGINS for entry in declared(group)):
        return  # other packages' files are not looked at
    kept = _kept(archive)
    kept.pop(before.asked, None)
    kept[before.asked] = {"state": before.state, "steps": steps}
    newest = dict(list(kept.items())[-_KEPT:])
    with suppress(OSError):  # an archive that cannot be written is looked through each time
        write_file(archive / FILE_NAME, json.dumps(newest, indent=1).encode())


def _kept(archive: Path) -> dict[str, object]:
    try:
        found = json.loads((archive / FILE_NAME).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return found if isinstance(found, dict) else {}


def _below(path: Path, archive: Path | None = None) -> Iterator[tuple[str, Stamp | None]]:
    """Give the signature of a file, or of each file at or below a folder but the archive's; none of a linked folder."""
    try:
        if not path.is_dir():
            yield str(path), stamp_of(path.stat())
        elif path.resolve() != archive:
            with os.scandir(path) as entries:
                for entry in entries:
                    linked = entry.is_symlink() and entry.is_dir()
                    yield from ((entry.path, None),) if linked else _below(Path(entry.path), archive)
    except OSError:
        yield str(path), None


def _program() -> Iterator[tuple[str, Stamp | None]]:
    """Give the signatures of tribopipe's files, and of the folders that change where a package is installed."""
    for part in _PACKAGE.iterdir():
        if part.name not in _NO_PYTHON:
            yield from ((str(one), stamp_of(one.stat())) for one in part.rglob("*.py"))
    for folder in {Path(sysconfig.get_path(name)) for name in ("purelib", "platlib")}:
        if folder.is_dir():  # not where all packages are the user's own
            yield str(folder), stamp_of(folder.stat())
