"""Bare columns of positions and heights, in whatever dialect."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tribopipe.base.errors import ReaderError
from tribopipe.readers.formats.points import PointsReader
from tribopipe.readers.reader import Hints, Reader, ReadTable
from tribopipe.results.run import SourceFile

READER = PointsReader()
PROFILE = [(0.0, 3.25), (0.1, -4.5), (0.25, 5.75), (0.4, 6.5)]
MAP = [(x / 10, y / 5, 10 * y + x) for y in range(3) for x in range(4)]
DIALECTS = {
    "tab": ("\t", "."),
    "tab, comma": ("\t", ","),
    "semicolon, comma": (";", ","),
    "comma": (",", "."),
    "comma, padded": (",   ", "."),
    "blanks": ("   ", "."),
    "blanks, comma": (" ", ","),
}


def written(points, separator="\t", decimal=".", end="\n", head="") -> bytes:
    rows = [separator.join(f"{number:.4f}".replace(".", decimal) for number in point) for point in points]
    return (head + "".join(row + end for row in rows)).encode()


def read(content: bytes, **hints: str) -> ReadTable:
    return READER.read(SourceFile("p.txt", content), Hints(**hints))


def confidence(content: bytes) -> float:
    return READER.match(SourceFile("p.txt", content)).confidence


def numbers(table: ReadTable) -> np.ndarray:
    return np.column_stack([column.values for column in table.columns])


def test_is_a_reader():
    assert isinstance(READER, Reader)
    assert READER.holds == "profile"


@pytest.mark.parametrize("dialect", DIALECTS)
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize("points", [PROFILE, MAP], ids=["profile", "map"])
def test_any_dialect(dialect, end, points):
    content = written(points, *DIALECTS[dialect], end)
    table = read(content)
    np.testing.assert_allclose(numbers(table), points, rtol=0, atol=1e-12)
    assert [column.axis for column in table.columns] == [["x", "z"], ["x", "y", "z"]][len(points[0]) - 2]
    assert {column.unit for column in table.columns} == {None}
    assert table.header == ""
    assert confidence(content) == 0.6


@pytest.mark.parametrize(
    ("head", "units"),
    [
        ("µm µm\n4\n", ["µm", "µm"]),
        ("[mm]\t[um]\n", ["mm", "um"]),
        ("mm;nm\n", ["mm", "nm"]),
        ("4\nmm um\n", ["mm", "um"]),
    ],
)
def test_lines_of_units_and_of_the_number_of_points(head, units):
    content = written(PROFILE, ";" if ";" in head else "\t", head=head)
    table = read(content)
    assert [column.unit for column in table.columns] == units
    assert (table.header, table.notes) == (head, ())
    assert confidence(content) == 0.9


def test_another_number_of_points_than_said_is_noted():
    assert read(written(PROFILE, head="23\n")).notes == ("the header states 23 points; the file contains 4",)


def test_blanks_behind_and_blank_lines_at_the_end():
    content = b"0  1.3718306e-09            \n1.6655563e-08  1.3122408e-09            \n3e-8 1e-9 \n\n\n"
    assert numbers(read(content)).tolist() == [[0.0, 1.3718306e-09], [1.6655563e-08, 1.3122408e-09], [3e-8, 1e-9]]
    assert confidence(content) == 0.6


def test_points_that_were_not_measured():
    table = read(b"0.0\t1.5\n0.1\tNaN\n0.2\t2.5\n")
    assert np.isnan(table.columns[1].values).tolist() == [False, True, False]


@pytest.mark.slow
@pytest.mark.parametrize("points", [PROFILE, MAP], ids=["profile", "map"])
def test_cut_at_every_byte(points):
    content = written(points, head="µm " * (len(points[0]) - 1) + "nm\n")
    for size in range(len(content)):
        try:
            table = read(content[:size])
        except ReaderError:
            continue
        if any(column.first_bad for column in table.columns):  # which is refused as soon as it is used
            continue
        found = numbers(table)
        if not np.array_equal(found, np.array(points)[: len(found)]):
            assert any("no line end" in note for note in table.notes)
            np.testing.assert_array_equal(found[:-1], np.array(points)[: len(found) - 1])


@settings(max_examples=60)
@given(
    st.lists(st.tuples(st.floats(-1e6, 1e6), st.floats(-1e6, 1e6)), min_size=1, max_size=8),
    st.sampled_from(["\t", " ", ";"]),
)
def test_written_numbers_come_back_exactly(points, separator):
    content = "".join(f"{x!r}{separator}{z!r}\n" for x, z in points).encode()
    assert np.array_equal(numbers(read(content, decimal=".")), np.array(points))


SIGNALS = {
    "named": b"Time [s],Depth [um]\n0.1,2.5\n0.2,2.6\n0.3,2.6\n",
    "units of signals": b"s N\n0.1 2.5\n0.2 2.6\n0.3 2.6\n",
    "seven columns": b"6.03;0.04;-0.1;-0.3;499.6;0.08;0.05\n" * 9,
    "four columns": b"0.1\t1\t2\t3\n0.2\t1\t2\t3\n0.3\t1\t2\t3\n",
    "parameters above": b"0.05\t0.001\t0.7\n" + b"6.03;0.04;-0.1;-0.3\n" * 9,
    "time, load and friction": b"".join(b"%.1f 5.01 0.%d\n" % (i / 10, 300 + i) for i in range(50)),
    "a force there and back": b"".join(b"%.3f %.3f\n" % (np.sin(i), i) for i in range(50)),
    "one column": b"1.5\n2.5\n3.5\n",
    "integers between commas": b"1,5\n2,5\n3,7\n",
    "rows of unequal length": b"1 2\n3 4\n5 6 7\n8 9\n",
    "words within": b"0.1 1.5\n0.2 2.5\nStep 2\n0.3 3.5\n",
    "empty": b"",
    "binary": bytes(range(256)),
    "two rows": b"0.1 1.5\n0.2 2.5\n",
    "one endless line": b"1 " * (1 << 19),
}


@pytest.mark.parametrize("what", SIGNALS)
def test_what_are_no_points_is_left_alone(what):
    assert confidence(SIGNALS[what]) <= 0.2


@pytest.mark.parametrize("what", ["named", "units of signals", "seven columns", "one column", "empty", "words within"])
def test_what_are_no_points_is_refused(what):
    with pytest.raises(ReaderError, match=r"^p\.txt"):
        read(SIGNALS[what])


def test_what_can_be_read_in_two_ways_is_refused():
    with pytest.raises(ReaderError, match="the comma may be a column separator or a decimal comma"):
        read(SIGNALS["integers between commas"])
    with pytest.raises(ReaderError, match="thousands"):
        read(b"1;1.500\n2;2.500\n3;12\n")
    assert numbers(read(b"1;1,500\n2;2,500\n3;12\n", decimal=",")).tolist() == [[1, 1.5], [2, 2.5], [3, 12]]


def test_row_in_the_middle_that_lacks_a_number_is_named():
    rows = [b"%.2f\t%.3f\n" % (i / 100, i / 7) for i in range(400)]
    rows[350] = b"3.50\n"
    with pytest.raises(ReaderError, match="line 351: found 1 field, expected 2"):
        read(b"".join(rows))
    rows[350] = b"3.50\tBAD\n"
    assert read(b"".join(rows)).columns[1].first_bad == (351, "BAD")


def test_scan_lines_longer_than_a_sample_of_lines():
    lines = [b"%.3f\t%.1f\t%.4f\n" % (x / 100, y, x * y / 1e3) for y in range(3) for x in range(500)]
    assert confidence(b"".join(lines)) == 0.6
    assert confidence(b"".join(lines[:499])) <= 0.2
