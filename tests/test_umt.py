"""Exports of a CETR / Bruker UMT: steps one below the other, or a refusal, whatever stands between them."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from read_tables import column, read_or_refused, values

from tribopipe.base.errors import ReaderError
from tribopipe.readers.delimited import DelimitedReader
from tribopipe.readers.formats.umt import UmtReader
from tribopipe.readers.reader import Hints, Reader, ReadTable
from tribopipe.results.run import SourceFile

READER = UmtReader()
NAMES = ["Fx", "Fz", "Z", "T", "Ff", "COF"]
UNITS = ["g", "g", "mm", "sec", "g", ""]
STEPS = [
    [
        ["7.683862", "-198.963455", "-0.6908", "0.0000", "7.683862", "0.038619"],
        ["-68.727264", "-198.801712", "-0.6850", "0.1527", "68.727264", "0.345708"],
        ["-93.483627", "-199.036194", "-0.6850", "0.1727", "93.483627", "0.469682"],
    ],
    [
        ["105.181290", "-199.807526", "-0.6380", "0.0000", "105.181290", "0.526413"],
        ["136.519547", "-200.131958", "-0.6369", "0.0177", "136.519547", "0.682148"],
    ],
]
TOP = [
    "Created by CETR Data Viewer ver.2.19.106 05/12/22 14:43:46",
    "Created by CETR UMT ver.1.136.257 12 May 2022 12:21:50",
    "Total number of runs - 1",
    "Total number of steps = 2",
    "Indenter tip ID = 0",
    r"C:\Data\wear 2N_001.tst",
    "",
    "Run # 1",
    "Run date 12 May 2022 12:21:50",
]


def write(
    steps: list[list[list[str]]] = STEPS,
    names: list[str] = NAMES,
    units: list[str] = UNITS,
    separator: str = ",",
    end: str = "\r\n",
) -> bytes:
    lines = list(TOP)
    for number, rows in enumerate(steps, 1):
        lines += [f"Step No. {number}", "", "Step Type Code: 0", "Radius       = 3.9493", "Set Force    = -200"]
        lines += [f"Data Count   = {len(rows)}", f"Started at: 12:21:58.0{number} 12 May 2022", ""]
        lines += [separator.join(names), separator.join(units), ""]
        lines += [separator.join(row) for row in rows] + ["", ""]
    return "".join(line + end for line in lines).encode()


SMALL = write()


def read(content: bytes, **hints: str) -> ReadTable:
    return READER.read(SourceFile("wear.csv", content), Hints(**hints))


def expected(steps: list[list[list[str]]] = STEPS) -> np.ndarray:
    return np.array([[*map(float, row), n] for n, rows in enumerate(steps, 1) for row in rows])


def test_two_steps_one_below_the_other():
    assert isinstance(READER, Reader)
    table = read(SMALL)
    assert [each.name for each in table.columns] == [*NAMES, "segment"]
    assert np.array_equal(values(table), expected())
    assert table.notes == ()
    assert table.header == "".join(line + "\r\n" for line in SMALL.decode().split("\r\n")[:-1] if not _is_row(line))


def _is_row(line: str) -> bool:
    return line.split(",")[0] in {row[0] for rows in STEPS for row in rows}


def test_meanings_and_units():
    assert {each.name: (each.signal, each.unit) for each in read(SMALL).columns} == {
        "Fx": (None, "gf"),
        "Fz": ("normal_force", "gf"),
        "Z": ("depth", "mm"),
        "T": ("time", "sec"),
        "Ff": ("friction_force", "gf"),
        "COF": ("friction_coefficient", None),
        "segment": (None, "1"),
    }


def test_without_ff_the_friction_force_is_fx():
    steps = [[row[:4] for row in rows] for rows in STEPS]
    table = read(write(steps, NAMES[:4], UNITS[:4]))
    assert column(table, "Fx").signal == "friction_force"


def test_time_only_in_a_unit_of_time():
    table = read(write(units=["N", "N", "um", "C", "N", ""]))
    assert column(table, "T").signal is None
    assert [column(table, name).unit for name in ("Fx", "Z")] == ["N", "um"]


def test_facts():
    assert read(SMALL).facts == {
        "instrument": "CETR UMT",
        "started": "2022-05-12T12:21:58",
        "conditions.normal_load": "200 gf",
    }
    changed = SMALL.replace(b"-200\r\nData Count   = 2", b"-500\r\nData Count   = 2")
    assert "conditions.normal_load" not in read(changed).facts
    assert "conditions.normal_load" not in read(SMALL.replace(b"= -200", b"= -5")).facts


def test_dates_of_another_language_are_left_to_the_lab():
    table = read(SMALL.replace(b" May ", b" Mai ").replace(b" Mai 2022", b" maj 2022"))
    assert "started" not in table.facts
    assert any("the start time of the test" in note for note in table.notes)


@pytest.mark.parametrize("separator", [",", "\t", ";", "  ", " "])
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r", "\r\r\n"])
@pytest.mark.parametrize("units", [UNITS, ["[g]", "[g]", "[mm]", "[sec]", "[g]", "[]"], ["N", "N", "mm", "s", "N", ""]])
def test_dialects(separator, end, units):
    table = read(write(units=units, separator=separator, end=end))
    assert np.array_equal(values(table), expected())
    assert {column(table, name).signal for name in ("Fz", "T", "Z")} == {"normal_force", "time", "depth"}
    assert column(table, "Fz").unit == ("N" if "N" in units else "gf")


@pytest.mark.parametrize("separator", ["\t", "  "])
def test_units_in_the_names_and_decimal_commas(separator):
    names = ["Fx [N]", "Fz [N]", "Z [mm]", "T [sec]", "Ff [N]", "COF"]
    content = write(names=names, units=[], separator=separator)
    lines = [
        line.replace(b".", b",") if line[:1].isdigit() or line[:1] == b"-" else line for line in content.split(b"\n")
    ]
    table = read(b"\n".join(lines))
    assert [each.name for each in table.columns] == [*names, "segment"]
    assert column(table, "Fz [N]").signal == "normal_force"
    assert column(table, "Fz [N]").unit == "N"
    assert np.array_equal(values(table), expected())


@settings(max_examples=40, deadline=None)
@given(st.permutations(range(6)), st.sampled_from([",", "\t"]))
def test_columns_in_any_order(order, separator):
    steps = [[[row[n] for n in order] for row in rows] for rows in STEPS]
    table = read(write(steps, [NAMES[n] for n in order], [UNITS[n] for n in order], separator))
    assert np.array_equal(values(table)[:, :6], expected()[:, order])
    assert column(table, "T").signal == "time"


def test_head_that_repeats_and_other_columns_in_the_second():
    other = write([[row[:4] for row in STEPS[1]]], NAMES[:4], UNITS[:4])
    table = read(SMALL + other)
    assert column(table, "segment").values.tolist() == [1, 1, 1, 2, 2, 3, 3]
    assert np.isnan(column(table, "COF").values[-2:]).all()
    assert np.array_equal(column(table, "Fx").values[-2:], expected()[3:, 0])


def test_a_unit_that_changes_is_refused():
    with pytest.raises(ReaderError, match=r"^wear\.csv, column 'Fx': found the units N, g in different segments"):
        read(SMALL + write(units=["N", "N", "mm", "sec", "N", ""]))


def test_numbers_without_names_are_refused():
    content = SMALL.replace(b"Fx,Fz,Z,T,Ff,COF\r\ng,g,mm,sec,g,\r\n\r\n105", b"105")
    with pytest.raises(ReaderError, match=r"^wear\.csv, line 34: found data with no header line"):
        read(content)


def test_row_with_too_few_fields_is_named():
    with pytest.raises(ReaderError, match=r"line 23: found 5 fields, expected 6"):
        read(SMALL.replace(b"-0.6850,0.1727,", b"-0.6850,"))


def test_a_field_that_is_no_number_is_named():
    assert column(read(SMALL.replace(b"-0.6369", b"8.0.1")), "Z").first_bad == (38, "8.0.1")


@pytest.mark.parametrize(("blank", "line"), [(b"", 38), (b"\r\n\r\n", 40)])
def test_a_word_before_the_last_row_is_named(blank, line):
    with pytest.raises(ReaderError, match=rf"^wear\.csv, line {line}: found 'x136\.519547' at the beginning of a row"):
        read(SMALL.replace(b"136.519547", blank + b"x136.519547", 1))


def test_a_quotation_mark_and_a_long_word_before_the_last_row_are_refused():
    long = b'"' + b"x" * 140_000
    with pytest.raises(ReaderError, match=r"^wear\.csv, line 38: found a field of more than 131,072 characters"):
        read(SMALL.replace(b"136.519547", long + b"136.519547", 1))


def test_not_a_number_is_no_word():
    table = read(SMALL.replace(b"\r\n-68.727264", b"\r\nNaN"))
    assert np.isnan(column(table, "Fx").values[1])
    assert len(column(table, "T").values) == 5


def test_counts_that_rows_do_not_keep_are_noted():
    table = read(SMALL.replace(b"Data Count   = 3", b"Data Count   = 110").replace(b"steps = 2", b"steps = 4"))
    assert "the numbers of rows differ from those in the header: segment 1 declares 110 and contains 3" in table.notes
    assert "the header declares 4 steps; 2 of them contain data" in table.notes


def test_a_step_that_repeats_the_one_before_is_noted():
    assert read(write([STEPS[0], STEPS[0]])).notes == ("segments identical to the one before: 2",)


@pytest.mark.slow
def test_cut_at_every_byte():
    content = SMALL
    truth = expected()
    for size in range(len(content)):
        table = read_or_refused(READER, "wear.csv", content[:size])
        if table is not None:
            found = values(table)
            assert np.array_equal(found, truth[: len(found)]), size
            assert len(found) == len(truth) or table.notes, size


@settings(max_examples=60, deadline=None)
@given(st.integers(0, len(SMALL) - 1), st.binary(max_size=4))
def test_whatever_bytes_are_put_in_nothing_but_reader_errors_is_raised(at, put):
    read_or_refused(READER, "wear.csv", SMALL[:at] + put + SMALL[at:])


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "cp1252"])
def test_encodings(encoding):
    content = SMALL.decode().replace("wear 2N", "Reibung für 2N").encode(encoding)
    assert np.array_equal(values(read(content)), expected())
    assert READER.match(SourceFile("wear.csv", content)).confidence >= 0.9


def test_encoding_named_wrongly():
    with pytest.raises(ReaderError, match=r"^wear\.csv: found byte"):
        read(SMALL.replace(b"wear", b"Verschlei\xdf"), encoding="utf-8")


@pytest.mark.parametrize(
    "content", [b"", b" \r\n\t\r\n", b"\0\1", b"Fx,Fz,T\n", "\n".join(TOP).encode(), b"1,2\n3,4\n"]
)
def test_no_table(content):
    with pytest.raises(ReaderError, match=r"^wear\.csv"):
        read(content)


@pytest.mark.parametrize("size", [1_000_000, pytest.param(100_000_000, marks=pytest.mark.slow)])
def test_one_line_without_end(size):
    content = SMALL[: SMALL.index(b"7.68")] + b"7" * size
    assert READER.match(SourceFile("wear.csv", content)).confidence in (0.0, 0.95)
    with pytest.raises(ReaderError, match="characters in one line"):
        read(content)


@pytest.mark.parametrize("size", [80, 400, len(SMALL)])
def test_found_by_content(size):
    source = SourceFile("x.dat", SMALL[:size])
    assert READER.match(source).confidence > max(0.9, DelimitedReader().match(source).confidence)


def test_found_without_its_first_lines():
    assert READER.match(SourceFile("x.dat", SMALL[SMALL.index(b"Step No. 1") :])).confidence >= 0.9


@pytest.mark.parametrize(
    "content",
    [b"", b"\0\1\2", b"Time [s];Fz [N]\n0,5;1,5\n", b"Fx,Fz,T\n1,2,3\n2,3,4\n", b"Created by hand\nTime;Fz\n1;2\n"],
)
def test_other_files_are_left_alone(content):
    assert READER.match(SourceFile("x.csv", content)).confidence < 0.5
