"""Crates that somebody made to do harm, or that were damaged on the way: one sentence, and nothing gets in."""

import hashlib
import json
import os
import shutil
import stat
import zipfile
from contextlib import suppress
from pathlib import Path

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from tribopipe.archive.store import Archive
from tribopipe.base.errors import TribopipeError
from tribopipe.extras.fair.restore import restore

RUN = "si3n4-air-200mN"
NAME = f"archive/{RUN}.h5"


@pytest.fixture(scope="module")
def content(_processed) -> bytes:
    """A sound archived run."""
    return (_processed / f"{RUN}.h5").read_bytes()


def described(content: bytes, name: str = NAME, **other) -> dict:
    """Metadata of a crate that holds one file."""
    said = {"contentSize": str(len(content)), "sha256": hashlib.sha256(content).hexdigest(), **other}
    return {"@context": "https://w3id.org/ro/crate/1.1/context", "@graph": [{"@id": name, "@type": "File", **said}]}


def packed(path: Path, entries: dict, metadata: object) -> Path:
    """A zip of some files; keys are names or entries of zips."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as crate:
        crate.writestr("ro-crate-metadata.json", metadata if isinstance(metadata, bytes) else json.dumps(metadata))
        for entry, data in entries.items():
            crate.writestr(entry, data)
    return path


def refused(path: Path, folder: Path) -> str:
    """What is said of a crate of which nothing gets in."""
    archive = Archive(folder / "new" / "archive")
    try:
        restored = restore(path, archive)
    except TribopipeError as error:
        said = str(error)
    else:
        assert restored.done == {}
        (said,) = map(str, restored.failed.values())
    assert archive.ids() == []
    outside = {one for one in folder.rglob("*") if one.is_file() and ".locks" not in one.parts}
    assert {one for one in outside if one.suffix == ".h5" and "crate" not in one.parts} == set()
    assert "\n" not in said
    return said


def test_sound_crate_is_taken(content, tmp_path):
    path = packed(tmp_path / "crate.zip", {NAME: content}, described(content))
    assert list(restore(path, Archive(tmp_path / "archive")).done.values()) == ["added"]


@pytest.mark.parametrize(
    ("other", "said"),
    [
        ({"sha256": "0" * 64}, "with content that differs from the packed file"),
        ({"contentSize": "7"}, "expected the 7 that its metadata states"),
        ({"sha256": "abc"}, "found no archived run in it"),
        ({"contentSize": "-1"}, "found no archived run in it"),
        ({"contentSize": "9" * 40}, "found no archived run in it"),
        ({"contentSize": {"@id": "x"}}, "found no archived run in it"),
        ({"@id": 7}, "found no archived run in it"),
        ({"@id": "archive/../../evil.h5"}, "found no archived run in it"),
        ({"@id": "archive/%2e%2e%2fevil.h5"}, "found no archived run in it"),
        ({"@id": "/etc/archive/x.h5"}, "found no archived run in it"),
        ({"@id": "archive/other.h5"}, "found no file 'archive/other.h5', which its metadata describes"),
    ],
)
def test_metadata_that_lie_are_told(content, tmp_path, other, said):
    assert said in refused(packed(tmp_path / "crate.zip", {NAME: content}, described(content, **other)), tmp_path)


@pytest.mark.parametrize(
    "metadata", [b"", b"{", b"[]", b"7", b'{"@graph": 3}', b'{"@graph": [3, null, []]}', b"[" * 100_000, b"\xff\xfe"]
)
def test_metadata_that_are_none_are_told(tmp_path, metadata):
    assert "found " in refused(packed(tmp_path / "crate.zip", {NAME: b"any"}, metadata), tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("value", [b"{}", b"[]", b'{"":0}', b'[{"a":[]}]'])
def test_metadata_of_very_many_values_are_not_read(tmp_path, value):
    metadata = b'{"@graph":[' + b",".join([value] * 1_600_000) + b"]}"
    said = refused(packed(tmp_path / "crate.zip", {NAME: b"any"}, metadata), tmp_path)
    assert "values; expected at most 3,000,000" in said
    assert (tmp_path / "crate.zip").stat().st_size < 1 << 20


@pytest.mark.slow
def test_metadata_of_very_many_bytes_are_not_read(tmp_path):
    metadata = b'{"@graph":["' + 42_000_000 * b"a" + "\U0001f600".encode() + b'"]}'
    said = refused(packed(tmp_path / "crate.zip", {NAME: b"any"}, metadata), tmp_path)
    assert "bytes; expected at most 41,943,040" in said
    assert (tmp_path / "crate.zip").stat().st_size < 1 << 20


@pytest.mark.parametrize("name", ["../evil.h5", "/evil.h5", "a/../../evil.h5", "c:/evil.h5", "..\\evil.h5"])
def test_name_that_leads_out_is_told(content, tmp_path, name):
    entry = zipfile.ZipInfo("x")
    entry.filename = name
    said = refused(packed(tmp_path / "crate.zip", {NAME: content, entry: content}, described(content)), tmp_path)
    assert "outside the crate" in said


@pytest.mark.parametrize("kind", [stat.S_IFLNK, stat.S_IFIFO, stat.S_IFCHR])
def test_link_in_a_zip_is_told(tmp_path, kind):
    entry = zipfile.ZipInfo(NAME)
    entry.external_attr = (kind | 0o777) << 16
    said = refused(packed(tmp_path / "crate.zip", {entry: b"/etc/passwd"}, described(b"/etc/passwd")), tmp_path)
    assert "a link or a device" in said


@pytest.mark.skipif(os.name == "nt", reason="links need rights on Windows")
def test_link_out_of_a_folder_is_not_followed(content, tmp_path):
    secret = tmp_path / "secret"
    secret.write_bytes(content)
    (tmp_path / "crate/archive").mkdir(parents=True)
    (tmp_path / "crate/ro-crate-metadata.json").write_text(json.dumps(described(content)), encoding="utf-8")
    (tmp_path / "crate" / NAME).symlink_to(secret)
    assert "found no file" in refused(tmp_path / "crate", tmp_path)


def test_bomb_is_not_unpacked(tmp_path, monkeypatch):
    monkeypatch.setattr("tribopipe.extras.fair.restore._FREE", 1 << 20)
    zeros = bytes(3 << 20)
    said = refused(packed(tmp_path / "crate.zip", {NAME: zeros}, described(zeros)), tmp_path)
    assert "which unpacks to 3,145,728 bytes" in said


def test_file_that_is_longer_than_it_says_is_told(content, tmp_path):
    """The list of files and the metadata agree on a size, and the packed bytes do not."""
    path = packed(tmp_path / "crate.zip", {NAME: content}, described(content[:-7]))
    size, other = len(content).to_bytes(4, "little"), (len(content) - 7).to_bytes(4, "little")
    path.write_bytes(path.read_bytes().replace(size, other))
    assert "found " in refused(path, tmp_path)


def test_name_for_two_files_is_told(content, tmp_path):
    path = packed(tmp_path / "crate.zip", {NAME: content}, described(content))
    with pytest.warns(UserWarning, match="Duplicate name"), zipfile.ZipFile(path, "a") as crate:
        crate.writestr(NAME, b"other")
    assert "twice; expected each file once" in refused(path, tmp_path)


def test_run_under_another_name_is_told(content, tmp_path):
    path = packed(tmp_path / "crate.zip", {"archive/other.h5": content}, described(content, "archive/other.h5"))
    assert f"found the ID {RUN!r} in the file; expected 'other'" in refused(path, tmp_path)


@pytest.mark.parametrize("name", ["archive/studies/x.h5", NAME])
def test_what_is_no_archived_file_is_told(tmp_path, name):
    junk = b"\x89HDF\r\n\x1a\n" + bytes(5000)
    assert "cannot be added to the archive" in refused(
        packed(tmp_path / "crate.zip", {name: junk}, described(junk, name)), tmp_path
    )


def test_run_with_a_broken_seal_is_told(content, tmp_path):
    changed = bytearray(content)
    changed[len(changed) // 2] ^= 1
    path = packed(tmp_path / "crate.zip", {NAME: bytes(changed)}, described(bytes(changed)))
    assert "found a damaged file" in refused(path, tmp_path)


@pytest.mark.parametrize("junk", [b"", b"PK\x05\x06", b"not a zip", b"PK\x03\x04" + bytes(100)])
def test_what_is_no_zip_is_told(tmp_path, junk):
    path = tmp_path / "crate.eln"
    path.write_bytes(junk)
    assert "expected an RO-Crate or a .eln file" in refused(path, tmp_path)


def test_folder_or_name_without_a_crate_is_told(tmp_path):
    assert "found no ro-crate-metadata.json in it" in refused(tmp_path, tmp_path)
    assert "found no such file or folder" in refused(tmp_path / "nothing", tmp_path)


def test_list_of_files_without_end_is_not_read(content, tmp_path):
    path = packed(tmp_path / "crate.zip", {NAME: content}, described(content))
    said = bytearray(path.read_bytes())
    place = said.rfind(b"PK\x05\x06") + 12
    said[place : place + 4] = (1 << 30).to_bytes(4, "little")
    path.write_bytes(said)
    assert "found a file list of more than" in refused(path, tmp_path)


def test_one_damaged_file_does_not_stop_the_others(content, tmp_path, run_cli):
    metadata = described(content)
    metadata["@graph"] += described(content, "archive/lost.h5")["@graph"]
    path = packed(tmp_path / "crate.zip", {NAME: content}, metadata)
    done = run_cli("import", path, cwd=tmp_path)
    assert done.exit_code == 3
    assert f"{RUN}: run archived" in done.output
    assert "found no file 'archive/lost.h5'" in done.output


@pytest.mark.parametrize(
    ("document", "other", "said"),
    [
        (b"x = [", {}, "about/dataset.toml: "),
        (b'schema = "tribopipe.dataset/1"\nlicence = "mine"', {}, "licence: found 'mine'"),
        (b"x = 1", {"sha256": "0" * 64}, "with content that differs from the packed file"),
        (b" " * (2 << 20), {}, "expected at most 1,048,576"),
    ],
)
def test_dataset_toml_that_is_none_is_not_written(content, tmp_path, document, other, said):
    metadata = described(content)
    metadata["@graph"] += described(document, "about/dataset.toml", **other)["@graph"]
    path = packed(tmp_path / "crate.zip", {NAME: content, "about/dataset.toml": document}, metadata)
    restored = restore(path, Archive(tmp_path / "lab" / "archive"))
    assert list(restored.done.values()) == ["added"]
    assert restored.dataset is None
    assert said in str(restored.refused_dataset)
    assert not (tmp_path / "lab" / "dataset.toml").exists()


def test_dataset_toml_that_cannot_be_written_is_told_of_its_own_place(content, tmp_path, monkeypatch):
    def full(path: Path, written: bytes) -> None:  # noqa: ARG001
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("tribopipe.extras.fair.restore.write_file", full)
    document, metadata = b'schema = "tribopipe.dataset/1"\n', described(content)
    metadata["@graph"] += described(document, "about/dataset.toml")["@graph"]
    path = packed(tmp_path / "crate.zip", {NAME: content, "about/dataset.toml": document}, metadata)
    (tmp_path / "lab").mkdir()
    refused = restore(path, Archive(tmp_path / "lab" / "archive")).refused_dataset
    assert str(refused).startswith(f"{tmp_path / 'lab' / 'dataset.toml'}: cannot be written (No space left on device)")


@settings(max_examples=25, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(place=st.integers(0, 4000), value=st.integers(0, 255), cut=st.integers(0, 200))
@example(place=372, value=0, cut=0).via("a file without a name")
def test_any_damage_to_a_zip_is_told_or_without_effect(tmp_path, place, value, cut):
    path = tmp_path / "crate.zip"
    if not path.exists():
        packed(path, {"readme.txt": b"x" * 50}, described(b"x" * 50, "archive/x.h5"))
    said = bytearray(path.read_bytes())
    said[place % len(said)] = value
    other = tmp_path / "other.zip"
    other.write_bytes(said[: len(said) - cut])
    shutil.rmtree(tmp_path / "new", ignore_errors=True)
    with suppress(TribopipeError):
        assert restore(other, Archive(tmp_path / "new")).done == {}
