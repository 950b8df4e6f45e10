"""The files of an archive: runs and studies by id, each in one file that is only replaced as a unit."""

import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import Literal, NoReturn, TypeVar

import h5py

from tribopipe.archive.earlier_manifests import EarlierManifest, add_earlier, changed_file, read_earlier
from tribopipe.archive.file_access import check_adopted, opened, written
from tribopipe.archive.file_signature import FIGURES, STUDIES, SUFFIX, stamp_of
from tribopipe.archive.formats import RUN_FORMAT, STUDY_FORMAT, check_format
from tribopipe.archive.hdf5_guard import renamed
from tribopipe.archive.history import placed
from tribopipe.archive.lock import writers_lock
from tribopipe.archive.nexus import text
from tribopipe.archive.outline import RunOutline, read_outline
from tribopipe.archive.provenance import raw_digest
from tribopipe.archive.remote import RemotePath, archive_path, names_in, refuse_writing, studies_with
from tribopipe.archive.runfile import (
    MANIFEST_TEXT,
    copy_additions,
    copy_except,
    dropped_by,
    read_annotations,
    read_cleaned,
    read_environment,
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
from tribopipe.archive.seal import SEAL_SIZE, know, seal_file
from tribopipe.archive.step_names import STEPS, Fingerprints, Step, StepName, step_in_words, steps_among
from tribopipe.archive.studyfile import (
    StoredStudy,
    StudyOutline,
    read_study,
    read_study_document,
    read_study_outline,
    write_study,
)
from tribopipe.base.errors import ArchiveError, did_you_mean
from tribopipe.base.failures import number_of
from tribopipe.base.files import drive_of, is_old, leftovers, natural_order, sha256_of
from tribopipe.documents.annotation import Annotation, Mark, tags_after
from tribopipe.documents.manifest import RunManifest
from tribopipe.documents.record import Record
from tribopipe.results.finding import Finding
from tribopipe.results.run import RawRun

T = TypeVar("T")
R = TypeVar("R", bound=Record)
_NO_DRIVE = -1
_IDENTIFIERS = {"run": "entry/identifier_run", "study": "entry/identifier_study"}
"""Where a file has its ID."""


class RunFiles:
    """The files of the runs and studies in a folder. Every call reads them; nothing is kept in memory."""

    def __init__(self, folder: Path | str) -> None:
        self.folder = archive_path(folder)
        self._drive = drive_of(self.folder)
        self._is_tidy = False

    def __getstate__(self) -> tuple[Path, bool]:
        return self.folder, self._drive is not None

    def __setstate__(self, state: tuple[Path, bool]) -> None:
        """Be the archive as another process has it, or another machine, where its drive has another number.

        One that was there and is not there counts as gone, so that it is not made again where the folder is not shared.
        """
        self.folder, was_there = state
        there = drive_of(self.folder)
        self._drive = _NO_DRIVE if there is None and was_there else there
        self._is_tidy = False

    def ids(self) -> list[str]:
        """Return the ids of all runs, in natural order."""
        return _ids(self.folder)

    def __contains__(self, run_id: object) -> bool:
        return isinstance(run_id, str) and run_id in self.ids()

    def __iter__(self) -> Iterator[str]:
        return iter(self.ids())

    def __len__(self) -> int:
        return len(self.ids())

    def __bool__(self) -> bool:
        """Be true, empty or not: an archive is a place."""
        return True

    def keys(self) -> list[str]:
        """Return the ids of all runs, as ``ids`` does."""
        return self.ids()

    def path(self, run_id: str) -> Path:
        """Return the path of a run's file, whether or not it exists."""
        return self.folder / f"{run_id}{SUFFIX}"

    def add(
        self, run: RawRun, findings: Sequence[Finding] = (), *, force: bool = False, amend: bool = False
    ) -> Literal["added", "unchanged", "rewritten", "amended"]:
        """Archive a run as ingested.

        A run that is there already with the same content is left alone, or with ``force`` written again with its
        steps and marks. With ``amend`` one with another run.toml takes its place with its marks, and the earlier
        run.toml is kept. Raises ``ArchiveError`` where the id is taken by other content: what the instrument wrote is
        never replaced.
        """
        path = self.path(run.id)
        if path.exists() and not self._is_other(run, amend=amend) and not force:
            return "unchanged"
        with self._writing(path) as file:
            there = path.exists()  # now that no other process can put it there
            amended = there and self._is_other(run, amend=amend)
            write_raw(file, run, findings)
            if there:
                with self.open(run.id) as old:
                    copy_additions(old, file["entry"], steps=not amended)
                    if amended:
                        add_earlier(old["entry"], file["entry"], datetime.now(UTC).isoformat(timespec="seconds"))
                write_wear_plot(file["entry"])
        return "amended" if amended else "rewritten" if there else "added"

    def _is_other(self, run: RawRun, *, amend: bool) -> bool:
        """Return whether run.toml differs from the archived one. Raises ``ArchiveError`` for forbidden changes."""
        with self.open(run.id) as file:
            if text(file, "entry/archived/raw_sha256") == raw_digest(run):
                return False
            changed = changed_file(file["entry"], run)
        found = f"{self.path(run.id)}: found a run with the ID {run.id!r} but different content"
        if changed is not None:
            raise ArchiveError(
                f"{found}: {changed} has changed; expected unchanged instrument files or another ID; change id in "
                "run.toml, or move the archived file away if this run replaces it"
            )
        if not amend:
            raise ArchiveError(
                f"{found}, although the instrument files are the same; expected the archived run.toml or another ID; "
                "use --amend to replace run.toml and keep the earlier version"
            )
        return True

    def earlier_manifests(self, run_id: str) -> list[EarlierManifest]:
        """Return each run.toml that a run had before it was amended, oldest first."""
        return self._read(run_id, read_earlier)

    def raw_sha256(self, run_id: str) -> str:
        """Return the fingerprint of a run's raw content."""
        return self._read(run_id, partial(text, path="archived/raw_sha256"))

    def environment(self, run_id: str) -> dict[str, str]:
        """Return the versions and the machine with which a run was ingested; empty if its file does not state them."""
        return self._read(run_id, read_environment)

    def raw(self, run_id: str) -> RawRun:
        """Return a run as ingested."""
        with self.open(run_id) as file:
            return read_raw(file)

    def cleaned(self, run_id: str) -> RawRun:
        """Return a run with its preprocessed signals, else as ingested."""
        with self.open(run_id) as file:
            return read_cleaned(file)

    def outline(self, run_id: str) -> RunOutline:
        """Return everything about a run except columns and curves, in a time that is independent of its length."""
        with self.open(run_id) as file:
            return read_outline(file)

    def manifest(self, run_id: str) -> RunManifest:
        """Return a run's manifest; nothing else of its file is looked at."""
        with self.open(run_id, [MANIFEST_TEXT]) as file:
            return read_manifest(file)

    def result(self, run_id: str, name: StepName, record: type[R]) -> R | None:
        """Return the result of a step without its curves; none where the run has not been through it.

        Raises ``ArchiveError`` where it is no ``record``, but the result of another tribometer.
        """
        result = self._read(run_id, partial(read_result, name=name))
        if result is None or isinstance(result, record):
            return result
        raise ArchiveError(
            f"{self.path(run_id)}: found {type(result).__name__} as the result of {step_in_words(name)}; expected "
            f"{record.__name__}; specify a run from another type of tribometer"
        )

    def needed_result(self, run_id: str, name: StepName, record: type[R]) -> R:
        """Return the result of a step. Raises ``ArchiveError`` where the run has not been through it."""
        result = self.result(run_id, name, record)
        if result is None:
            raise ArchiveError(
                f"{self.path(run_id)}: found no {step_in_words(name)}; expected a run with this result; run this "
                "step first, or run `tribopipe process`"
            )
        return result

    def fingerprints(self, run_id: str, name: StepName) -> Fingerprints | None:
        """Return the fingerprints of inputs and result of a step; none if the run does not have the step."""
        return self._read(run_id, partial(read_fingerprints, name=name))

    def stands_on(self, run_id: str, name: StepName) -> dict[str, str]:
        """Return fingerprints of what a step is made from: "raw", and the steps before it, empty for one not done."""
        with self.open(run_id) as file:
            before = {base: read_fingerprints(file["entry"], base) for base in STEPS[name].stands_on}
            raw = text(file, "entry/archived/raw_sha256")
        return {"raw": raw, **{base: "" if there is None else there.result for base, there in before.items()}}

    def step(self, run_id: str, name: StepName) -> Step | None:
        """Return a step of a run; none where the run has not been through it."""
        return self._read(run_id, partial(read_step, name=name))

    def steps(self, run_id: str) -> dict[StepName, Step]:
        """Return every step a run has been through, in order."""
        with self.open(run_id) as file:
            found = {name: read_step(file["entry"], name) for name in steps_among(file["entry"])}
        return {name: step for name, step in found.items() if step is not None}

    def step_names(self, run_id: str) -> list[StepName]:
        """Return the names of the steps a run has been through, in order."""
        return self._read(run_id, steps_among)

    def findings(self, run_id: str) -> list[Finding]:
        """Return what the checks found when the run was ingested."""
        return self._read(run_id, read_findings)

    def put_step(self, run_id: str, step: Step) -> None:
        """Add a step or replace it; steps that stood on another result of it are dropped with it.

        Raises ``ArchiveError`` where the step was made from a result that is another one by now.
        """
        self.put_steps(run_id, [step])

    def put_steps(self, run_id: str, steps: Sequence[Step], written: h5py.Group | None = None) -> None:
        """Add or replace steps as ``put_step`` does, each after those that it stands on, and write the file once.

        They are copied from ``written``, an entry that holds them already, where there is one.
        """
        with self._rewriting(run_id) as (old, new):
            entry = copy_except(old, new, {name for step in steps for name in dropped_by(step, old["entry"])})
            for step in steps:
                self._refuse_stale(run_id, step, entry)
                if written is None:
                    write_step(entry, step)
                else:
                    written.copy(step.name, entry)
            if "wear" not in entry:
                write_wear_plot(entry)

    def _refuse_stale(self, run_id: str, step: Step, entry: h5py.Group) -> None:
        for base in STEPS[step.name].stands_on:
            there = read_fingerprints(entry, base)
            if base in step.stands_on and step.stands_on[base] != ("" if there is None else there.result):
                made, other = step_in_words(step.name), step_in_words(base)
                raise ArchiveError(
                    f"{self.path(run_id)}: found that another tribopipe process has changed the {other} since the "
                    f"{made} was computed; expected one process at a time; run the command again"
                )

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
        if path.is_file() and stored.study.id not in (known := self.study_ids()):
            refuse_other_case(f"{self.folder}: ", "study", stored.study.id, known)
        with self._writing(path) as file:
            write_study(file, stored)

    def adopt(
        self, identifier: str, content: Iterable[bytes], sha256: str, *, study: bool = False
    ) -> Literal["added", "unchanged"]:
        """Take in a run or a study as another archive holds it, byte for byte; the same one is left alone.

        Raises ``ArchiveError`` where it is damaged or not what it is called, or another file has its name.
        """
        folder, form = (self.study_folder, STUDY_FORMAT) if study else (self.folder, RUN_FORMAT)
        path = folder / f"{identifier}{SUFFIX}"
        with self._held(path):
            if path.is_file() and sha256_of(path) == sha256:
                return "unchanged"
            if os.path.lexists(path):
                raise ArchiveError(
                    f"{path}: found a different file with this name; expected the same file or no file; "
                    "move the existing file away, or choose another archive with --archive"
                )
            try:
                with placed(self.folder, path, "imported") as part:
                    with part.open("wb") as file:
                        file.writelines(content)
                    check_adopted(part, path, form)
            except OSError as error:
                self._refuse(error)
        return "added"

    def study(self, study_id: str) -> StoredStudy:
        """Return an archived study. Raises ``ArchiveError`` where there is none, or its file is damaged."""
        with self._open_study(study_id) as file:
            return read_study(file)

    def study_outline(self, study_id: str) -> StudyOutline:
        """Return an archived study without its curves. Raises ``ArchiveError`` as ``study`` does."""
        with self._open_study(study_id) as file:
            return read_study_outline(file)

    @contextmanager
    def _open_study(self, study_id: str) -> Iterator[h5py.File]:
        path = self.study_folder / f"{study_id}{SUFFIX}"
        if not path.is_file():
            _refuse_odd(path)
            raise ArchiveError(
                f"{self.folder}: found no study {study_id!r}; expected the ID of an archived study; "
                f"{did_you_mean(study_id, self.study_ids())}"
            )
        with opened(path) as file:
            check_format(file, path, STUDY_FORMAT)
            self._refuse_other_case(file, "study", study_id)
            yield file

    def studies_of(self, run_id: str) -> list[str]:
        """Return the ids of the studies that a run is part of; files that hold no study are passed over."""
        if isinstance(self.folder, RemotePath):
            return sorted(studies_with(self.folder, run_id), key=natural_order)
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
        return self._read(run_id, read_marks)

    def bad(self, run_id: str) -> Mark | None:
        """Return the mark by which a run counts as bad; none where it does not."""
        marks = self.marks(run_id)
        return marks[-1] if marks and marks[-1].kind == "bad" else None

    def mark(self, run_id: str, mark: Mark) -> None:
        """Add a mark to a run's history; all else that the run holds stays as it is.

        Raises ``ArchiveError`` for a mark that takes back what was not stated: good, on a run not marked bad.
        """
        with self._rewriting(run_id) as (old, new):
            marks = read_marks(old["entry"])
            if mark.kind == "good" and (not marks or marks[-1].kind != "bad"):
                raise ArchiveError(
                    f"{self.path(run_id)}: found a run that is not marked as bad; expected a run marked as bad; "
                    "`tribopipe ls` shows which runs are marked"
                )
            write_marks(copy_except(old, new, {"marks"}), [*marks, mark])

    def annotations(self, run_id: str) -> list[Annotation]:
        """Return the history of a run's tags and notes, oldest first."""
        return self._read(run_id, read_annotations)

    def tags(self, run_id: str) -> tuple[str, ...]:
        """Return the tags that a run has now."""
        return tags_after(self.annotations(run_id))

    def annotate(self, run_id: str, *added: Annotation) -> None:
        """Add tags and notes to a run's history; all else that the run holds stays as it is.

        Raises ``ArchiveError`` where a tag is taken back that the run has not.
        """
        with self._rewriting(run_id) as (old, new):
            history = read_annotations(old["entry"])
            for annotation in added:
                self._refuse_to_take_back(run_id, annotation, tags_after(history))
                history.append(annotation)
            write_annotations(copy_except(old, new, {"annotations"}), history)

    def _refuse_to_take_back(self, run_id: str, annotation: Annotation, tags: Sequence[str]) -> None:
        if annotation.kind == "untag" and annotation.text not in tags:
            raise ArchiveError(
                f"{self.path(run_id)}: found no tag {annotation.text!r} to remove; expected a tag of the run; "
                f"{did_you_mean(annotation.text, tags)}"
            )

    def _read(self, run_id: str, reader: Callable[[h5py.Group], T]) -> T:
        """Return what a reader finds in the entry of a run's file; raises as ``open`` does."""
        with self.open(run_id) as file:
            return reader(file["entry"])

    @contextmanager
    def open(self, run_id: str, parts: Sequence[str] | None = None) -> Iterator[h5py.File]:
        """Open a run's file for reading, all of it or some datasets alone.

        Raises ``ArchiveError`` where there is none, it is no run, or what is read from it is damaged.
        """
        path = self.path(run_id)
        if not path.is_file():
            _refuse_odd(path)
            raise ArchiveError(
                f"{self.folder}: found no run {run_id!r}; expected the ID of an archived run; "
                f"{did_you_mean(run_id, self.ids())}"
            )
        with opened(path, None if parts is None else [*parts, _IDENTIFIERS["run"]]) as file:
            check_format(file, path, RUN_FORMAT)
            self._refuse_other_case(file, "run", run_id)
            yield file

    def _refuse_other_case(self, file: h5py.File, kind: Literal["run", "study"], identifier: str) -> None:
        """Refuse a file that Windows or macOS opened although its name is in another letter case."""
        if not isinstance(self.folder, RemotePath) and _IDENTIFIERS[kind] in file:
            refuse_other_case(f"{self.folder}: ", kind, identifier, [text(file, _IDENTIFIERS[kind])])

    @contextmanager
    def _rewriting(self, run_id: str) -> Iterator[tuple[h5py.File, h5py.File]]:
        """Yield the file of a run and the file that will replace it, with a lock against other writers."""
        with self._writing(self.path(run_id)) as new, self.open(run_id) as old:
            yield old, new

    @contextmanager
    def _writing(self, path: Path) -> Iterator[h5py.File]:
        """Give an empty file that takes the place of one of the archive, alone among writers until it has.

        It takes no place unless it is found to be one that can be read again.
        """
        with self._held(path):
            try:
                with placed(self.folder, path, "written") as part:
                    with written(part, SEAL_SIZE) as file:
                        yield file
                    seal_file(part)
                    _read_back(part, path)
            except OSError as error:
                self._refuse(error)
            with suppress(OSError):  # it is written, whatever can be known of it now
                stamp = stamp_of(path.stat())
                know(path, stamp)
                renamed(part, path, stamp)

    @contextmanager
    def _held(self, path: Path) -> Iterator[None]:
        """Hold the lock of a file's writers; its folder is made where there is none, and tidied the first time."""
        refuse_writing(self.folder)
        if not self._is_tidy:
            self.tidy()
        with ExitStack() as held:
            try:
                self._make_folder(path.parent)
                held.enter_context(writers_lock(self.folder, path.stem))
            except OSError as error:
                self._refuse(error)
            yield

    @contextmanager
    def alone_with(self, identifier: str) -> Iterator[None]:
        """Be the only one who writes a run or study, or draws it. Raises ``ArchiveError`` where that cannot be."""
        with self._held(self.path(identifier)):
            yield

    def begin(self) -> None:
        """Make the folder where there is none. Raises ``ArchiveError`` where that cannot be done."""
        refuse_writing(self.folder)
        try:
            self._make_folder(self.folder)
        except OSError as error:
            self._refuse(error)

    def tidy(self) -> None:
        """Take away what was left of runs, studies and figures by writers that were killed."""
        self._is_tidy = True
        for part in leftovers(self.folder / FIGURES):  # those of a run that is drawn again go at once
            with suppress(OSError):
                if is_old(part):
                    part.unlink()
        for part in (*leftovers(self.folder), *leftovers(self.folder / STUDIES)):
            name = part.name[1:].partition(SUFFIX)[0]
            with suppress(ArchiveError, OSError), writers_lock(self.folder, name, wait=False):
                part.unlink(missing_ok=True)

    def _make_folder(self, folder: Path) -> None:
        """Make a folder where there is none; one that has gone meanwhile is not created again on another drive."""
        if self._drive is not None and drive_of(self.folder) != self._drive:
            raise ArchiveError(
                f"{self.folder}: found that the archive folder no longer exists; expected the folder to remain "
                "available during writing; check whether its drive or network share is connected, or whether it was "
                "moved"
            )
        folder.mkdir(parents=True, exist_ok=True)
        self._drive = drive_of(self.folder)

    def _refuse(self, error: OSError) -> NoReturn:
        raise ArchiveError(
            f"{self.folder}: cannot be written ({error.strerror or error}); expected a folder with "
            "free space and write permission; choose another with --archive"
        ) from None


def _read_back(part: Path, path: Path) -> None:
    """Raise ``ArchiveError`` where what is to be a file of the archive could not be read again."""
    try:
        with opened(part):
            pass
    except ArchiveError as error:
        if error.__cause__ is not None and (number := number_of(error.__cause__)):
            raise OSError(number, os.strerror(number)) from error
        raise ArchiveError(
            f"{path}: cannot be archived because it cannot be read back ({_found_in(error)}); expected content "
            "within the limits of the archive; the archive is unchanged"
        ) from None


def _found_in(error: ArchiveError) -> str:
    """Return the problem that an error states, without file name and remedy."""
    sentence = str(error)
    return sentence[max(sentence.find("found "), 0) :].partition(";")[0]


def _ids(folder: Path) -> list[str]:
    if isinstance(folder, RemotePath):
        found = names_in(folder)
    elif not folder.is_dir():
        return []
    else:
        found = _names_in(folder)
    return sorted((name.removesuffix(SUFFIX) for name in found if not name.startswith(".")), key=natural_order)


def _names_in(folder: Path) -> list[str]:
    try:
        with os.scandir(folder) as entries:
            return [entry.name for entry in entries if entry.name.endswith(SUFFIX) and entry.is_file()]
    except OSError as error:
        raise ArchiveError(
            f"{folder}: cannot be read ({error.strerror or error}); expected an archive folder; check its permissions"
        ) from None


def refuse_other_case(where: str, kind: str, identifier: str, known: Iterable[str]) -> None:
    """Raise ``ArchiveError`` where the ID asked for is not known, but one that differs only in letter case is."""
    there = list(known)
    other = next((one for one in there if one.casefold() == identifier.casefold()), None)
    if other is not None and identifier not in there:
        raise ArchiveError(
            f"{where}found the {kind} {other!r}, but no {kind} {identifier!r}; expected the ID with the same "
            f"upper- and lower-case letters; use {other!r}, or choose a different ID for a new {kind}"
        )


def _refuse_odd(path: Path) -> None:
    """Refuse what has the name of a file and is none: to open a pipe may take for ever, a device may have no end.

    A link to a file is followed, wherever that is: a lab may keep large runs on another drive. A writer puts a file
    in the place of the link, and leaves the other one as it is.
    """
    if os.path.lexists(path):
        raise ArchiveError(
            f"{path}: found a folder, pipe, device or broken link; expected a file written by tribopipe; "
            "move it out of the archive"
        )
