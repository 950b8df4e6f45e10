"""Logs of an Rtec MFT: a lone CR in the first line, columns in any order, TotalTime at the end."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from read_tables import column, read_or_refused, values

from tribopipe.base.errors import ReaderError
from tribopipe.readers.delimited import DelimitedReader
from tribopipe.readers.formats.rtec import RtecReader
from tribopipe.readers.reader import Hints, Reader, ReadTable
from tribopipe.results.run import SourceFile

READER = RtecReader()
NAMES = ["Step", "Timestamp", "RecipeStep", "DAQ.Fz (N)", "DAQ.Fx (N)", "DAQ.COF ()", "XYZ.Z Depth (mm)"]
ROWS = [
    ["1", "0.00", "1", "5.0213", "-1.1046", "0.21998", "0.01301"],
    ["1", "0.01", "1", "5.0190", "-1.1052", "0.22020", "0.01312"],
    ["3", "0.00", "2", "10.0371", "2.3085", "0.22999", "0.01420"],
    ["3", "0.01", "2", "10.0402", "2.3110", "0.23017", "0.01417"],
]
TOP = b"RecipeName,Operator,Comments\rStribeck 25C,Ana,2 drops\r\n"
FOOT = b"\nTotalTime\n00:01:08.2500000\n"


def write(names: list[str] = NAMES, rows: list[list[str]] = ROWS, top: bytes = TOP, foot: bytes = FOOT) -> bytes:
    header = ", ".join(names[:4]) + "," + ",".join(names[4:]) + "\r\n"
    return top + header.encode() + "".join(",".join(row) + ",\n" for row in rows).encode() + foot


SMALL = write()
TRUTH = np.array(ROWS, dtype=float)


def read(content: bytes, **hints: str) -> ReadTable:
    return READER.read(SourceFile("LOG.csv", content), Hints(**hints))


def test_small_file():
    assert isinstance(READER, Reader)
    table = read(SMALL)
    assert {each.name: (each.signal, each.unit) for each in table.columns} == {
        "Step": (None, None),
        "Timestamp": ("time", "s"),
        "RecipeStep": (None, None),
        "DAQ.Fz (N)": ("normal_force", "N"),
        "DAQ.Fx (N)": ("friction_force", "N"),
        "DAQ.COF ()": ("friction_coefficient", None),
        "XYZ.Z Depth (mm)": ("depth", "mm"),
    }
    assert np.array_equal(values(table), TRUTH)
    assert table.notes == ()
    assert table.header.encode() == SMALL[: SMALL.index(b"1,0.00")] + FOOT
    assert table.facts == {"operator": "Ana", "comment": "2 drops"}


MORE = [*NAMES, "Rotary.Velocity (rpm)", "XYZ.Z Position (mm)", "DAQ.Temp (C)"]


@settings(max_examples=40, deadline=None)
@given(st.permutations(range(len(MORE))), st.sampled_from(["\n", "\r\n", "\r"]), st.booleans())
def test_columns_in_any_order_and_choice(order, end, trailing):
    rows = [[*row, "60.1", "-3.5", "23.1"] for row in ROWS]
    content = write([MORE[n] for n in order], [[row[n] for n in order] for row in rows])
    content = content if trailing else content.replace(b",\n", b"\n")
    table = read(content.replace(b"\r\n", b"\n").replace(b"\n", end.encode()))
    assert np.array_equal(values(table), np.array(rows, dtype=float)[:, order])
    assert column(table, "XYZ.Z Depth (mm)").signal == "depth"
    assert column(table, "XYZ.Z Position (mm)").signal is None
    assert column(table, "DAQ.Temp (C)").unit == "degC"
    assert table.notes == ()


@pytest.mark.parametrize(
    ("names", "meant"),
    [
        (["DAQ.COF (Fx)", "DAQ.COF (Fy)"], "DAQ.COF (Fx)"),
        (["DAQ.COF (Fy)", "DAQ.COF (Fx)"], "DAQ.COF (Fx)"),
        (["DAQ.COF (Fy)", "DAQ.Fy (N)"], "DAQ.COF (Fy)"),
        (["DAQ.Fy (N)", "DAQ.COF()"], "DAQ.COF()"),
    ],
)
def test_one_friction_coefficient(names, meant):
    table = read(write([*NAMES[:5], *names]))
    assert [each.name for each in table.columns if each.signal == "friction_coefficient"] == [meant]


def test_a_depth_that_is_no_length_has_no_meaning():
    assert column(read(write([*NAMES[:6], "XYZ.Z Depth (V)"])), "XYZ.Z Depth (V)").signal is None


@pytest.mark.parametrize("top", [b"", b"RecipeName,Date\r\n", b"Stribeck\r1,2,3\r\n", b"\r\r\n"])
def test_first_line_may_be_missing_or_odd(top):
    content = write(top=top)
    assert np.array_equal(values(read(content)), TRUTH)
    assert READER.match(SourceFile("LOG.csv", content)).confidence >= 0.9


@pytest.mark.parametrize("foot", [b"", b"\n", b"\nTotalTi", b"\nTotalTime\n", b"\nTotalTime\n00:01"])
def test_a_missing_end_is_noted(foot):
    table = read(write(foot=foot))
    assert np.array_equal(values(table), TRUTH)
    assert table.notes == ("TotalTime is missing below the data, so the file may be truncated",)


def test_anything_else_below_the_rows_is_refused():
    with pytest.raises(ReaderError, match=r"^LOG\.csv, line 8: found 'Aborted"):
        read(SMALL.replace(b"\nTotalTime", b"Aborted,by,user\n"))
    with pytest.raises(ReaderError, match=r"^LOG\.csv, line 9: found 'TotalTime 00:01:08.2500000 4 0.01"):
        read(SMALL + b"4,0.01,2,10.0402,2.3110,0.23017,0.01417,\n")


def test_row_with_too_few_fields_is_named():
    with pytest.raises(ReaderError, match=r"line 5: found \d fields, expected"):
        read(SMALL.replace(b"5.0190,-1.1052,0.22020,", b""))


def test_a_field_that_is_no_number_is_named():
    assert column(read(SMALL.replace(b"5.0190", b"5.0.1")), "DAQ.Fz (N)").first_bad == (5, "5.0.1")


def test_decimal_commas_between_semicolons():
    lines = SMALL.split(b"\n")
    content = b"\n".join([lines[0], *(line.replace(b",", b";").replace(b".", b",") for line in lines[2:6])])
    header = ";".join(NAMES).encode() + b"\r\n"
    table = read(TOP + header + content.split(b"\n", 1)[1] + FOOT)
    assert np.array_equal(values(table), TRUTH)


@pytest.mark.slow
def test_cut_at_every_byte():
    for size in range(len(SMALL)):
        table = read_or_refused(READER, "LOG.csv", SMALL[:size])
        if table is not None:
            found = values(table)
            assert np.array_equal(found, TRUTH[: len(found)]), size
            assert len(found) == len(TRUTH) or table.notes, size


@settings(max_examples=60, deadline=None)
@given(st.integers(0, len(SMALL) - 1), st.binary(max_size=4))
def test_whatever_bytes_are_put_in_nothing_but_reader_errors_is_raised(at, put):
    read_or_refused(READER, "LOG.csv", SMALL[:at] + put + SMALL[at:])


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "cp1252"])
def test_encodings(encoding):
    content = SMALL.decode().replace("Ana", "Zoë").encode(encoding)
    assert np.array_equal(values(read(content)), TRUTH)
    assert READER.match(SourceFile("LOG.csv", content)).confidence >= 0.9


@pytest.mark.parametrize("content", [b"", b" \r\n\t\r\n", b"\0\1", TOP, write(rows=[]), b"1,2\n3,4\n"])
def test_no_table(content):
    with pytest.raises(ReaderError, match=r"^LOG\.csv"):
        read(content)


@pytest.mark.parametrize("size", [200, len(SMALL)])
def test_found_by_content(size):
    source = SourceFile("x.txt", SMALL[:size])
    assert READER.match(source).confidence > max(0.9, DelimitedReader().match(source).confidence)


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"\0\1\2",
        b"Timestamp,Force (N)\n1,2\n",
        b"Timestamp,Rig.Force (N)\n1,2\n",
        b"Step,Fz (N),DAQ.Fz (N)\n1,2,3\n",
        SMALL[:90],
        SMALL[len(TOP) :].replace(b"\n", b"\nand then\n"),
        b"About files:\n" * 9 + SMALL,
    ],
)
def test_other_files_are_left_alone(content):
    assert READER.match(SourceFile("x.csv", content)).confidence < 0.5


KNOWN = "Recipe, UpperSample, Type, Radius,TestDate, Operator, Temperature, Liquid, LastCalibDate, LCFz"


@pytest.mark.parametrize(
    ("tested", "calibrated", "started"),
    [
        ("9/22/2026 3:42:07 AM", "6/11/2026 1:22:52 PM", "2026-09-22T03:42:07"),
        ("22.09.2026 15:42", "06.11.2026 13:22", "2026-09-22T15:42:00"),
        ("9/2/2026 12:42:07 PM", "6/21/2026 1:22:52 PM", "2026-09-02T12:42:07"),
        ("9/2/2026 3:42:07 AM", "6/11/2026 1:22:52 PM", None),
        ("", "6/21/2026 1:22:52 PM", None),
    ],
)
def test_date_of_the_test_is_taken_where_day_and_month_are_certain(tested, calibrated, started):
    values = f"trial.Rx,,Reciprocating,1,{tested},Ana,,N/A,{calibrated},200N"
    rows = "Step, Timestamp, DAQ.Fz (N),DAQ.COF (Fx),\n1,0.011,2.002,0.007,\n1,0.021,2.005,0.008,\n"
    table = read(f"{KNOWN}\r{values},,\r\n{rows}\nTotalTime\n00:00:00.02\n".encode())
    expected = {"operator": "Ana"} | ({"started": started} if started else {})
    assert table.facts == expected
    assert any("order of day and month is ambiguous" in note for note in table.notes) == bool(tested and not started)
