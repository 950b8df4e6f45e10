"""An archive folder: runs by id, each a file that is only ever replaced whole."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Literal, TypeVar

import h5py

from tribopipe.archive.digest import raw_digest
from tribopipe.archive.nexus import text
from tribopipe.archive.outline import RunOutline, read_outline
from tribopipe.archive.runfile import (
    check_format,
    copy_additions,
    copy_except,
    read_annotations,
    read_cleaned,
    read_findings,
    read_fingerprints,
    read_manifest,
    read_marks,
    read_raw,
    read_result,
    read_step,
    write_annotations,
    write_marks,
    write_raw,
    write_step,
    write_wear_plot,
)
from tribopipe.archive.steps import STEPS, Fingerprints, Step, StepName, downstream
from tribopipe.archive.studyfile import (
    StoredStudy,
    StudyOutline,
    read_study,
    read_study_document,
    read_study_outline,
    write_study,
)
from tribopipe.errors import ArchiveError, did_you_mean
from tribopipe.files import natural_order, replacing
from tribopipe.records.annotation import Annotation, tags_after
from tribopipe.records.base import Record
from tribopipe.records.finding import Finding
from tribopipe.records.manifest import RunManifest
from tribopipe.records.mark import Mark
from tribopipe.run import RawRun

R = TypeVar("R", bound=Record)
SUFFIX = ".h5"
STUDIES = "studies"


class Archive:
    """The runs in a folder. Nothing is kept in memory: every call reads what is there."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def __repr__(self) -> str:
        return f"Archive({str(self.folder)!r}, {len(self.ids())} runs)"

    def ids(self) -> list[str]:
        """Return the ids of all runs, in natural order."""
        return _ids(self.folder)

    def path(self, run_id: str) -> Path:
        """Name the file of a run, whether or not it is there."""
        return self.folder / f"{run_id}{SUFFIX}"

    def add(
        self, run: RawRun, findings: Sequence[Finding] = (), *, force: bool = False
    ) -> Literal["added", "unchanged", "rewritten"]:
        """Archive a run as ingested.

        A run that is there already with the same content is left alone, or with ``force`` written anew beside its
        steps and marks. Raises ``ArchiveError`` where the id is taken by other content: what is raw is never replaced.
        """
        path = self.path(run.id)
        there = path.exists()
        if there and self.raw_sha256(run.id) != raw_digest(run):
            raise ArchiveError(
                f"{path}: found a run of the id {run.id!r} with other content; expected the same run or "
                "another id; change id in run.toml, or move the old file away if this run replaces it"
            )
        if there and not force:
            return "unchanged"
        with self._writing(path) as part, h5py.File(part, "w", track_order=True) as file:
            write_raw(file, run, findings)
            if there:
                with self.open(run.id) as old:
                    copy_additions(old, file["entry"])
                write_wear_plot(file["entry"])
        return "rewritten" if there else "added"

    def raw_sha256(self, run_id: str) -> str:
        """Return the fingerprint of a run's raw content."""
        with self.open(run_id) as file:
            return text(file, "entry/archived/raw_sha256")

    def raw(self, run_id: str) -> RawRun:
        """Return a run as ingested."""
        with self.open(run_id) as file:
            return read_raw(file)

    def cleaned(self, run_id: str) -> RawRun:
        """Return a run with its signals as they were cleaned up; as ingested where they were not."""
        with self.open(run_id) as file:
            return read_cleaned(file)

    def outline(self, run_id: str) -> RunOutline:
        """Return all that is known of a run but its columns and curves, which takes no longer for a long run."""
        with self.open(run_id) as file:
            return read_outline(file)

    def manifest(self, run_id: str) -> RunManifest:
        """Return a run's manifest."""
        with self.open(run_id) as file:
            return read_manifest(file)

    def result(self, run_id: str, name: StepName, record: type[R]) -> R | None:
        """Return the result of a step without its curves; none where the run has not been through it.

        Raises ``ArchiveError`` where it is no ``record``, but the result of another tribometer.
        """
        with self.open(run_id) as file:
            result = read_result(file["entry"], name)
        if result is None or isinstance(result, record):
            return result
        raise ArchiveError(
            f"{self.path(run_id)}: found a {name.replace('_', ' ')} of the kind {type(result).__name__}; expected "
            f"{record.__name__}; name a run on another tribometer"
        )

    def needed_result(self, run_id: str, name: StepName, record: type[R]) -> R:
        """Return the result of a step. Raises ``ArchiveError`` where the run has not been through it."""
        result = self.result(run_id, name, record)
        if result is None:
            raise ArchiveError(
                f"{self.path(run_id)}: found no {name.replace('_', ' ')}; expected the run to have been through it; do "
                "that step first, or `tribopipe process` the run"
            )
        return result

    def fingerprints(self, run_id: str, name: StepName) -> Fingerprints | None:
        """Return what a step was made from and what it found; none where the run has not been through it."""
        with self.open(run_id) as file:
            return read_fingerprints(file["entry"], name)

    def step(self, run_id: str, name: StepName) -> Step | None:
        """Return a step of a run; none where the run has not been through it."""
        with self.open(run_id) as file:
            return read_step(file["entry"], name)

    def steps(self, run_id: str) -> dict[StepName, Step]:
        """Return every step a run has been through, in order."""
        with self.open(run_id) as file:
            found = {name: read_step(file["entry"], name) for name in STEPS}
        return {name: step for name, step in found.items() if step is not None}

    def step_names(self, run_id: str) -> list[StepName]:
        """Return the names of the steps a run has been through, in order."""
        with self.open(run_id) as file:
            return [name for name in STEPS if name in file["entry"]]

    def findings(self, run_id: str) -> list[Finding]:
        """Return what the checks found when the run was ingested."""
        with self.open(run_id) as file:
            return read_findings(file["entry"])

    def put_step(self, run_id: str, step: Step) -> None:
        """Add a step or replace it; steps that stood on another result of it are dropped with it."""
        before = self.fingerprints(run_id, step.name)
        dropped: set[str] = {step.name}
        if bool(step.curves) if before is None else before.result != step.result_sha256:
            dropped |= downstream(step.name)
        self._rewrite(run_id, dropped, lambda entry: write_step(entry, step))

    @property
    def study_folder(self) -> Path:
        """Folder of the studies."""
        return self.folder / STUDIES

    def study_ids(self) -> list[str]:
        """Return the ids of all studies, in natural order."""
        return _ids(self.study_folder)

    def put_study(self, stored: StoredStudy) -> None:
        """Archive a study, in the place of an earlier one of its id."""
        path = self.study_folder / f"{stored.study.id}{SUFFIX}"
        with self._writing(path) as part, h5py.File(part, "w", track_order=True) as file:
            write_study(file, stored)

    def study(self, study_id: str) -> StoredStudy:
        """Return an archived study. Raises ``ArchiveError`` where there is none, or its file is damaged."""
        with self._open_study(study_id) as file:
            return read_study(file, file.filename)

    def study_outline(self, study_id: str) -> StudyOutline:
        """Return an archived study without its curves. Raises ``ArchiveError`` as ``study`` does."""
        with self._open_study(study_id) as file:
            return read_study_outline(file, file.filename)

    @contextmanager
    def _open_study(self, study_id: str) -> Iterator[h5py.File]:
        path = self.study_folder / f"{study_id}{SUFFIX}"
        if not path.is_file():
            raise ArchiveError(
                f"{self.folder}: found no study {study_id!r}; expected one of the archive's; "
                f"{did_you_mean(study_id, self.study_ids())}"
            )
        with opened(path) as file:
            yield file

    def studies_of(self, run_id: str) -> list[str]:
        """Return the ids of the studies that a run is part of; files that hold no study are passed over."""
        return [study_id for study_id in self.study_ids() if run_id in self._members(study_id)]

    def _members(self, study_id: str) -> tuple[str, ...]:
        try:
            with self._open_study(study_id) as file:
                study = read_study_document(file)
        except ArchiveError:
            return ()
        return (*study.fit, *study.predict)

    def marks(self, run_id: str) -> list[Mark]:
        """Return the history of a run's marks, oldest first; the last one counts."""
        with self.open(run_id) as file:
            return read_marks(file["entry"])

    def bad(self, run_id: str) -> Mark | None:
        """Return the mark by which a run counts as bad; none where it does not."""
        marks = self.marks(run_id)
        return marks[-1] if marks and marks[-1].kind == "bad" else None

    def mark(self, run_id: str, mark: Mark) -> None:
        """Add a mark to a run's history; all else that the run holds stays as it is.

        Raises ``ArchiveError`` for a mark that takes back what was not said: good, on a run not marked bad.
        """
        if mark.kind == "good" and self.bad(run_id) is None:
            raise ArchiveError(
                f"{self.path(run_id)}: found no bad mark to take back; expected a run that is marked bad; "
                "`tribopipe ls` shows which are"
            )
        marks = [*self.marks(run_id), mark]
        self._rewrite(run_id, {"marks"}, lambda entry: write_marks(entry, marks))

    def annotations(self, run_id: str) -> list[Annotation]:
        """Return the history of a run's tags and notes, oldest first."""
        with self.open(run_id) as file:
            return read_annotations(file["entry"])

    def tags(self, run_id: str) -> tuple[str, ...]:
        """Return the tags that a run has now."""
        return tags_after(self.annotations(run_id))

    def annotate(self, run_id: str, *added: Annotation) -> None:
        """Add tags and notes to a run's history; all else that the run holds stays as it is.

        Raises ``ArchiveError`` where a tag is taken back that the run has not.
        """
        history = self.annotations(run_id)
        for annotation in added:
            tags = tags_after(history)
            if annotation.kind == "untag" and annotation.text not in tags:
                raise ArchiveError(
                    f"{self.path(run_id)}: found no tag {annotation.text!r} to take back; expected one that the run "
                    f"has; {did_you_mean(annotation.text, tags)}"
                )
            history.append(annotation)
        self._rewrite(run_id, {"annotations"}, lambda entry: write_annotations(entry, history))

    @contextmanager
    def open(self, run_id: str) -> Iterator[h5py.File]:
        """Open a run's file for reading.

        Raises ``ArchiveError`` where there is none, it is no run, or what is read from it is damaged.
        """
        path = self.path(run_id)
        if not path.is_file():
            raise ArchiveError(
                f"{self.folder}: found no run {run_id!r}; expected one of the archive's; "
                f"{did_you_mean(run_id, self.ids())}"
            )
        with opened(path) as file:
            check_format(file, path)
            yield file

    def _rewrite(self, run_id: str, dropped: set[str], write: Callable[[h5py.Group], None]) -> None:
        """Replace a run's file by a copy without some members of its entry, and with what is written instead."""
        with self.open(run_id) as old, self._writing(self.path(run_id)) as part:
            with h5py.File(part, "w", track_order=True) as new:
                entry = copy_except(old, new, dropped)
                write(entry)
                write_wear_plot(entry)
            old.close()  # Windows replaces no open file

    @contextmanager
    def _writing(self, path: Path) -> Iterator[Path]:
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            with replacing(path) as part:
                yield part
        except OSError as error:
            raise ArchiveError(
                f"{self.folder}: cannot be written ({error.strerror or error}); expected a folder with "
                "room and write permission; choose another with --archive"
            ) from None


def _ids(folder: Path) -> list[str]:
    if not folder.is_dir():
        return []
    found = (path.name for path in folder.glob(f"*{SUFFIX}") if not path.name.startswith("."))
    return sorted((name.removesuffix(SUFFIX) for name in found), key=natural_order)


@contextmanager
def opened(path: Path) -> Iterator[h5py.File]:
    """Open a file for reading; ``ArchiveError`` where it, or what is read from it, is damaged."""
    try:
        file = h5py.File(path, "r", locking=False)
    except OSError:
        raise ArchiveError(
            f"{path}: found a file that is not HDF5, or is damaged; expected one archived by tribopipe; "
            "restore it from a copy, or move it out of the archive"
        ) from None
    with file:
        try:
            yield file
        except (KeyError, OSError, RuntimeError, ValueError) as error:
            why = str(error).splitlines()[0]
            raise ArchiveError(
                f"{path}: found a damaged file ({why}); expected what tribopipe wrote; restore it from a copy"
            ) from error


def open_archive(folder: Path | str = "archive") -> Archive:
    """Return the archive in a folder, which need not exist yet."""
    return Archive(Path(folder))
