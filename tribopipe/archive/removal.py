"""Runs and studies taken out of an archive on purpose: kept in a folder of it, and put back from there."""

from datetime import UTC, datetime
from pathlib import Path

from tribopipe.archive.file_access import check_adopted
from tribopipe.archive.file_signature import SUFFIX
from tribopipe.archive.formats import RUN_FORMAT, STUDY_FORMAT
from tribopipe.archive.history import announced
from tribopipe.archive.lock import writers_lock
from tribopipe.archive.run_files import refuse_other_case
from tribopipe.archive.seal import state_of
from tribopipe.archive.store import Archive
from tribopipe.base.errors import ArchiveError, did_you_mean
from tribopipe.base.files import move

REMOVED = "removed"
"""Folder of what was taken out: in it one for each time, with the files as they lay in the archive."""


def remove(archive: Archive, name: str, *, study: bool = False, force: bool = False, by: str | None = None) -> Path:
    """Remove a run or a study from an archive; return the path where it is kept.

    Raises ``ArchiveError`` where there is none of exactly that id, or a study names the run, but for ``force``; or
    where the archive cannot be written.
    """
    path = _path(archive, name, study=study)
    try:
        with writers_lock(archive.folder, name):
            if not path.is_file() or name not in _archived(archive, study=study):
                raise _unknown(archive, name, study=study)
            naming = () if study or force else archive.studies_of(name)
            if naming:
                raise ArchiveError(
                    f"{path}: found a run that belongs to the study {', '.join(naming)}; expected a run that is not "
                    "part of a study; remove the study first with --study, or use --force"
                )
            kept = _free(archive, path)
            with announced(archive.folder, path, "removed", state_of(path), None, by):
                move(path, kept)
    except OSError as error:
        raise _not_written(archive, error) from None
    return kept


def restore(archive: Archive, name: str, *, study: bool = False, by: str | None = None) -> Path:
    """Restore the last removed run or study with an id; return its path.

    Raises ``ArchiveError`` where none of that id was removed, another one is there by now, or the removed one is
    damaged; or where the archive cannot be written.
    """
    path = _path(archive, name, study=study)
    try:
        with writers_lock(archive.folder, name):
            kept = _last(archive, path)
            if kept is None or name not in removed_ids(archive, study=study):
                raise _unknown(archive, name, study=study, removed=True)
            if path.exists():
                raise ArchiveError(
                    f"{path}: found an existing file; expected no file with this ID, since files are never "
                    "overwritten; remove the existing file first"
                )
            check_adopted(kept, path, STUDY_FORMAT if study else RUN_FORMAT)
            with announced(archive.folder, path, "restored", None, state_of(kept), by):
                move(kept, path)
    except OSError as error:
        raise _not_written(archive, error) from None
    return path


def removed_ids(archive: Archive, *, study: bool = False) -> list[str]:
    """Return the ids of the runs or studies that can be restored."""
    inside = _path(archive, "*", study=study).relative_to(archive.folder)
    return sorted({kept.stem for kept in (archive.folder / REMOVED).glob(f"*/{inside.as_posix()}")})


def _path(archive: Archive, name: str, *, study: bool) -> Path:
    return archive.study_folder / f"{name}{SUFFIX}" if study else archive.path(name)


def _archived(archive: Archive, *, study: bool) -> list[str]:
    """Return the ids as the folder lists them: Windows and macOS open a file by its name in any letter case."""
    return archive.study_ids() if study else archive.ids()


def _free(archive: Archive, path: Path) -> Path:
    """Return a place that is not taken for a file to be removed now."""
    day = f"{datetime.now(UTC):%Y-%m-%dT%H-%M-%SZ}"
    inside, count = path.relative_to(archive.folder), 1
    while (kept := archive.folder / REMOVED / (day if count == 1 else f"{day}-{count}") / inside).exists():
        count += 1
    return kept


def _last(archive: Archive, path: Path) -> Path | None:
    """Return where the file is that was removed last of those that were in a place."""
    inside = path.relative_to(archive.folder)
    times = sorted((archive.folder / REMOVED).glob("*"), reverse=True)
    return next((kept for time in times if (kept := time / inside).is_file()), None)


def _unknown(archive: Archive, name: str, *, study: bool, removed: bool = False) -> ArchiveError:
    kind = "study" if study else "run"
    if removed:
        known = removed_ids(archive, study=study)
        where, one = (
            f"{archive.folder / REMOVED}: ",
            f"the ID of a {kind} removed with `tribopipe remove`{'' if study else ', or --study for a study'}",
        )
    else:
        known = _archived(archive, study=study)
        where, one = f"{archive.folder}: ", f"the ID of an archived {kind}{'' if study else ', or --study for a study'}"
    refuse_other_case(where, kind, name, known)
    return ArchiveError(f"{where}found no {kind} {name!r}; expected {one}; {did_you_mean(name, known)}")


def _not_written(archive: Archive, error: OSError) -> ArchiveError:
    return ArchiveError(
        f"{archive.folder}: cannot be written ({error.strerror or error}); expected an archive folder with write "
        "permission; check its permissions, and run the command again"
    )
