"""Source files come out of damaged archived runs as they went in, or not at all; nothing else is touched."""

import hashlib
import json
import random
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest
from archived_files import edited, write_as_earlier
from folders import ROOT, tree_bytes

from tribopipe.archive import rescue as module
from tribopipe.archive.rescue import rescue
from tribopipe.archive.store import Archive
from tribopipe.base.errors import ArchiveError, TribopipeError
from tribopipe.pipeline.stages import ingest

RUN = "si3n4-air-200mN"
SOURCES = ("run.toml", "signals.csv")


@pytest.fixture
def damaged(archive) -> Path:
    """An archived run, to be damaged."""
    return archive / f"{RUN}.h5"


@pytest.fixture
def say_rescue(run_cli, damaged, tmp_path):
    """Run rescue on the file."""
    return lambda *arguments: run_cli("rescue", damaged, "--to", tmp_path / "saved", *arguments)


def sentence(result) -> str:
    (error,) = (line for line in result.stderr.splitlines() if line.startswith("error: "))
    return error


def cut(path: Path, share: float) -> None:
    content = path.read_bytes()
    path.write_bytes(content[: int(len(content) * share)])


def zero(path: Path, start: int, end: int) -> None:
    content = bytearray(path.read_bytes())
    content[start:end] = bytes(end - start)
    path.write_bytes(content)


def flip(path: Path, place: int) -> None:
    content = bytearray(path.read_bytes())
    content[place] ^= 1 << place % 8
    path.write_bytes(content)


def bytes_of(path: Path, part: str) -> int:
    """Return where the first bytes of a dataset are in a file."""
    with h5py.File(path) as file:
        dataset = file[part]
        return dataset.id.get_chunk_info(0).byte_offset if dataset.chunks else dataset.id.get_offset()


def assert_as_recorded(folder: Path, recorded: Path, names=SOURCES) -> None:
    assert sorted(tree_bytes(folder)) == sorted(names)
    assert all((folder / name).read_bytes() == (recorded / name).read_bytes() for name in names)


# --- what is saved ---


@pytest.mark.slow
@pytest.mark.parametrize(
    "damage",
    [
        lambda path: flip(path, 100),  # the seal
        lambda path: zero(path, bytes_of(path, "entry/raw/depth"), bytes_of(path, "entry/raw/depth") + 4096),
        lambda path: cut(path, 0.6),
        write_as_earlier,
    ],
)
def test_sources_come_out_as_they_went_in(damaged, short_runs, tmp_path, damage):
    damage(damaged)
    before = damaged.read_bytes()
    found = rescue(damaged, tmp_path / "saved")
    assert (found.whole, found.damaged) == (SOURCES, ())
    assert found.folder == tmp_path / "saved" / RUN
    assert_as_recorded(found.folder, short_runs / RUN)
    assert damaged.read_bytes() == before


@pytest.mark.slow
def test_run_rescued_is_the_run_that_was_archived(damaged, tmp_path):
    sha256 = Archive(damaged.parent).raw_sha256(RUN)
    cut(damaged, 0.9)
    again = Archive(tmp_path / "again")
    ingest(rescue(damaged, tmp_path).folder, again)
    assert again.raw_sha256(RUN) == sha256


def test_damaged_source_is_named_and_not_written(damaged, short_runs, say_rescue, tmp_path):
    flip(damaged, bytes_of(damaged, "entry/source_files/file_1/data") + 100)
    result = say_rescue("--json")
    assert result.exit_code == 3
    assert "found damaged source files: signals.csv" in sentence(result)
    assert "from the instrument" in sentence(result)
    assert_as_recorded(tmp_path / "saved" / RUN, short_runs / RUN, ["run.toml"])
    (run,) = json.loads(result.stdout)["runs"]
    assert (run["saved"], run["damaged"], run["listed"]) == (["run.toml"], ["signals.csv"], True)


def test_lost_list_of_sources_is_said(damaged, say_rescue, tmp_path, short_runs):
    cut(damaged, 0.9)
    result = say_rescue()
    assert result.exit_code == 3
    assert "a damaged list of source files" in sentence(result)
    assert_as_recorded(tmp_path / "saved" / RUN, short_runs / RUN)


def test_source_that_is_not_what_its_checksum_says_is_damaged(damaged, tmp_path):
    with edited(damaged) as file:
        data = file["entry/source_files/file_0/data"]
        data[0] = data[0] ^ 1
    assert rescue(damaged, tmp_path / "saved").damaged == ("run.toml",)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2))
def test_whatever_is_saved_is_what_it_was(damaged, short_runs, tmp_path, seed):
    chance = random.Random(seed)  # noqa: S311
    for _ in range(40):
        flip(damaged, chance.randrange(damaged.stat().st_size))
    try:
        found = rescue(damaged, tmp_path / "saved")
    except TribopipeError:
        assert not (tmp_path / "saved" / RUN).exists()
    else:
        assert_as_recorded(found.folder, short_runs / RUN, found.whole)


def test_command_says_what_to_do_next(damaged, say_rescue, tmp_path):
    result = say_rescue("--json")
    assert result.exit_code == 0
    assert f"2 source files saved in {tmp_path / 'saved' / RUN}" in result.stderr
    assert f"`tribopipe process {tmp_path / 'saved'}`" in result.stderr
    assert json.loads(result.stdout)["runs"] == [
        {
            "file": str(damaged),
            "folder": str(tmp_path / "saved" / RUN),
            "saved": list(SOURCES),
            "damaged": [],
            "listed": True,
            "error": None,
        }
    ]


# --- what is refused ---


def test_file_that_hdf5_cannot_open_is_told(damaged, say_rescue, tmp_path):
    zero(damaged, 0, 2048)
    result = say_rescue()
    assert result.exit_code == 1
    assert str(damaged) in sentence(result)
    assert "nothing can be saved from this file" in sentence(result)
    assert not (tmp_path / "saved").exists()


@pytest.mark.slow
def test_reading_that_does_not_end_is_ended(damaged, tmp_path, monkeypatch):
    """A heap of texts that is all zeros leads HDF5 2.0 in circles."""
    content = damaged.read_bytes()
    heap = content.index(b"GCOL")
    zero(damaged, heap + 16, heap + 4096)
    monkeypatch.setattr("tribopipe.readers.subprocess_readers._LEAST_SECONDS", 1.0)
    with pytest.raises(TribopipeError, match="nothing can be saved"):
        rescue(damaged, tmp_path / "saved")


def test_what_is_no_hdf5_is_refused(damaged, tmp_path):
    damaged.write_bytes(bytes(5000))
    with pytest.raises(TribopipeError, match="no HDF5 file header"):
        rescue(damaged, tmp_path / "saved")


def test_nothing_is_replaced(say_rescue, tmp_path):
    there = tmp_path / "saved" / RUN / "run.toml"
    there.parent.mkdir(parents=True)
    there.write_text("mine", encoding="utf-8")
    result = say_rescue()
    assert result.exit_code == 1
    assert "existing files are never overwritten" in sentence(result)
    assert tree_bytes(tmp_path / "saved") == {f"{RUN}/run.toml": b"mine"}


def test_missing_file_and_full_disk_are_sentences(damaged, tmp_path, monkeypatch):
    with pytest.raises(ArchiveError, match="cannot be read"):
        rescue(damaged.with_name("none.h5"), tmp_path / "saved")

    def fail(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(module, "write_file", fail)
    with pytest.raises(ArchiveError, match="No space left"):
        rescue(damaged, tmp_path / "saved")
    assert list((tmp_path / "saved").iterdir()) == []


@pytest.mark.slow
@pytest.mark.parametrize("name", ["../run.toml", "RUN.TOML"])
def test_name_that_leads_out_or_is_taken_is_not_written(damaged, tmp_path, name):
    with edited(damaged) as file:
        file["entry/source_files/file_1/file_name"][()] = name
    found = rescue(damaged, tmp_path / "in" / "saved")
    assert (found.whole, found.damaged) == (("run.toml",), (name,))
    assert [path.relative_to(tmp_path).as_posix() for path in tmp_path.rglob("*.[tT]*")] == [f"in/saved/{RUN}/run.toml"]


@pytest.mark.parametrize(
    "name", ["..", "../x", "/etc/x", "C:\\x", "C:x", "a/../../x", "a\\..\\..\\x", "a\x1b[31m", "", "."]
)
def test_name_that_leads_out_is_known(name):
    assert not module._stays_inside(name)


@pytest.mark.parametrize("name", ["run.toml", "exports/signals.csv", "µ 1.txt", "..x"])
def test_name_inside_is_known(name):
    assert module._stays_inside(name)


def test_name_that_steers_a_terminal_is_spelt_out(damaged, say_rescue):
    with edited(damaged) as file:
        file["entry/source_files/file_1/file_name"][()] = "a\x1b[31m\nb"
    assert "found damaged source files: a\\x1b[31m b" in sentence(say_rescue())


def test_sources_kept_elsewhere_or_larger_than_the_file_are_not_read(damaged, tmp_path):
    secret = tmp_path / "secret"
    secret.write_bytes(b"secret")
    with edited(damaged) as file:
        note = file["entry/source_files/file_0"]
        del note["data"], note["checksum"]
        note.create_dataset("data", (6,), np.uint8, external=[(str(secret), 0, 6)])
        note["checksum"] = hashlib.sha256(b"secret").hexdigest()
        huge = file["entry/source_files/file_1"]
        del huge["data"]
        huge.create_dataset("data", (1 << 40,), np.uint8, chunks=(1 << 20,), compression="gzip")
    with pytest.raises(ArchiveError, match="no intact source file"):
        rescue(damaged, tmp_path / "saved")


@pytest.mark.slow
def test_nearly_all_is_saved_after_small_damage():
    script = ROOT / "benchmarks" / "reliability" / "rescue.py"
    told = subprocess.run([sys.executable, script, "--points", "10"], capture_output=True, text=True, encoding="utf-8")
    assert told.returncode == 0, told.stdout + told.stderr
