"""Files are read as they are, whatever their size."""

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
