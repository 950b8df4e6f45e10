"""Archived files that somebody made to do harm are refused in a sentence, at once, by whoever reads them."""

import os
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from multiprocessing import get_context

import h5py
import hostile_files
import hostile_made
import numpy as np
import pytest
from archived_files import edited
from hanging import ends_soon
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from test_archive import run_with

from tribopipe.archive import hdf5_guard as own_content
from tribopipe.archive import nexus
from tribopipe.archive.catalog.reading import read_cells
from tribopipe.archive.hdf5_compression import check_packed, unpacked
from tribopipe.archive.hdf5_guard import RawFile, attributes, own_datasets
from tribopipe.archive.store import Archive
from tribopipe.base.errors import ArchiveError

pytestmark = pytest.mark.slow

RUN, STUDY = hostile_files.RUN, hostile_files.STUDY_ID
LARGE = {"text of 64 MB", "20 000 attributes", "100 000 members", "600 000 lists", "hole of 1 GB at the end"}
LARGE |= {"hole of 1 GB at the beginning", "study with a text of 64 MB"}
SOUND = {
    "soft link instead of a result",
    "numbers with a different byte order",
    "field instead of a group",
    "result nested 100 000 levels deep",
    "findings nested 100 000 levels deep",
    "600 000 lists",
    "number 1e400",
    "number with 100 000 digits",
    "manifest of another run",
    "source file name with a path outside the folder",
    "names with paths outside the archive",
}
"""What is as tribopipe writes it in all that makes a run as it was ingested."""


@pytest.fixture(scope="module")
def good(tmp_path_factory):
    return hostile_files.good_archive(tmp_path_factory.mktemp("good"))


def refusals(archive):
    """Return what each way to read a run says where it refuses it, and that none takes long."""
    ways = {
        "cells": lambda: read_cells(archive, RUN),
        "outline": lambda: archive.outline(RUN),
        "raw": lambda: archive.raw(RUN),
        "cleaned": lambda: archive.cleaned(RUN),
        "steps": lambda: archive.steps(RUN),
        "study": lambda: archive.study(STUDY),
    }
    said = {}
    for name, read in ways.items():
        with ends_soon():
            try:
                read()
            except ArchiveError as error:
                said[name] = str(error)
    return said


@pytest.mark.parametrize("name", [name for name in hostile_files.NAMES if name not in LARGE])
def test_it_is_refused_in_a_sentence_or_read_soundly(good, name, tmp_path):
    archive = Archive(hostile_files.spoilt(good, name, tmp_path))
    said = refusals(archive)
    for sentence in said.values():
        assert f"{STUDY if name in hostile_made.STUDY else RUN}.h5: found " in sentence
        assert "; expected " in sentence
        assert "\n" not in sentence
        assert len(sentence) < 700
    if name in hostile_made.STUDY:
        assert set(said) == {"study"}
    else:
        assert ("raw" in said) == (name not in SOUND)
        assert "study" not in said


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(LARGE))
def test_large_ones_are_refused_too(good, name, tmp_path):
    assert refusals(Archive(hostile_files.spoilt(good, name, tmp_path)))


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "fork"), reason="processes are forked")
def test_every_command_stays_within_bounds(tmp_path):
    names = ["512 MB of zeros in a small chunk", "10 000 nested groups", "attribute with a declared length of 4 GB"]
    # Forked processes begin with the memory of the one they come from, which the tests before have filled.
    filled = b"x" * int(hostile_files.MEGABYTES * 1e6)
    with ProcessPoolExecutor(1, get_context("spawn")) as fresh:
        rows = fresh.submit(hostile_files.attacked, names, tmp_path).result()
    del filled
    assert len(rows) == 1 + len(names)
    assert [row.found for row in rows if not row.holds] == []


def test_a_link_to_a_file_elsewhere_is_read_and_never_written_through(good, tmp_path):
    """As a lab may keep large runs on another drive; the browser's server refuses it, see test_browse_security."""
    folder = tmp_path / "archive"
    folder.mkdir()
    elsewhere = tmp_path / "elsewhere.h5"
    elsewhere.write_bytes((good / f"{RUN}.h5").read_bytes())
    try:
        (folder / f"{RUN}.h5").symlink_to(elsewhere)
    except OSError:
        pytest.skip("this system lets nobody make symbolic links")
    archive, before = Archive(folder), elsewhere.read_bytes()
    assert archive.ids() == [RUN]
    archive.put_step(RUN, archive.step(RUN, "friction_fit"))
    assert elsewhere.read_bytes() == before
    assert not (folder / f"{RUN}.h5").is_symlink()


def test_odd_names_are_not_listed(tmp_path):
    (tmp_path / "folder.h5").mkdir()
    (tmp_path / "run.h5").write_bytes(b"")
    assert Archive(tmp_path).ids() == ["run"]


# --- what is looked at ---


def test_a_file_is_looked_through_once_until_it_changes(good, tmp_path, monkeypatch):
    path = tmp_path / f"{RUN}.h5"
    path.write_bytes((good / f"{RUN}.h5").read_bytes())
    looks = []
    through = own_content._Look.through
    monkeypatch.setattr(own_content._Look, "through", lambda look: looks.append(1) or through(look))
    archive = Archive(tmp_path)
    archive.raw(RUN), archive.outline(RUN), read_cells(archive, RUN)
    assert len(looks) == 1
    with edited(path) as file:
        file["entry/raw/new"] = h5py.ExternalLink("elsewhere.h5", "/x")
    with pytest.raises(ArchiveError, match="a link to another file at /entry/raw/new"):
        archive.outline(RUN)
    assert len(looks) == 2


def test_shapes_are_those_of_the_file(good):
    with Archive(good).open(RUN) as file:
        found = {}
        file.visititems(lambda name, part: found.update({f"/{name}": part.shape} if hasattr(part, "shape") else {}))
        assert own_datasets(file) == found


def test_lengths_of_texts_are_known_before_they_are_read(good):
    """Against what h5py reads of every part of a run and a study."""
    for path in (good / f"{RUN}.h5", good / "studies" / f"{STUDY}.h5"):
        with h5py.File(path) as file:
            raw, parts = RawFile(file), [file]
            file.visititems(lambda _, part, parts=parts: parts.append(part))
            for part in parts:
                found = attributes(raw, h5py.h5o.get_info(part.id).addr)
                texts = [
                    text for value in part.attrs.values() for text in np.atleast_1d(value) if isinstance(text, str)
                ]
                assert len(found) == len(part.attrs)
                assert sum(attribute.length for attribute in found) == sum(len(text.encode()) for text in texts)
                if isinstance(part, h5py.Dataset) and part.dtype == object:
                    assert list(raw.text_lengths(part.id)) == [len(text) for text in np.atleast_1d(part[()])]
            assert len(parts) > 50


@pytest.mark.parametrize("low", ["earliest", "latest"])
def test_headers_of_every_version_are_understood(tmp_path, low):
    with h5py.File(tmp_path / "x.h5", "w", libver=(low, "latest"), userblock_size=512) as file:
        file.attrs["long"] = "µ" * 300
        for number in range(6):
            file.attrs[f"text {number}"] = ["a" * number, "b"]
            file.attrs[f"number {number}"] = np.arange(number + 1.0) if low == "earliest" else float(number)
            file.attrs.pop(f"number {number}" if low == "latest" else "nothing", None)
        file.attrs["fixed"] = np.bytes_(b"four")
    with h5py.File(tmp_path / "x.h5") as file:
        found = attributes(RawFile(file), h5py.h5o.get_info(file.id).addr)
        assert sum(attribute.length for attribute in found) == 600 + sum(range(6)) + 6
        assert len(found) == len(file.attrs)
        assert all(attribute.is_plain for attribute in found)


# --- unpacking ---


@given(
    arrays(
        st.sampled_from(["<f8", ">f8", "<i4", "<u1", "<f4"]),
        st.tuples(st.integers(256, 400)) | st.tuples(st.integers(1, 30), st.integers(10, 30)),
        elements=st.integers(0, 100),
    ),
    st.integers(1, 500),
)
def test_arrays_are_unpacked_as_hdf5_does(values, last):
    with h5py.File.in_memory() as file:
        file.create_dataset("x", data=values, chunks=True, compression="gzip", shuffle=True, fletcher32=True)
        nexus.field(file, "y", values)
        for dataset in file.values():
            check_packed(dataset)
            assert unpacked(dataset).dtype == values.dtype
            np.testing.assert_array_equal(unpacked(dataset), values)
            np.testing.assert_array_equal(unpacked(dataset, last), values[-last:])


def test_a_chunk_that_lies_is_refused():
    with h5py.File.in_memory() as file:
        nexus.field(file, "x", np.arange(300.0))
        file["x"].id.write_direct_chunk((0,), b"\x78\x9cnothing", 4)
        for read in (unpacked, check_packed):
            with pytest.raises(ArchiveError, match="a chunk that cannot be unpacked"):
                read(file["x"])


def test_what_could_not_be_read_again_is_not_archived(bare_run, tmp_path, monkeypatch):
    archive, run = Archive(tmp_path), run_with(bare_run, np.zeros(200_000))
    archive.add(run_with(bare_run, np.arange(10.0)))
    before = archive.path("bare").read_bytes()
    monkeypatch.setattr(own_content, "_ROOM", 0)
    monkeypatch.setattr(own_content, "_ROOM_A_BYTE", 1)
    other = replace(run, manifest=run.manifest.model_copy(update={"id": "constant"}))
    with pytest.raises(ArchiveError, match=r"constant\.h5: cannot be archived because it cannot be read back \(found"):
        archive.add(other)
    assert archive.ids() == ["bare"]
    assert archive.path("bare").read_bytes() == before
