"""Dektak scans: read by the format's definition, or refused where they are cut."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tribopipe.base.errors import ReaderError
from tribopipe.readers.delimited import DelimitedReader
from tribopipe.readers.formats.dektak import DektakReader
from tribopipe.readers.reader import Hints, Reader, ReadTable
from tribopipe.results.run import SourceFile

READER = DektakReader()
HEADER = (
    "Scan Parameters\r\r\n"
    "Scan Type,Standard Scan\r\n"
    "Stylus,Radius: 2.5 µm\r\n"
    "Resolution,0.156 um/sample\r\n"
    "\r\r\n"
    "Analytical Results\r\r\n"
    "Function,R.Cur Pos,R.Cur Width,M.Cur Pos,M.Cur Width,Result\r\n"
    "Ra,468.0 um,0.0 um,733.0 um,0.0 um,0.00525 um\r\n"
    "\r\r\n"
    "Scan Data\r\r\n"
    "Lateral um,Raw Micrometer,\r\n"
)
ROWS = "0.0,-0.00933,,\r\n0.2,-0.00760,,\r\n0.3,0.12345,,\r\n0.5,16.58112,,\r\n"
SMALL = (HEADER + ROWS + "\r\r\n").encode("cp1252")
VALUES = np.array([[0.0, -0.00933], [0.2, -0.0076], [0.3, 0.12345], [0.5, 16.58112]])


def read(content: bytes, **hints: str) -> ReadTable:
    return READER.read(SourceFile("scan.csv", content), Hints(**hints))


def numbers(table: ReadTable) -> np.ndarray:
    return np.column_stack([column.values for column in table.columns])


def test_is_a_reader():
    assert isinstance(READER, Reader)
    assert READER.holds == "profile"


def test_small_scan():
    table = read(SMALL)
    x, z = table.columns
    assert (x.name, x.unit, x.axis, x.signal) == ("Lateral um", "um", "x", None)
    assert (z.name, z.unit, z.axis, z.signal) == ("Raw Micrometer", "micrometer", "z", None)
    np.testing.assert_array_equal(numbers(table), VALUES)
    assert "Radius: 2.5 µm" in table.header
    assert table.header.endswith("Lateral um,Raw Micrometer,\r\n")
    assert any("cp1252" in note for note in table.notes)


@pytest.mark.parametrize(
    ("names", "units"),
    [
        ("Lateral um,Raw Angstrom,", ["um", "angstrom"]),
        ("Lateral(mm),Raw(nm),", ["mm", "nm"]),
        ("Lateral um,Raw Å,", ["um", "angstrom"]),
        ("Lateral um,Raw furlongish,", ["um", None]),
    ],
)
def test_units_stand_at_the_end_of_names(names, units):
    table = read(SMALL.decode("cp1252").replace("Lateral um,Raw Micrometer,", names).encode())
    assert [column.unit for column in table.columns] == units


def test_of_several_heights_the_raw_ones_are_taken():
    header = HEADER.replace("Lateral um,Raw Micrometer,", "Lateral um,Analyzed Micrometer,Raw Micrometer,")
    table = read((header + "0.0,1.0,2.0,,\r\n0.2,1.5,2.5,,\r\n").encode())
    assert [column.axis for column in table.columns] == ["x", None, "z"]


def test_scan_that_vision64_wrote_without_parameters():
    content = "\ufeff\r\n\r\nData\r\nLateral(µm),Raw(nm),,\r\n0,3.8152,,\r\n0.0941276,8.68561,,\r\n0.18826,-9.8,,\r\n"
    source = SourceFile("step.csv", content.encode())
    assert READER.match(source).confidence > max(0.9, DelimitedReader().match(source).confidence)
    table = READER.read(source, Hints())
    assert [(column.axis, column.unit) for column in table.columns] == [("x", "µm"), ("z", "nm")]
    np.testing.assert_array_equal(numbers(table), [[0, 3.8152], [0.0941276, 8.68561], [0.18826, -9.8]])


@pytest.mark.parametrize("end", ["\n", "\r", "\r\n"])
def test_any_line_ends_and_encodings(end):
    text = (HEADER + ROWS).replace("\r\r\n", "\n").replace("\r\n", "\n").replace("\n", end)
    for encoding in ("utf-8", "cp1252", "utf-16"):
        np.testing.assert_array_equal(numbers(read(text.encode(encoding))), VALUES)
        assert READER.match(SourceFile("a", text.encode(encoding))).confidence >= 0.9


def test_rows_that_close_without_separators():
    np.testing.assert_array_equal(numbers(read((HEADER + ROWS.replace(",,", "")).encode())), VALUES)


@settings(max_examples=150)
@given(st.integers(0, len(SMALL)))
def test_cut_anywhere_it_is_right_or_refused(size):
    try:
        found = numbers(read(SMALL[:size]))
    except ReaderError:
        return
    np.testing.assert_array_equal(found, VALUES[: len(found)])


def test_row_without_its_end_is_named():
    with pytest.raises(ReaderError, match=r"line \d+: found 2 fields, expected 4; the file ends in"):
        read(SMALL.replace(b"16.58112,,\r\n\r\r\n", b"16.58"))


@pytest.mark.parametrize(
    "content", [b"", HEADER.encode(), SMALL.replace(b"Scan Data", b"Scan"), ROWS.encode(), b"\0\1\2"]
)
def test_no_scan_is_refused(content):
    with pytest.raises(ReaderError, match=r"^scan\.csv"):
        read(content)


def test_found_by_content_above_plain_tables():
    for size in (len(HEADER) + 40, len(SMALL)):
        source = SourceFile("scan.txt", SMALL[:size])
        assert READER.match(source).confidence >= 0.9 > DelimitedReader().match(source).confidence


@pytest.mark.parametrize(
    "content", [b"", b"\0\1", b"Time,Depth\n1,2\n", b"x" * (1 << 18), b"Scan Data\nTime,Depth\n1,2\n", ROWS.encode()]
)
def test_other_files_are_left_alone(content):
    assert READER.match(SourceFile("a.csv", content)).confidence <= 0.2
