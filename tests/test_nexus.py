"""A run as tribopipe archives it is read back: what was measured, in SI; nothing from outside the file."""

import io
import json
from collections.abc import Callable

import h5py
import numpy as np
import pytest
from built_files import archived
from hypothesis import given, settings
from hypothesis import strategies as st
from sweeps import others_slow

from tribopipe.base.errors import ReaderError
from tribopipe.readers.formats.nexus import NexusReader
from tribopipe.readers.reader import Hints, ReadTable
from tribopipe.readers.subprocess_readers import nexus_fields
from tribopipe.results.run import SourceFile

READER = NexusReader()


@pytest.fixture(scope="module")
def content(tmp_path_factory) -> bytes:
    return archived(tmp_path_factory.mktemp("archive"))


def read(content: bytes) -> ReadTable:
    return READER.read(SourceFile("bare.h5", content), Hints())


def fields(content: bytes) -> dict:
    """What the program answers that reads the file."""
    with h5py.File(io.BytesIO(content), "r") as file:
        return nexus_fields._run(nexus_fields._File(file, most=nexus_fields._MOST_COMPRESSED * len(content)))[0]


def changed(content: bytes, change: Callable[[h5py.File], None]) -> bytes:
    with io.BytesIO(content) as stream:
        with h5py.File(stream, "r+") as file:
            change(file)
        return stream.getvalue()


def test_what_was_measured_comes_back(content):
    table = read(content)
    assert [(column.name, column.unit, column.signal) for column in table.columns] == [
        ("time", "s", "time"),
        ("depth", "m", "depth"),
        ("temperature", "K", "temperature"),
        ("Spin", "rpm", None),
        ("Remark", None, None),
    ]
    assert table.columns[1].values.tolist() == [0, 5e-7, 1e-6]
    assert table.columns[3].values.tolist() == [3, 3.5, 4]
    assert table.columns[4].values.tolist() == ["a", "ä", ""]
    assert table.header == "Time [s];Depth [um]\n"


def test_facts_are_those_of_the_manifest(content):
    assert read(content).facts == {
        "started": "2006-03-01T09:30:00+01:00",
        "operator": "N. N.",
        "conditions.normal_load": "0.2 N",
        "conditions.sliding_speed": "0.4 m/s",
        "conditions.medium": "air",
        "conditions.relative_humidity": "0.45",
    }


@pytest.mark.slow
def test_compressed_columns(tmp_path):
    time = read(archived(tmp_path, rows=1000)).columns[0]
    assert np.array_equal(time.values, np.arange(1000) * 0.5)


def test_match_by_content(content):
    assert READER.match(SourceFile("run.csv", content)).confidence >= 0.9
    assert READER.match(SourceFile("run.h5", content[:3000])).confidence >= 0.9
    with io.BytesIO() as stream:
        h5py.File(stream, "w").close()
        assert READER.match(SourceFile("run.h5", stream.getvalue())).confidence <= 0.2
    assert READER.match(SourceFile("run.h5", b"")).confidence == 0


def external_link(file):
    del file["entry/raw/depth"]
    file["entry/raw/depth"] = h5py.ExternalLink("/etc/other.h5", "/depth")


def external_entry(file):
    del file["entry"]
    file["entry"] = h5py.ExternalLink("/etc/other.h5", "/entry")


def soft_link(file):
    file["entry/raw/time2"] = h5py.SoftLink("/entry/raw/time")


def virtual(file):
    del file["entry/raw/depth"]
    layout = h5py.VirtualLayout(shape=(3,), dtype="f8")
    layout[:] = h5py.VirtualSource("/etc/other.h5", "depth", shape=(3,))
    file["entry/raw"].create_virtual_dataset("depth", layout)


def external_storage(file):
    del file["entry/raw/depth"]
    file["entry/raw"].create_dataset("depth", shape=(3,), dtype="f8", external=[("/etc/hosts", 0, 24)])


@pytest.mark.slow
@pytest.mark.parametrize(
    "change", others_slow([external_link, external_entry, soft_link, virtual, external_storage], external_link, virtual)
)
def test_nothing_outside_the_file_is_read(content, change):
    with pytest.raises(
        ReaderError, match=r"^bare\.h5: found .*\((ValueError|KeyError|OSError): (a link instead of|numbers of)"
    ):
        read(changed(content, change))


def huge(file):
    del file["entry/raw/depth"]
    file["entry/raw"].create_dataset("depth", shape=(1 << 40,), dtype="f8", chunks=(1024,))


def unwritten(file):
    del file["entry/raw/depth"]
    file["entry/raw"].create_dataset("depth", shape=(3,), dtype="f8")


def shorter(file):
    origin = dict(file["entry/raw/depth"].attrs)
    del file["entry/raw/depth"]
    file["entry/raw/depth"] = [1.0, 2.0]
    file["entry/raw/depth"].attrs.update(origin)


def no_unit(file):
    file["entry/raw/depth"].attrs["units"] = "clicks!"


def no_entry(file):
    del file["entry/raw"]


def no_manifest(file):
    file["entry/manifest/data"][()] = "{"


def to_come(file):
    file["entry/archived/format"][()] = "tribopipe.archive/9"


@pytest.mark.parametrize("change", [huge, unwritten, no_entry, no_manifest])
def test_what_is_no_whole_file_is_refused(content, change):
    with pytest.raises((ValueError, KeyError)):
        fields(changed(content, change))


@pytest.mark.slow
@pytest.mark.parametrize("change", [shorter, no_unit, to_come])
def test_what_is_no_whole_run_is_refused(content, change):
    with pytest.raises(ReaderError, match=r"^bare\.h5: found .*; expected a run archived by tribopipe"):
        read(changed(content, change))


def test_a_manifest_with_odd_parts_gives_what_it_can(content):
    def odd(file):
        file["entry/manifest/data"][()] = json.dumps({"title": "t", "conditions": {"friction": None}, "contact": 3})

    assert read(changed(content, odd)).facts == {"title": "t"}


@settings(max_examples=60, deadline=None)
@given(st.data())
def test_cut_anywhere_it_is_refused(content, data):
    size = data.draw(st.integers(0, len(content) - 1))
    with pytest.raises(ReaderError, match=r"^bare\.h5: found (no HDF5|\d+ bytes of)"):
        read(content[:size])
