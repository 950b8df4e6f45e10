"""LabVIEW measurement files: several segments with headers that claim much, and values of x that are not written."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from read_tables import column, read_or_refused, values

from tribopipe.base.errors import ReaderError
from tribopipe.readers.delimited import DelimitedReader
from tribopipe.readers.formats.lvm import LvmReader
from tribopipe.readers.reader import Hints, Reader, ReadTable
from tribopipe.results.run import SourceFile

READER = LvmReader()
REAL_DATA = Path(__file__).resolve().parents[2] / "shared" / "realdata" / "pcs-ehd-labview" / "examples" / "data_import"
ROWS = [
    [["0.000000", "0.211219", "13.157429"], ["0.000143", "0.212512", "13.158075"], ["0.000286", "-0.209925", "13.1"]],
    [["0.000000", "0.313159", "13.258721"], ["0.000143", "0.308631", "13.262599"]],
]
TRUTH = np.array([[*map(float, row), n] for n, rows in enumerate(ROWS, 1) for row in rows])
NAMES = ["X_Value", "Ff", "Fz", "Comment"]


def file_header(columns: str = "One", several: str = "Yes", decimal: str = "Decimal_Separator\t.") -> list[str]:
    return [
        "LabVIEW Measurement\t",
        "Writer_Version\t2",
        "Reader_Version\t2",
        "Separator\tTab",
        *([decimal] if decimal else []),
        f"Multi_Headings\t{several}",
        f"X_Columns\t{columns}",
        "Time_Pref\tAbsolute",
        "Operator\tAna",
        "Date\t2017/09/20",
        "Time\t11:29:14.71157",
        "***End_of_Header***\t",
        "\t",
    ]


def segment_header(samples: int, units: str = "N\tmicrometer", step: str = "0.000143\t0.000143") -> list[str]:
    return [
        "Channels\t2\t\t",
        f"Samples\t{samples}\t{samples}\t",
        "Date\t2017/09/25\t2017/09/25\t",
        "Time\t13:45:59.2289\t13:45:59.2289\t",
        f"Y_Unit_Label\t{units}\t",
        "X_Dimension\tTime\tTime\t",
        "X0\t0.5E+0\t0.5E+0\t",
        f"Delta_X\t{step}\t",
        "***End_of_Header***\t\t",
    ]


def text(lines: list[str], end: str = "\r\n") -> bytes:
    return "".join(line + end for line in lines).encode()


def write(end: str = "\r\n", names: list[str] = NAMES, rows: list[list[list[str]]] = ROWS) -> bytes:
    lines = file_header()
    for part in rows:
        lines += [*segment_header(len(part)), "\t".join(names), *("\t".join(row) for row in part), ""]
    return text(lines, end)


SMALL = write()


def read(content: bytes, **hints: str) -> ReadTable:
    return READER.read(SourceFile("run.lvm", content), Hints(**hints))


def test_two_segments():
    assert isinstance(READER, Reader)
    table = read(SMALL)
    assert [(each.name, each.signal, each.unit) for each in table.columns] == [
        ("X_Value", "time", "s"),
        ("Ff", None, "N"),
        ("Fz", None, "micrometer"),
        ("segment", None, "1"),
    ]
    assert np.array_equal(values(table), TRUTH)
    assert table.notes == ()
    assert table.facts == {"started": "2017-09-25T13:45:59", "operator": "Ana"}
    assert table.header.count("***End_of_Header***") == 3
    assert "13.157429" not in table.header


def test_one_segment_needs_no_number():
    assert [each.name for each in read(write(rows=ROWS[:1])).columns] == ["X_Value", "Ff", "Fz"]


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r", "\r\r\n"])
def test_line_ends(end):
    assert np.array_equal(values(read(write(end))), TRUTH)


def test_separated_by_commas():
    assert np.array_equal(values(read(SMALL.replace(b"\t", b",").replace(b",Tab", b",Comma"))), TRUTH)


@pytest.mark.parametrize("tag", [b"Decimal_Separator\t,", b"-Decimal_Separator,", b""])
def test_decimal_commas(tag):
    content = SMALL.replace(b"Decimal_Separator\t.", b"?").replace(b".", b",").replace(b"?", tag)
    assert np.array_equal(values(read(content)), TRUTH)


def test_claims_that_rows_do_not_keep_are_noted():
    table = read(SMALL.replace(b"Samples\t3\t3", b"Samples\t2000\t2000"))
    assert table.notes == (
        "the numbers of rows differ from those in the header: segment 1 declares 2000 and contains 3",
    )


def test_packets_below_one_header():
    lines = [*file_header(several="No"), *segment_header(2), "\t".join(NAMES)]
    table = read(text([*lines, *("\t".join(row) for row in ROWS[0]), *("\t".join(row) for row in ROWS[1])]))
    assert np.array_equal(values(table), TRUTH[:, :3])
    assert table.notes == ()
    short = read(text([*lines, "\t".join(ROWS[0][0])]))
    assert short.notes == ("the numbers of rows differ from those in the header: segment 1 declares 2 and contains 1",)


def without_x(samples: int, step: str = "0.25\t0.25", several: str = "Yes") -> ReadTable:
    lines = [*file_header("No", several), *segment_header(samples, step=step), "\t".join(NAMES)]
    return read(text([*lines, *("\t" + "\t".join(row[1:]) for row in ROWS[0])]))


def test_values_of_x_are_computed():
    table = without_x(3)
    assert column(table, "X_Value").values.tolist() == [0.5, 0.75, 1.0]
    assert column(table, "X_Value").signal == "time"
    assert np.array_equal(column(table, "Ff").values, TRUTH[:3, 1])
    assert "X_Value is not in the file and is computed as X0 + n Delta_X" in table.notes


@pytest.mark.parametrize("table", [without_x(2, several="No"), without_x(3, "0.25\t0.5"), without_x(3, "fast\tfast")])
def test_computed_values_that_are_not_certain_are_no_time(table):
    assert column(table, "X_Value").signal is None
    assert any("not used as time" in note for note in table.notes)


def with_many_x(second: str) -> ReadTable:
    header = ["Samples\t2\t\t2\t", "Y_Unit_Label\tN\t\tmicrometer\t", "X_Dimension\tTime\t\tTime\t"]
    rows = ["0.0\t1.5\t0.0\t2.5", f"0.1\t1.6\t{second}\t2.6"]
    names = "X_Value\tFf\tX_Value\tdx\tComment"
    return read(text([*file_header("Multi"), *header, "***End_of_Header***\t\t", names, *rows]))


def test_values_of_x_for_each_channel():
    table = with_many_x("0.1")
    assert [(each.name, each.unit, each.signal) for each in table.columns] == [
        ("X_Value", "s", "time"),
        ("Ff", "N", None),
        ("X_Value (2)", "s", None),
        ("dx", "micrometer", None),
    ]
    assert column(table, "dx").values.tolist() == [2.5, 2.6]


def test_channels_with_times_of_their_own_have_none_in_common():
    table = with_many_x("0.2")
    assert column(table, "X_Value").signal is None
    assert any("the channels were sampled at different times" in note for note in table.notes)


def test_seconds_since_1904_are_no_time_since_the_start():
    table = read(SMALL.replace(b"\n0.000", b"\n3588759959.000"))
    assert column(table, "X_Value").signal is None
    assert any("1904" in note for note in table.notes)


def test_x_may_be_no_time():
    table = read(SMALL.replace(b"X_Dimension\tTime\tTime", b"X_Dimension\tFrequency\tFrequency"))
    assert (column(table, "X_Value").signal, column(table, "X_Value").unit) == (None, None)


@pytest.mark.parametrize(
    ("label", "unit"), [("Deg C", "degC"), ("Newtons", "Newtons"), ("NA", None), ("", None), ("x" * 200, None)]
)
def test_labels_of_units_are_free_texts(label, unit):
    content = SMALL.replace(b"Y_Unit_Label\tN\t", f"Y_Unit_Label\t{label}\t".encode())
    assert column(read(content), "Ff").unit == unit


def test_comments_in_some_rows():
    rows = [[[*ROWS[0][0], "LOST"], ROWS[0][1], [*ROWS[0][2], "found 2"]]]
    table = read(write(rows=rows))
    assert column(table, "Comment").values.tolist() == ["LOST", "", "found 2"]
    assert np.array_equal(values(table)[:, :3].astype(float), TRUTH[:3, :3])


def test_special_blocks_are_left_out_and_kept_in_the_header():
    special = b"***Start_Special***\r\n1\t2\t3\r\n***End_Special***\r\n"
    table = read(SMALL.replace(b"Channels", special + b"Channels", 1))
    assert np.array_equal(values(table), TRUTH)
    assert "1\t2\t3\r\n" in table.header
    assert any("Start_Special" in note for note in table.notes)


def test_remarks_are_shown():
    table = read(SMALL.replace(b"Channels", b"Notes\tX values guaranteed valid only for Ff\t\r\nChannels", 1))
    assert "the header states: X values guaranteed valid only for Ff" in table.notes


def test_a_channel_that_comes_later_has_no_values_before():
    table = read(SMALL + write(names=["X_Value", "Ff", "Fx"])[len(text(file_header())) :])
    assert np.isnan(column(table, "Fx").values[:5]).all()
    assert np.array_equal(column(table, "Fx").values[5:], TRUTH[:, 2])
    assert np.isnan(column(table, "Fz").values[5:]).all()


def test_row_with_too_few_fields_is_named():
    with pytest.raises(ReaderError, match=r"^run\.lvm, line 25: found 2 fields, expected 3"):
        read(SMALL.replace(b"0.212512\t", b""))


def test_a_row_of_control_characters_is_named():
    with pytest.raises(ReaderError, match=r"^run\.lvm, line 25: found 1 field, expected 3"):
        read(SMALL.replace(b"\r\n0.000143\t0.212512", b"\r\n\x1d\x1d\r\n0.000143\t0.212512x"))


def test_a_field_that_is_no_number_is_named():
    assert column(read(SMALL.replace(b"0.212512", b"1#QNAN")), "Ff").first_bad == (25, "1#QNAN")


@settings(max_examples=30, deadline=None)
@given(st.permutations(range(1, 3)), st.sampled_from(["\n", "\r\n"]))
def test_columns_in_any_order(order, end):
    order = [0, *order]
    content = write(
        end, [*(NAMES[n] for n in order), "Comment"], [[[row[n] for n in order] for row in r] for r in ROWS]
    )
    table = read(content)
    assert np.array_equal(values(table)[:, :3], TRUTH[:, order])


@pytest.mark.slow
def test_cut_at_every_byte():
    for size in range(len(SMALL)):
        table = read_or_refused(READER, "run.lvm", SMALL[:size])
        if table is not None:
            found = values(table)
            assert np.array_equal(found, TRUTH[: len(found), : found.shape[1]]), size


def test_the_rest_of_an_exponent_is_not_taken_for_a_number():
    content = SMALL.replace(b"0.000143\t0.308631\t13.262599", b"0.000143\t0.308631\t1.953125E-5")
    for size in range(content.index(b"1.953125E"), len(content)):
        assert 1.953125 not in column(read(content[:size]), "Fz").values


def test_rows_lost_at_the_end_are_noted():
    table = read(SMALL[: SMALL.rindex(b"13.262599") + 3])
    assert len(table.columns[0].values) == 4
    assert any("line 39, the last one, has no line ending and is omitted" in note for note in table.notes)
    assert any("segment 2 declares 2 and contains 1" in note for note in table.notes)


@settings(max_examples=60, deadline=None)
@given(st.integers(0, len(SMALL) - 1), st.binary(max_size=4))
def test_whatever_bytes_are_put_in_nothing_but_reader_errors_is_raised(at, put):
    read_or_refused(READER, "run.lvm", SMALL[:at] + put + SMALL[at:])


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "cp1252"])
def test_encodings(encoding):
    content = SMALL.decode().replace("Ana", "Zoë").encode(encoding)
    assert np.array_equal(values(read(content)), TRUTH)
    assert READER.match(SourceFile("x.txt", content)).confidence >= 0.9


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b" \r\n\t\r\n",
        b"\0\1",
        SMALL[:100],
        text(file_header()),
        text([*file_header(), "1\t2"]),
        b"Time\tFz\n1\t2\n",
    ],
)
def test_no_table(content):
    with pytest.raises(ReaderError, match=r"^run\.lvm"):
        read(content)


@pytest.mark.parametrize("size", [40, 300, len(SMALL)])
def test_found_by_content(size):
    source = SourceFile("x.txt", SMALL[:size])
    assert READER.match(source).confidence > max(0.9, DelimitedReader().match(source).confidence)


@pytest.mark.parametrize(
    "content", [b"", b"\0\1\2", b"X_Value\tFz\n1\t2\n", b"LabVIEW Measurements of today\nA\tB\n1\t2\n"]
)
def test_other_files_are_left_alone(content):
    assert READER.match(SourceFile("x.lvm", content)).confidence < 0.5


@pytest.mark.parametrize("name", ["demo_1.txt", "demo_2.txt"])
def test_real_file_of_three_segments(name):
    path = REAL_DATA / name
    if not path.is_file():
        pytest.skip(f"real data not here: {name}")
    source = SourceFile(name, path.read_bytes())
    assert READER.match(source).confidence >= 0.9
    table = READER.read(source, Hints())
    assert [(each.name, each.signal, each.unit) for each in table.columns] == [
        ("X_Value", "time", "s"),
        ("fx_N", None, "N"),
        ("fy_N", None, "N"),
        ("fz_N", None, "N"),
        ("dx_um", None, "micrometer"),
        ("segment", None, "1"),
    ]
    assert column(table, "segment").values.tolist() == [1.0] * 6 + [2.0] * 6 + [3.0] * 6
    assert column(table, "fz_N").values[:3].tolist() == [13.157429, 13.158075, 13.156782]
    assert table.facts == {"started": "2017-09-25T13:45:59", "operator": "ladmin"}
    assert [note.split(":")[0] for note in table.notes] == [
        "the numbers of rows differ from those in the header",
        "segments identical to the one before",
    ]
