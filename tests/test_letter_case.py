"""IDs that differ only in upper and lower case, where the file system takes both names for one file."""

import os
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import pytest
from test_history import STUDY, called, note, study

from tribopipe.archive import run_files
from tribopipe.archive.file_signature import SUFFIX
from tribopipe.archive.removal import remove, restore
from tribopipe.archive.store import Archive
from tribopipe.archive.studyfile import StoredStudy
from tribopipe.base.errors import ArchiveError
from tribopipe.documents.annotation import Mark

RUN, OTHER_CASE = "Test1", "test1"
STUDY_IN_CAPITALS = STUDY.upper()
NAMES = (RUN, "other", STUDY)
"""IDs of the files that are in the folder."""


def also_called(path: Path, name: str) -> None:
    """Give a file a second name, which the file system of Windows or macOS gives it without being asked."""
    with suppress(FileExistsError):
        os.link(path, path.with_name(f"{name}{SUFFIX}"))


def study_in_capitals() -> StoredStudy:
    stored = study("second")
    return replace(stored, study=stored.study.model_copy(update={"id": STUDY_IN_CAPITALS}))


@pytest.fixture
def archive(bare_run, tmp_path, monkeypatch) -> Archive:
    """An archive on a file system without upper and lower case, whose folders list each file once."""
    made = Archive(tmp_path / "archive")
    made.add(called(bare_run, RUN))
    made.add(called(bare_run, "other"))
    made.put_study(study("first"))
    also_called(made.path(RUN), OTHER_CASE)
    also_called(made.study_folder / f"{STUDY}{SUFFIX}", STUDY_IN_CAPITALS)
    listed = run_files._names_in
    monkeypatch.setattr(
        run_files, "_names_in", lambda folder: [name for name in listed(folder) if name.removesuffix(SUFFIX) in NAMES]
    )
    return made


@pytest.mark.parametrize(
    "act",
    [
        lambda archive: archive.mark(OTHER_CASE, Mark(kind="bad", reason="debris", date="2026-11-01T08:00:00+00:00")),
        lambda archive: archive.annotate(OTHER_CASE, note("mine")),
        lambda archive: archive.manifest(OTHER_CASE),
        lambda archive: remove(archive, OTHER_CASE),
        lambda archive: remove(archive, OTHER_CASE, force=True),
    ],
)
def test_run_of_the_other_case_is_not_taken_for_the_one_asked_for(archive, act):
    before = archive.path(RUN).read_bytes()
    with pytest.raises(ArchiveError, match=rf"found the run '{RUN}', but no run '{OTHER_CASE}'.*use '{RUN}'"):
        act(archive)
    assert archive.path(RUN).read_bytes() == before
    assert sorted(archive.ids()) == sorted([RUN, "other"])


def test_new_run_does_not_take_the_place_of_one_of_the_other_case(archive, bare_run):
    before = archive.path(RUN).read_bytes()
    with pytest.raises(ArchiveError, match=rf"found the run '{RUN}', but no run '{OTHER_CASE}'"):
        archive.add(called(bare_run, OTHER_CASE), force=True)
    assert archive.path(RUN).read_bytes() == before


@pytest.mark.parametrize(
    "act",
    [
        lambda archive: archive.study(STUDY_IN_CAPITALS),
        lambda archive: remove(archive, STUDY_IN_CAPITALS, study=True),
        lambda archive: archive.put_study(study_in_capitals()),
    ],
)
def test_study_of_the_other_case_is_not_taken_for_the_one_asked_for(archive, act):
    with pytest.raises(ArchiveError, match=rf"found the study '{STUDY}', but no study '{STUDY_IN_CAPITALS}'"):
        act(archive)
    assert archive.study(STUDY).study.title == "first"


def test_removed_run_of_the_other_case_is_not_restored(archive, monkeypatch):
    kept = remove(archive, RUN, force=True)
    archive.path(OTHER_CASE).unlink(missing_ok=True)
    also_called(kept, OTHER_CASE)
    monkeypatch.setattr("tribopipe.archive.removal.removed_ids", lambda *_, **__: [RUN])
    with pytest.raises(ArchiveError, match=rf"found the run '{RUN}', but no run '{OTHER_CASE}'.*use '{RUN}'"):
        restore(archive, OTHER_CASE)
    assert kept.is_file()
