"""Files are read as they are, whatever their size."""

import os
import stat
from pathlib import Path

import pytest

from tribopipe import files


@pytest.mark.parametrize("size", [0, 1, 2, 3, 10_001])
def test_a_file_read_in_parts_is_the_file(size: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(files, "_LARGE", 2)
    content = bytes(range(251)) * 40
    path = tmp_path / "signals.csv"
    path.write_bytes(content[:size])
    assert files.read_file(path) == content[:size]


def test_a_file_that_becomes_shorter_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    path = tmp_path / "signals.csv"
    path.write_bytes(b"1;2\n" * 10)
    monkeypatch.setattr(files, "_LARGE", 2)
    long = path.stat()
    path.write_bytes(b"1;2\n")
    monkeypatch.setattr(Path, "stat", lambda *_, **__: long)
    with pytest.raises(OSError, match="became shorter"):
        files.read_file(path)


def test_a_file_that_is_missing_is_told(tmp_path: Path):
    with pytest.raises(FileNotFoundError):
        files.read_file(tmp_path / "signals.csv")


def test_what_a_killed_writer_left_is_found(tmp_path: Path):
    files.write_file(tmp_path / "whole.h5", b"whole")
    (tmp_path / ".whole.h5.abcdefgh.part").write_bytes(b"who")
    assert files.leftovers(tmp_path) == [tmp_path / ".whole.h5.abcdefgh.part"]
    assert files.leftovers(tmp_path / "nowhere") == []


def test_content_and_name_are_on_the_disk_in_that_order(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    said: list[str] = []
    replace, sync = Path.replace, files.os.fsync

    def noted_sync(handle: int) -> None:
        said.append("folder" if stat.S_ISDIR(os.fstat(handle).st_mode) else "file")
        sync(handle)

    def noted_replace(part: Path, path: Path) -> Path:
        said.append("name")
        return replace(part, path)

    monkeypatch.setattr(files.os, "fsync", noted_sync)
    monkeypatch.setattr(Path, "replace", noted_replace)
    files.write_file(tmp_path / "x.h5", b"x")
    assert said == ["file", "name", *([] if os.name == "nt" else ["folder"])]


def test_windows_waits_for_a_reader(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    replace, refusals = Path.replace, iter([PermissionError(13, "in use"), PermissionError(13, "in use"), None])

    def hesitant(part: Path, path: Path) -> Path:
        if (refusal := next(refusals)) is not None:
            raise refusal
        return replace(part, path)

    monkeypatch.setattr(Path, "replace", hesitant)
    monkeypatch.setattr(files, "_IS_WINDOWS", True)
    monkeypatch.setattr(files.time, "sleep", lambda _: None)
    files.write_file(tmp_path / "x.h5", b"x")
    assert (tmp_path / "x.h5").read_bytes() == b"x"
