"""Files are read as they are, whatever their size."""

import errno
import os
import stat
import struct
import tempfile
from pathlib import Path
from types import SimpleNamespace

import pytest

from tribopipe.archive.history import placed
from tribopipe.base import files


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


def test_a_folder_that_cannot_be_synced_has_the_file_all_the_same(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    sync = files.os.fsync

    def of_files(handle: int) -> None:
        if stat.S_ISDIR(os.fstat(handle).st_mode):
            raise OSError(errno.EIO, "Input/output error")
        sync(handle)

    monkeypatch.setattr(files.os, "fsync", of_files)
    files.write_file(tmp_path / "x.h5", b"x")
    assert (tmp_path / "x.h5").read_bytes() == b"x"


def on_macos(monkeypatch: pytest.MonkeyPatch, error: int = 0) -> list[str]:
    """Let files be written as on macOS, whose drives may fail; return what is asked of system and drive."""
    asked: list[str] = []

    def ask_drive(handle: int, command: int) -> int:
        os.fstat(handle)  # is open
        assert command == 51
        asked.append("drive")
        if error:
            raise OSError(error, os.strerror(error))
        return 0

    requests = pytest.importorskip("fcntl", reason="Windows has no such requests")
    monkeypatch.setattr(requests, "fcntl", ask_drive)
    monkeypatch.setattr(requests, "F_FULLFSYNC", 51, raising=False)
    monkeypatch.setattr(files, "sys", SimpleNamespace(platform="darwin"))
    monkeypatch.setattr(files.os, "fsync", lambda _: asked.append("system"))
    return asked


def test_macos_is_asked_to_empty_the_cache_of_the_drive(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    asked = on_macos(monkeypatch)
    files.write_file(tmp_path / "x.h5", b"x")
    assert asked == ["system", "drive"] * 2  # for the content, then for the name


def test_history_is_in_the_drive_before_the_file_has_its_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    asked = on_macos(monkeypatch)
    with placed(tmp_path, tmp_path / "x.h5", "written") as part:
        part.write_bytes(b"x")
    assert asked.count("drive") == asked.count("system") > 2


def test_a_share_that_knows_no_such_request_takes_the_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    asked = on_macos(monkeypatch, errno.ENOTSUP)
    files.write_file(tmp_path / "x.h5", b"x")
    assert "drive" in asked
    assert (tmp_path / "x.h5").read_bytes() == b"x"


def test_a_drive_that_fails_is_no_success(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    on_macos(monkeypatch, errno.EIO)
    with pytest.raises(OSError, match=os.strerror(errno.EIO)):
        files.write_file(tmp_path / "x.h5", b"x")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("mode", [0o600, 0o640, 0o664])
@pytest.mark.skipif(os.name == "nt", reason="Windows has no such modes")
def test_a_file_keeps_its_mode_and_group(tmp_path: Path, mode: int):
    path = tmp_path / "x.h5"
    path.write_bytes(b"old")
    other = next((group for group in (*os.getgroups(), 4321) if group != path.stat().st_gid), None)
    if other is not None and (other != 4321 or os.getuid() == 0):
        os.chown(path, -1, other)
    path.chmod(mode)
    before = path.stat()
    files.write_file(path, b"new")
    after = path.stat()
    assert path.read_bytes() == b"new"
    assert (after.st_mode, after.st_gid) == (before.st_mode, before.st_gid)


def written_by(account: int, group: int, path: Path, content: str) -> int:
    """Write a file as another account that is in a group; return 0 where that is done."""
    if (child := os.fork()) == 0:
        try:
            os.setgroups([group])
            os.setgid(account)
            os.setuid(account)
            os.umask(0o002)
            files.write_file(path, content.encode())
        except BaseException:  # noqa: BLE001 - a child of a test must end here
            os._exit(1)
        os._exit(0)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() != 0, reason="only root can be other accounts")
def test_two_accounts_write_in_turn_in_the_folder_of_their_group():
    group = 54321
    with tempfile.TemporaryDirectory(prefix="group-") as name:  # others may go through the folders above it
        folder = Path(name)
        os.chown(folder, -1, group)
        folder.chmod(0o2770)
        path = folder / "run.h5"
        for account in (54322, 54323, 54322):
            assert written_by(account, group, path, f"by {account}") == 0
            after = path.stat()
            assert path.read_text() == f"by {account}"
            assert (after.st_gid, stat.S_IMODE(after.st_mode)) == (group, 0o664)
        assert written_by(54324, 54325, path, "by a stranger") == 1
        assert [(one.name, one.read_text()) for one in folder.iterdir()] == [("run.h5", "by 54322")]


@pytest.mark.skipif(not hasattr(os, "setxattr"), reason="access lists are read and written on Linux alone")
def test_a_file_keeps_its_access_list(tmp_path: Path):
    path, version, anyone = tmp_path / "x.h5", 2, 0xFFFFFFFF
    path.write_bytes(b"old")
    # Owner, one more user, group, mask and others, as the kernel stores them: tag, rights, id.
    entries = [(1, 6, anyone), (2, 6, 4321), (4, 4, anyone), (16, 6, anyone), (32, 0, anyone)]
    wanted = struct.pack("<I", version) + b"".join(struct.pack("<HHI", *entry) for entry in entries)
    try:
        os.setxattr(path, files._ACCESS_LIST, wanted)
    except OSError as error:
        pytest.skip(f"this file system keeps no access lists ({error.strerror})")
    files.write_file(path, b"new")
    assert os.getxattr(path, files._ACCESS_LIST) == wanted


def test_a_file_that_may_not_be_written_is_not_replaced(tmp_path: Path):
    path = tmp_path / "x.h5"
    path.write_bytes(b"old")
    path.chmod(0o444)
    with pytest.raises(PermissionError, match="read-only"):
        files.write_file(path, b"new")
    assert [(one.name, one.read_bytes()) for one in tmp_path.iterdir()] == [("x.h5", b"old")]
    path.chmod(0o644)


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
