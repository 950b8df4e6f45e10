"""The seal of archived files: whatever byte is another one is known before HDF5 looks, and viewers never see it."""

from pathlib import Path

import h5py
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from test_archive import run_with, step

from tribopipe.archive import seal
from tribopipe.archive.seal import SEAL_SIZE, check_every_byte, check_seal, is_sealed, seal_file
from tribopipe.archive.store import Archive
from tribopipe.base.errors import ArchiveError
from tribopipe.results.evaluation import FrictionFit


@pytest.fixture
def archive(bare_run, tmp_path):
    archive = Archive(tmp_path)
    archive.add(run_with(bare_run, np.arange(10.0)))
    return archive


@settings(max_examples=60, deadline=None)
@given(place=st.floats(0, 1, exclude_max=True), bit=st.integers(0, 7))
def test_any_bit_that_is_another_one_is_found(session_file, place, bit):
    path, content = session_file
    spoiled = bytearray(content)
    spoiled[int(place * len(content))] ^= 1 << bit
    path.write_bytes(spoiled)
    if is_sealed(path):
        with pytest.raises(ArchiveError, match="checksum"):
            check_seal(path)
    else:
        assert place * len(content) < SEAL_SIZE


@pytest.fixture(scope="module")
def session_file(bare_run, tmp_path_factory):
    archive = Archive(tmp_path_factory.mktemp("sealed"))
    archive.add(run_with(bare_run, np.arange(10.0)))
    path = archive.path("bare")
    return path, path.read_bytes()


def test_bytes_at_the_end_are_found_too(archive):
    path = archive.path("bare")
    path.write_bytes(path.read_bytes() + b"\0")
    with pytest.raises(ArchiveError, match="rescue"):
        archive.raw("bare")


def test_damage_is_not_copied_into_the_next_file(archive):
    path = archive.path("bare")
    content = bytearray(path.read_bytes())
    content[-100] ^= 1
    path.write_bytes(content)
    with pytest.raises(ArchiveError, match="checksum"):
        archive.put_step("bare", step("friction_fit", FrictionFit(outcome="none")))
    assert path.read_bytes() == content


def test_a_file_without_its_seal_is_told_apart_from_an_earlier_one(archive):
    path = archive.path("bare")
    path.write_bytes(path.read_bytes()[SEAL_SIZE:])
    with pytest.raises(ArchiveError, match="found no seal"):
        archive.raw("bare")
    with h5py.File(path, "r+") as file:
        file["entry/archived/format"][()] = "tribopipe.archive/1"
    with pytest.raises(ArchiveError, match=r"'tribopipe.archive/1', .*'tribopipe.run/1'; .*`tribopipe rescue`"):
        archive.raw("bare")


def test_the_seal_is_a_line_that_people_can_read(archive):
    first = archive.path("bare").read_bytes()[:SEAL_SIZE].decode("ascii")
    assert first.startswith("tribopipe archive file, sealed.")
    assert first.endswith(" \n")


def test_sealing_on_the_disk_is_the_same_as_sealing_in_memory(archive):
    before = archive.path("bare").read_bytes()
    seal_file(archive.path("bare"))
    assert archive.path("bare").read_bytes() == before


def test_a_file_found_whole_is_not_read_twice(archive, monkeypatch):
    monkeypatch.setattr(seal.Stamp, "settled", lambda *_: True)
    check_seal(archive.path("bare"))
    monkeypatch.setattr(seal.hashlib, "file_digest", None)
    check_seal(archive.path("bare"))


def test_a_file_that_is_replaced_while_it_is_looked_at_is_not_called_damaged(archive, monkeypatch):
    path, other = archive.path(archive.ids()[0]), archive.folder / "other"
    with h5py.File(other, "w", userblock_size=SEAL_SIZE) as file:
        file["longer"] = np.zeros(path.stat().st_size)
    seal_file(other)
    plain = Path.open

    def replaced_first(self, *how, **more):
        if other.exists():
            other.replace(path)
        return plain(self, *how, **more)

    monkeypatch.setattr(Path, "open", replaced_first)
    check_every_byte(path)
    assert not other.exists()
