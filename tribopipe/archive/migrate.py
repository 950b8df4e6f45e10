"""Archived files of older formats brought to the present one, the original kept."""

import hashlib
from collections.abc import Collection, Mapping
from contextlib import ExitStack
from filecmp import cmp
from io import BytesIO
from pathlib import Path
from shutil import copyfile
from typing import NamedTuple

import h5py
import numpy as np

from tribopipe.archive.formats import RUN_FORMAT, STUDY_FORMAT, Format, check_format, format_of
from tribopipe.archive.history.chain import placed
from tribopipe.archive.lock import writers_lock
from tribopipe.archive.migrations import MIGRATIONS
from tribopipe.archive.opening import of_any_format, opened
from tribopipe.archive.seal import SEAL_SIZE, seal
from tribopipe.archive.store import SUFFIX, Archive
from tribopipe.archive.unpack import unpacked
from tribopipe.base.errors import ArchiveError, did_you_mean
from tribopipe.base.files import replacing


class Migrated(NamedTuple):
    """A file of the archive in the present format."""

    before: Format
    after: Format
    kept: Path | None
    """Where the original is; none where the file was of the present format already."""


def files_of(archive: Archive, ids: Collection[str] = ()) -> list[Path]:
    """Return the files of the runs and studies of these ids, or all. Raises ``ArchiveError`` for an unknown id."""
    files = [archive.path(run_id) for run_id in archive.ids()]
    files += [archive.study_folder / f"{study_id}{SUFFIX}" for study_id in archive.study_ids()]
    known = {path.stem for path in files}
    unknown = next((wanted for wanted in ids if wanted not in known), None)
    if unknown is not None:
        raise ArchiveError(
            f"{archive.folder}: found no run and no study {unknown!r}; expected one of the archive's; "
            f"{did_you_mean(unknown, known)}"
        )
    return [path for path in files if not ids or path.stem in ids]


def migrate(archive: Archive, path: Path) -> Migrated:
    """Bring a file of the archive to the present format, unless it is of that already.

    The original is kept in a folder of the archive. Wherever this is interrupted, the file is there in one format or
    the other, and the next call goes on.

    Raises ``ArchiveError`` where the file is damaged, of no known format, or of one to come; or cannot be written.
    """
    try:
        with writers_lock(archive.folder, path.stem):
            return _migrate(archive, path)
    except OSError as error:
        raise ArchiveError(
            f"{path}: cannot be brought to the present format ({error.strerror or error}); expected an archive folder "
            "with write permission, and room for the file twice more; the file is as it was; see to that, and run this "
            "again"
        ) from None


def _migrate(archive: Archive, path: Path) -> Migrated:
    present = STUDY_FORMAT if path.parent == archive.study_folder else RUN_FORMAT
    with of_any_format(path) as old:
        before = format_of(old)
        if before is None or before.kind != present.kind or before.version not in MIGRATIONS[present.kind]:
            return _as_it_is(path, present)
        image, changed = _brought_up(old, before, present)
        content = content_of(old)
    with placed(archive.folder, path, "migrated") as part:
        with image.getbuffer() as whole:
            part.write_bytes(whole)
        _check(part, present, content, changed)
        kept = _keep(archive, path, present)
    return Migrated(before, present, kept)


def _as_it_is(path: Path, present: Format) -> Migrated:
    """Say that a file is of the present format. Raises ``ArchiveError`` where it is not, or is damaged."""
    with opened(path) as file:
        check_format(file, path, present)
    return Migrated(present, present, None)


def _brought_up(old: h5py.File, before: Format, present: Format) -> tuple[BytesIO, set[str]]:
    """Return a file of the present format, sealed, and the paths of all that is not as it was."""
    changed: set[str] = set()
    image = BytesIO()
    with ExitStack() as between:
        for version in range(before.version, present.version):
            image = BytesIO()
            with h5py.File(image, "w", track_order=True, userblock_size=SEAL_SIZE) as new:
                changed |= MIGRATIONS[present.kind][version](old, new)
            old = between.enter_context(h5py.File(image, "r"))
    with image.getbuffer() as whole:
        seal(whole)
    return image, changed


def _check(part: Path, present: Format, before: Mapping[str, str], changed: Collection[str]) -> None:
    """Read a file back from the disk. Raises ``ArchiveError`` where anything is lost or altered that should not be."""
    with opened(part) as file:
        check_format(file, part, present)
        after = content_of(file)
    different = [path for path in before.keys() | after.keys() if before.get(path) != after.get(path)]
    wrong = sorted(path for path in different if not any(f"{path}/".startswith(f"{top}/") for top in changed))
    if wrong:
        raise ArchiveError(
            f"{part}: found {', '.join(wrong[:3])} other than in the file it was made from; expected all as it was; "
            "nothing was changed; tell those who develop tribopipe"
        )


def _keep(archive: Archive, path: Path, present: Format) -> Path:
    """Copy a file into the folder of originals. Raises ``ArchiveError`` where another one of its name is there."""
    kept = archive.folder / f"before-format-{present.version}" / path.relative_to(archive.folder)
    if not kept.exists():
        kept.parent.mkdir(parents=True, exist_ok=True)
        with replacing(kept) as part:
            copyfile(path, part)
    elif not cmp(path, kept, shallow=False):
        raise ArchiveError(
            f"{kept}: found another file there than the original to be kept; expected none of that name; move it away, "
            "and run this again"
        )
    return kept


def content_of(file: h5py.File) -> dict[str, str]:
    """Return a fingerprint of each group, dataset and link of a file, attributes included, by its path."""
    found = {"/": _fingerprint(file)}

    def visit(path: str, link: h5py.HardLink | h5py.SoftLink) -> None:
        found[path] = _fingerprint(file[path]) if isinstance(link, h5py.HardLink) else f"link to {link.path}"

    file.visititems_links(visit)
    return found


def _fingerprint(part: h5py.Group | h5py.Dataset) -> str:
    values = [(name, np.asarray(part.attrs[name])) for name in sorted(part.attrs)]
    if isinstance(part, h5py.Dataset):
        values.append(("", unpacked(part)))
    hashed = hashlib.sha256()
    for name, array in values:
        hashed.update(f"{name} {array.dtype.str}{array.shape} ".encode())
        hashed.update(repr(array.tolist()).encode() if array.dtype.hasobject else array.tobytes())
    return hashed.hexdigest()
