"""Rotating friction tester on Newport stages: settings in line 1, rows of seven numbers below."""

from pathlib import Path

import numpy as np
import pytest
from small_exports import NEWPORT, check_every_cut, claimed_by, read

from tribopipe.base.errors import ReaderError
from tribopipe.readers.delimited import DelimitedReader
from tribopipe.readers.formats.newport import NewportReader
from tribopipe.readers.reader import Hints, Reader
from tribopipe.results.run import SourceFile

READER = NewportReader()
REAL_DATA = Path(__file__).resolve().parents[2] / "shared" / "realdata" / "newport-rheofriction" / "Motor_oil_glass"


def test_is_a_reader_and_claims_its_files_alone():
    assert isinstance(READER, Reader)
    assert claimed_by(READER) == ["newport-rheofriction"]


@pytest.mark.parametrize("end", [b"\r\n", b"\n", b"\r"])
def test_small_file(end):
    table = read(READER, NEWPORT.replace(b"\r\n", end))
    assert [(column.name, column.unit, column.signal) for column in table.columns] == [
        ("step time", "s", None),
        ("time", "s", "time"),
        ("normal force", "N", "normal_force"),
        ("torque", "N*m", None),
        ("stage height", "um", None),
        ("rotational speed", "rps", None),
        ("adjustment speed", "mm/s", None),
    ]
    assert table.columns[0].values.tolist() == [12.0358, 0.135, 0.2344]
    assert table.columns[4].values.tolist() == [499.72, 495.79, -491.74]
    assert table.header.startswith("0.050\t0.001")
    assert table.facts == {"conditions.normal_load": "2.5 N"}
    assert table.notes == ()


@pytest.mark.slow
def test_cut_anywhere_it_is_right_or_refused():
    check_every_cut(READER, NEWPORT)


def test_last_line_without_an_end_is_kept_where_it_is_whole():
    lines = NEWPORT.splitlines(keepends=True)
    content = b"".join([*lines, *lines[1:] * 4]).removesuffix(b"\r\n")
    assert len(read(READER, content).columns[0].values) == 15
    shorter = read(READER, content[:-1])
    assert len(shorter.columns[0].values) == 14
    assert shorter.notes == ("the last line has no line ending; it is omitted, since it may be truncated",)


def test_a_cut_file_is_not_left_to_another_reader():
    for size in range(130, len(NEWPORT), 9):
        source = SourceFile("x", NEWPORT[:size])
        assert READER.match(source).confidence > DelimitedReader().match(source).confidence


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "empty file"),
        (b"Time;Force\n1;2\n", "expected 16 tab-separated settings"),
        (NEWPORT.splitlines()[0] + b"\r\n", "no data row"),
        (b"\r\n".join(NEWPORT.splitlines()[1:]), "expected 16 tab-separated settings"),
        (NEWPORT.replace(b";0.050000\r\n", b"\r\n"), "found 6 fields, expected 7"),
        (NEWPORT.replace(b";0.889057", b";0.889057;1"), "found 8 fields, expected 7"),
    ],
)
def test_broken_files_are_refused(content, message):
    with pytest.raises(ReaderError, match=message):
        read(READER, content)


def test_a_field_that_is_no_number_is_named():
    assert read(READER, NEWPORT.replace(b"0.001561", b"0,001561")).columns[3].first_bad == (3, "0,001561")


def test_real_files():
    paths = sorted(REAL_DATA.glob("*.txt"))
    if not paths:
        pytest.skip("real data not here: newport-rheofriction")
    rows = 0
    for path in paths:
        source = SourceFile(path.name, path.read_bytes())
        assert READER.match(source).confidence >= 0.9
        table = READER.read(source, Hints())
        assert table.notes == ()
        rows += len(table.columns[0].values)
        load = path.stem.partition("rps")[2].rstrip("N").replace("-", ".")
        assert table.facts["conditions.normal_load"] == f"{float(load):g} N"
        time = table.columns[1].values
        assert np.all(np.diff(time) > 0)
        assert np.median(np.diff(time)) == pytest.approx(0.1, abs=0.005)
    assert (len(paths), rows) == (48, 40_983)
