"""A disk that is full while HDF5 writes: an error that can be told, wherever it comes, and never a dead process."""

import errno
import os
from io import BytesIO, FileIO

import h5py
import numpy as np
import pytest

from tribopipe.archive import nexus
from tribopipe.archive.file_access import LateErrors, written

FULL = OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def fill(file: h5py.File) -> None:
    """Write groups, texts, packed columns, and read some of it back, as a run does."""
    for number in range(9):
        group = nexus.group(file, f"group_{number}", "NXdata", signal="x")
        nexus.field(group, "text", "so it is " * 50)
        nexus.field(group, "x", np.arange(5000.0) + number, "m")
    file.copy("group_3", file, "copied")
    assert nexus.floats(file["group_7"], "x")[2] == 9
    assert nexus.text(file["copied"], "text").startswith("so it is")


class Disk:
    """Room for so many bytes."""

    def __init__(self, room: int, monkeypatch: pytest.MonkeyPatch) -> None:
        self.room, plain = room, LateErrors.write_all

        def write_all(file: LateErrors, content: memoryview) -> None:
            plain(file, content[: self.room])
            self.room -= len(content)
            if self.room < 0:
                self.room = 0
                raise FULL

        monkeypatch.setattr(LateErrors, "write_all", write_all)


def test_what_was_written_is_what_hdf5_writes_by_itself(tmp_path):
    image, path = BytesIO(), tmp_path / "run.h5"
    with h5py.File(image, "w", track_order=True, userblock_size=512) as file:
        fill(file)
    path.write_bytes(b"an older one" * 10_000)
    with written(path, 512) as file:
        fill(file)
    assert path.read_bytes() == image.getvalue()


@pytest.mark.slow
def test_wherever_the_disk_is_full_the_error_is_told(tmp_path, monkeypatch):
    path = tmp_path / "run.h5"
    with monkeypatch.context() as patch, written(path, 512) as file:
        large = Disk(1 << 30, patch)
        fill(file)
    taken = (1 << 30) - large.room
    for room in range(0, taken, taken // 15):
        with monkeypatch.context() as patch:
            Disk(room, patch)
            with pytest.raises(OSError, match="No space left") as raised, written(path, 512) as file:
                fill(file)
        assert raised.value is FULL


@pytest.mark.parametrize(("taken", "written_at_last"), [([2, 3, 1], b"conten"), ([2, 0], b"co"), ([None], b"")])
def test_what_the_system_takes_in_parts_is_written_whole(tmp_path, taken, written_at_last):
    parts = iter(taken)

    class Slow(FileIO):
        def write(self, content):
            count = next(parts)
            return count and super().write(content[:count])

    class Late(LateErrors, Slow):
        pass

    with Late(tmp_path / "run.h5", "w+") as file:
        assert file.write(b"conten") == 6
        assert (file.failed is None) == (written_at_last == b"conten")
    assert (tmp_path / "run.h5").read_bytes() == written_at_last


def test_an_error_of_our_own_passes_where_the_disk_has_room(tmp_path):
    with pytest.raises(KeyError), written(tmp_path / "run.h5", 512) as file:
        file["nothing"]


def test_after_an_error_a_file_takes_all_and_holds_zeros(tmp_path):
    path = tmp_path / "run.h5"
    path.write_bytes(b"whole")
    with LateErrors(path, "r+") as file:
        file.failed = FULL
        assert file.write(b"new") == 3
        into = bytearray(b"text")
        assert file.readinto(into) == 4
        assert into == bytes(4)
        assert file.truncate(2) == 2
    assert path.read_bytes() == b"whole"
