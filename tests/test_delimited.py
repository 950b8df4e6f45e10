"""Delimited text in every dialect, and every way in which such a file can be broken."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from hanging import ends_soon
from hypothesis import given, settings
from hypothesis import strategies as st

from tribopipe.base.errors import ReaderError
from tribopipe.readers import delimited
from tribopipe.readers.delimited import DelimitedReader
from tribopipe.readers.reader import Hints, ReadColumn, Reader, ReadTable
from tribopipe.readers.tables import bare_name, is_number, split_name
from tribopipe.results.run import SourceFile

READER = DelimitedReader()
REAL_DATA = Path(__file__).resolve().parents[2] / "shared" / "realdata"


def read(content: bytes | str, **hints: str) -> ReadTable:
    encoded = content.encode() if isinstance(content, str) else content
    return READER.read(SourceFile("signals.csv", encoded), Hints(**hints))


def refusal(content: bytes | str, **hints: str) -> str:
    with pytest.raises(ReaderError) as caught:
        read(content, **hints)
    message = str(caught.value)
    assert message.startswith("signals.csv")
    assert "\n" not in message
    assert len(message) < 400
    return message


def confidence(content: bytes | str) -> float:
    encoded = content.encode() if isinstance(content, str) else content
    return READER.match(SourceFile("signals.csv", encoded)).confidence


def columns(table: ReadTable) -> dict[str, list[object]]:
    return {column.name: column.values.tolist() for column in table.columns}


def column(table: ReadTable, name: str) -> ReadColumn:
    return next(each for each in table.columns if each.name == name)


# --- round trip: whatever dialect a table is written in, its numbers come back ---


@dataclass(frozen=True)
class Written:
    content: bytes
    header: str
    names: list[str]
    units: list[str | None]
    values: np.ndarray


UNITS = ["s", "um", "N", "°C", "%", "mm/s", "1", "µm", "min"]
WORDS = ["Time", "Distance", "Depth", "Friction", "Fz", "Temperature", "Zeit", "Höhe"]
UNIT_STYLES = ["none", "square", "round", "slash", "below", "above"]
ENCODINGS = ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "cp1252"]
METADATA = ["Operator{s}Bob", "Load{s}5", "Date: 2024-05-06", "Probe{s}A1{s}x", "", "[Data]", "Radius{s}6{d}35", "  "]
NUMBERS = st.one_of(st.floats(allow_nan=False, allow_infinity=False), st.floats(-1e3, 1e3).map(lambda x: round(x, 4)))


def _names(words: list[str], units: list[str], style: str) -> list[str]:
    shapes = {"square": "{} [{}]", "round": "{}({})", "slash": "{} / {}"}
    return [shapes.get(style, "{}").format(word, unit) for word, unit in zip(words, units, strict=True)]


def _header_lines(names: list[str], units: list[str], style: str, separator: str) -> list[str]:
    rows = {"below": [names, units], "above": [units, names]}.get(style, [names])
    return [separator.join(row) for row in rows]


@st.composite
def written_tables(draw: st.DrawFn) -> Written:
    separator = draw(st.sampled_from(["\t", ";", "|", ",", " ", "   "]))
    blanks = not separator.strip(" ")
    decimal = "." if separator == "," else draw(st.sampled_from(".,"))
    end = draw(st.sampled_from(["\n", "\r\n", "\r"]))
    width = draw(st.integers(2, 5))
    values = draw(st.lists(st.lists(NUMBERS | st.none(), min_size=width, max_size=width), min_size=1, max_size=8))
    if all(value is None for row in values for value in row):
        values[0][0] = 1.5
    missing = "NaN" if blanks else draw(st.sampled_from(["", "NaN", "nan", "NA"]))
    pad = draw(st.sampled_from(["", " "]))
    trailing = "" if blanks else draw(st.sampled_from(["", separator]))
    texts = [[missing if v is None else repr(v).replace(".", decimal) for v in row] for row in values]
    body = [separator.join(pad + text for text in row) + trailing for row in texts]
    units = ["s", *(draw(st.sampled_from(UNITS)) for _ in range(width - 1))]
    # Between blanks, the 1 in "COF / 1" would be a number.
    style = draw(st.sampled_from([style for style in UNIT_STYLES if style != "slash" or not blanks]))
    names = _names(draw(st.permutations(WORDS))[:width], units, style)
    metadata = draw(st.lists(st.sampled_from(METADATA), max_size=4))
    above = [line.format(s=separator, d=decimal) for line in metadata] + _header_lines(names, units, style, separator)
    header = end.join(above) + end
    blank_lines = draw(st.sampled_from(["", end]))
    content = header + "".join(row + end + blank_lines for row in body)
    return Written(
        content.encode(draw(st.sampled_from(ENCODINGS))),
        header,
        names,
        [None] * width if style == "none" else list(units),
        np.array(values, dtype=float),
    )


@pytest.mark.slow
@settings(max_examples=120, deadline=None)
@given(written_tables())
def test_written_numbers_come_back_exactly(written: Written):
    table = READER.read(SourceFile("signals.csv", written.content), Hints())
    assert [each.name for each in table.columns] == written.names
    assert [each.unit for each in table.columns] == written.units
    assert [each.first_bad for each in table.columns] == [None] * len(written.names)
    assert np.array_equal(np.column_stack([each.values for each in table.columns]), written.values, equal_nan=True)
    assert table.header == written.header
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(delimited, "_ROWS_AT_ONCE", 2)
        again = READER.read(SourceFile("signals.csv", written.content), Hints())
    assert np.array_equal(np.column_stack([each.values for each in again.columns]), written.values, equal_nan=True)
    assert 0.5 <= READER.match(SourceFile("signals.csv", written.content)).confidence <= 0.7


@settings(max_examples=200, deadline=None)
@given(st.binary(max_size=300) | st.text(alphabet='0123456789.,;\t |"\r\nabcNa[]-', max_size=120).map(str.encode))
def test_whatever_the_bytes_nothing_but_reader_errors_is_raised(content: bytes):
    source = SourceFile("signals.csv", content)
    assert 0 <= READER.match(source).confidence <= 0.7
    try:
        table = READER.read(source, Hints())
    except ReaderError:
        return
    assert len({len(each.values) for each in table.columns}) == 1


def test_large_file_is_read_as_a_small_one_is():
    lengths = np.arange(260_000)
    rows = b"".join(b"%d.5;%d.25\r\n" % (n, n % 97) for n in lengths)
    table = read(b"Time [s];Depth [um]\r\n" + rows)
    assert np.array_equal(table.columns[0].values, lengths + 0.5)
    assert np.array_equal(table.columns[1].values, lengths % 97 + 0.25)


# --- dialects ---


def test_is_a_reader():
    assert isinstance(READER, Reader)


def test_line_ends_may_be_mixed():
    table = read(b"Time;Depth\r0.5;1.5\r\n0.6;1.6\n0.7;1.7\r\r\n0.8;1.8\n")
    assert columns(table) == {"Time": [0.5, 0.6, 0.7, 0.8], "Depth": [1.5, 1.6, 1.7, 1.8]}


@pytest.mark.parametrize("mark", [b"\xef\xbb\xbf", b""])
def test_byte_order_mark_is_no_part_of_the_first_name(mark):
    table = read(mark + b"Time;Depth\n0.5;1.5\n")
    assert table.columns[0].name == "Time"
    assert table.header == "Time;Depth\n"


def test_fallback_encodings_are_noted():
    assert "cp1252" in read("Time;Depth [µm]\n1;2\n".encode("cp1252")).notes[0]
    assert "latin-1" in read(b"Time;Depth [\xb5m]\n1;2\n# \x81;\n").notes[0]


def test_manifest_names_an_encoding():
    content = '"単位","g","g"\r\n"Time(sec)","CH1","CH2"\r\n0,1,2\r\n0.1,2,3\r\n'.encode("shift_jis")
    table = read(content, encoding="shift_jis")
    assert [(each.name, each.unit) for each in table.columns] == [("Time(sec)", "sec"), ("CH1", "g"), ("CH2", "g")]
    assert table.header.startswith('"単位"')


def test_hints_win_over_guesses():
    content = "Time;Load\n998;5\n1.000;6\n"
    assert column(read(content, decimal="."), "Time").values.tolist() == [998.0, 1.0]
    assert column(read(content, decimal=","), "Time").first_bad == (3, "1.000")
    assert columns(read("a!b\n1!2\n", separator="!")) == {"a": [1.0], "b": [2.0]}
    assert columns(read("a,b\n1,5 2,5\n1,7 2,8\n".replace("a,b", "a b"), separator=" ", decimal=",")) == {
        "a": [1.5, 1.7],
        "b": [2.5, 2.8],
    }


def test_commas_in_names_do_not_separate_where_something_stronger_does():
    table = read("Time, s;Force, N\n0,5;1,2\n0,6;1,3\n")
    assert columns(table) == {"Time, s": [0.5, 0.6], "Force, N": [1.2, 1.3]}


def test_names_among_blanks_may_hold_blanks():
    assert list(columns(read("Friction force [N]   Sliding distance [m]\n1.5 2\n"))) == [
        "Friction force [N]",
        "Sliding distance [m]",
    ]
    assert list(columns(read("# Time Depth\n1.5 2\n"))) == ["Time", "Depth"]


def test_units_below_and_blank_lines_between():
    table = read("Step No. 1\nFx,Fz,T\ng,g,sec\n\n1.5,2,3\n")
    assert [(each.name, each.unit) for each in table.columns] == [("Fx", "g"), ("Fz", "g"), ("T", "sec")]


def test_a_unit_row_may_hold_a_1():
    table = read("Time;COF\ns;1\n0;0.1\n1;0.2\n")
    assert [each.unit for each in table.columns] == ["s", "1"]
    assert len(table.columns[0].values) == 2


def test_names_that_are_units_stay_names():
    assert list(columns(read("t;F\n0;1\n"))) == ["t", "F"]


def test_metadata_rows_are_no_samples():
    content = "Date;24/06/20\nRadius;6\nLoad;5\nProbe;x\nTime;Depth\n0;1\n"
    table = read(content)
    assert columns(table) == {"Time": [0.0], "Depth": [1.0]}
    assert table.header == content.removesuffix("0;1\n")


def test_trailing_separators_are_no_column():
    expected = {"A": [1.0, 3.0], "B": [2.0, 4.0]}
    for header in ("A;B", "A;B;", "A;B;;"):
        for end in ("", ";", ";;"):
            assert columns(read(f"{header}\n1;2{end}\n3;4{end}\n")) == expected


def test_duplicate_and_missing_names():
    table = read(";A;A;A (2);\n1;2;3;4;5\n")
    assert list(columns(table)) == ["column 1", "A", "A (2)", "A (2) (2)", "column 5"]
    assert len(table.notes) == 2
    assert "'A (2)'" in table.notes[0]


def test_quoted_fields_may_hold_separators_and_line_ends():
    table = read('Time,Step,Depth\r\n0.5,"one,\r\n10 mN",1\r\n0.6,"two",oops\r\n0.7,"three",3\r\n')
    assert column(table, "Time").values.tolist() == [0.5, 0.6, 0.7]
    assert column(table, "Step").values[0] == "one,\r\n10 mN"
    assert column(table, "Depth").first_bad == (4, "oops")


def test_a_first_row_without_any_number_is_a_sample_too():
    assert len(read("Time;Depth\n;\nNaN;NaN\n1;2\n").columns[0].values) == 3


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("Depth [um]", ("Depth", "um")),
        ("Fz (N)", ("Fz", "N")),
        ("time / s", ("time", "s")),
        ("time/s", ("time", "s")),
        ("Time(s)", ("Time", "s")),
        ("v / (mm/s)", ("v", "mm/s")),
        ("k (mm^3/(N*mm))", ("k", "mm^3/(N*mm)")),
        ("Temperature [°C]", ("Temperature", "°C")),
        ("COF (-)", ("COF", "-")),
        ("DAQ.COF ()", ("DAQ.COF", None)),
        ("DAQ.COF (Fx)", ("DAQ.COF (Fx)", None)),
        ("m/s", ("m/s", None)),
        ("Fx/Fz", ("Fx/Fz", None)),
        ("[um]", ("[um]", None)),
        ("Depth", ("Depth", None)),
        ("Friction force/N", ("Friction force", "N")),
        ("Speed m/s", ("Speed m/s", None)),
        ("Zeit t/s", ("Zeit t", "s")),
        ("時間/s", ("時間", "s")),
        ("load_N", ("load", "N")),
        ("time_ms", ("time", "ms")),
        ("disc_wear_volume_mm3", ("disc_wear_volume", "mm3")),
        ("Fx_mN", ("Fx", "mN")),
        ("Load in N", ("Load", "N")),
        ("Time, min", ("Time", "min")),
        ("Wear {µm}", ("Wear", "µm")),
        ("t/s", ("t", "s")),
        ("T/°C", ("T", "°C")),
        ("F_N", ("F_N", None)),  # the normal force
        ("T_s", ("T_s", None)),  # the temperature of a surface
        ("load_min", ("load_min", None)),
        ("Load, max", ("Load, max", None)),
        ("Wear in percent", ("Wear in percent", None)),
        ("COF_1", ("COF_1", None)),
        ("mu_s", ("mu_s", None)),
        ("v_m", ("v_m", None)),  # a mean
        ("RPM", ("RPM", "RPM")),
        ("Motor rpm", ("Motor rpm", "rpm")),
        ("t_s", ("t", "s")),
        ("h_um", ("h", "um")),
    ],
)
def test_units_in_names(name, expected):
    assert split_name(name) == expected
    assert bare_name(name) == expected[0]


# --- what is no number ---


@pytest.mark.parametrize(
    "text",
    ["True", "1e999", "1 234.5", "1,234.5", "0x1F", "1_000", "1e", "+"],
)
def test_a_column_with_something_else_keeps_its_texts(text):
    table = read(f"Time;Depth\n0.5;1.5\n\n0.6;{text}\n0.7;2.50\n")
    assert column(table, "Time").values.tolist() == [0.5, 0.6, 0.7]
    assert column(table, "Depth").values.tolist() == ["1.5", text, "2.50"]
    assert column(table, "Depth").first_bad == (4, text)


def test_something_else_far_down_is_found_with_its_line():
    rows = [f"{n}.5;{n}.25" for n in range(3000)]
    rows[2000] = "2000.5;8.0.1"
    table = read("Time;Depth\r\n" + "\r\n".join(rows) + "\r\n")
    assert table.columns[0].values.dtype == np.float64
    assert table.columns[1].first_bad == (2002, "8.0.1")
    assert table.columns[1].values[0] == "0.25"


def test_infinity_far_down_is_no_measurement():
    rows = [f"{n}.5;{n}.25" for n in range(3000)]
    rows[2000] = "2000.5;1e999"
    assert read("Time;Depth\n" + "\n".join(rows) + "\n").columns[1].first_bad == (2002, "1e999")


def test_odd_blanks_around_numbers_are_no_harm():
    table = read("Time;Depth\n0,5 ;\u00a01,5\n 0,6;\t1,6 \n0,7; \n")
    assert column(table, "Time").values.tolist() == [0.5, 0.6, 0.7]
    assert np.array_equal(column(table, "Depth").values, [1.5, 1.6, np.nan], equal_nan=True)


def test_missing_samples_are_no_names():
    table = read("Time,Distance\n NaN, NaN\n NaN, 0.0\n")
    assert list(columns(table)) == ["Time", "Distance"]
    assert len(table.columns[0].values) == 2


def test_missing_samples():
    values = column(read("Time;Depth\n1;\n2;NaN\n3;nan\n4;NA\n5;6\n"), "Depth").values
    assert np.array_equal(values, [np.nan] * 4 + [6.0], equal_nan=True)


# --- what must be refused ---


def test_empty_file():
    assert "empty" in refusal(b"")
    assert confidence(b"") == 0


@pytest.mark.parametrize("size", range(60, 120))
def test_table_cut_anywhere_gives_no_wrong_number(size):
    rows = [[0.25, 1.125, 10.25], [0.5, 2.25, 11.5], [0.75, 3.5, 12.75], [1.0, 4.125, 113.0], [1.25, 5.5, 114.25]]
    whole = "Time [s];Depth [um];Ft\r\n" + "".join("{:.2f};{:.3f};{:.2f}\r\n".format(*row) for row in rows)
    try:
        table = read(whole[:size])
    except ReaderError:
        return
    found = np.column_stack([each.values for each in table.columns])
    assert np.array_equal(found[~np.isnan(found)], np.array(rows)[: len(found)][~np.isnan(found)])


@pytest.mark.parametrize("content", [b" ", b"\n\n\r\n \t \n", b"\xef\xbb\xbf"])
def test_nothing_but_blanks(content):
    assert "whitespace" in refusal(content)


@pytest.mark.parametrize("content", ["0.5;1.5\n0.6;1.6\n", "0.5\t1.0\t3\n12.5;0.5\n0.1;0.2\n"])
def test_numbers_without_names(content):
    message = refusal(content)
    assert "without a header row" in message
    assert "add a header row" in message
    assert confidence(content) == 0


@pytest.mark.parametrize(
    "content", ["Time;Depth\n", "Time;Depth\ns;um\n", "Some report\nwithout any table\n", "\n" * 600 + "A;B\n1;2\n"]
)
def test_header_without_data(content):
    assert "no data row" in refusal(content)
    assert confidence(content) == 0


@pytest.mark.parametrize(
    "content",
    [b"PK\x03\x04\x14\x00\x00\x00\x08\x00abc;1\n2;3\n", b"A;B\n1;2\n\x00\x00\x00\x00", bytes(range(1, 256)) * 8],
    ids=["archive", "zeros at the end", "noise"],
)
def test_binary_file(content):
    assert "expected text" in refusal(content)
    assert confidence(content) == 0


def test_row_cut_in_the_middle():
    message = refusal("Time;Fx;Fz;Depth\n1;2;3;4\n1;2;3;4\n1;2")
    assert message == (
        "signals.csv, line 4: found 2 fields, expected 4; the file ends in the middle of a row: copy it again from "
        "the instrument, or delete the last line"
    )
    assert "line 2: found 1 field, expected 4" in refusal("Time;Fx;Fz;Depth\n1")
    assert "line 4: found 2 fields, expected 3" in refusal("A B C\n1 2 3\n1 2 3\n1 2\n")


def test_row_cut_before_its_closing_separator():
    assert "line 3: found 2 fields, expected 3" in refusal("A;B\n1;25;\n3;4")
    assert columns(read("A;B\n1;2;\n3;4\n5;6;\n"))["B"] == [2.0, 4.0, 6.0]


def test_last_number_cut_short():
    content = "Time;Depth\n0.5;1.25\n0.6;1.35\n0.7;1.45\n0.8;1.55"
    assert "line end" in read(content).notes[0]
    for cut in (1, 2, 3):
        assert "middle of a row" in refusal(content[:-cut])
    assert read(content + "\n").notes == ()


@pytest.mark.parametrize("rows", [3, 3000])
def test_short_row_elsewhere(rows):
    lines = [f"{n}.5;{n};1;" for n in range(rows)]
    lines[rows // 2] = "7.5;8"
    message = refusal("Time;Fx;Fz;Comment\n" + "\n".join(lines) + "\n")
    assert f"line {rows // 2 + 2}: found 2 fields, expected 4" in message


def test_short_row_among_quoted_ones():
    assert "line 4: found 2 fields, expected 3" in refusal('A,B,C\n1,"a\nb",\n2,"c"\n3,"d",\n')


@pytest.mark.parametrize("row", [0, 1, 2500])
def test_long_row(row):
    lines = ["1;2"] * 3000
    lines[row] = "1;2;3"
    assert f"line {row + 2}: found 3 fields, expected 2" in refusal("Time;Depth\n" + "\n".join(lines) + "\n")


@pytest.mark.slow
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_bad_rows_are_found_wherever_the_table_is_divided(monkeypatch, end):
    monkeypatch.setattr(delimited, "_ROWS_AT_ONCE", 3)
    rows = ["1000.5;2000.5"] * 20
    for row in range(20):
        for bad, complaint in (("1;2;7", "found 3 fields"), ("1;2;", None), ("1", "found 1 field"), ("1;x", None)):
            content = "Time;Depth" + end + end.join([*rows[:row], bad, *rows[row + 1 :]]) + end
            if complaint:
                assert f"line {row + 2}: {complaint}, expected 2" in refusal(content)
            else:
                bad_field = (row + 2, "x") if bad == "1;x" else None
                assert [each.first_bad for each in read(content).columns] == [None, bad_field]


def test_long_row_behind_a_field_that_is_no_number(monkeypatch):
    monkeypatch.setattr(delimited, "_ROWS_AT_ONCE", 3)
    content = "Time;Depth\n" + "1000.5;2000.5\n" * 500 + "1;x\n" + "1000.5;2000.5\n" * 99 + "1;2;3\n" + "1;2\n" * 9
    assert "line 602: found 3 fields" in refusal(content)


def test_rows_that_start_with_a_separator_after_a_lone_return():
    table = read("Time;Depth\r0.5;1.5\r;1.6\r\r;1.7\r")
    assert np.array_equal(column(table, "Time").values, [0.5, np.nan, np.nan], equal_nan=True)
    assert column(table, "Depth").values.tolist() == [1.5, 1.6, 1.7]
    assert columns(read("A B\r 1 2\r\t\r 3 4\r")) == {"A": [1.0, 3.0], "B": [2.0, 4.0]}


def test_comma_for_both_columns_and_decimals():
    assert "found 4 fields, expected 2" in refusal("Time,Depth\n0,5,1,5\n0,6,1,6\n")


def test_quotation_mark_without_partner():
    assert "quotation mark" in refusal('A;B\n1;2\n3;"4\n5;6\n')


def test_million_columns_are_refused_at_once():
    names = ",".join(f"c{n}" for n in range(1_000_000))
    with ends_soon():
        assert "1000 columns" in refusal(f"{names}\n1,2\n")


def test_too_many_columns():
    content = ",".join(f"c{n}" for n in range(1200)) + "\n" + ",".join("1" * 1200) + "\n"
    assert "found 1200 columns; expected at most 1000" in refusal(content)


@pytest.mark.slow
@pytest.mark.parametrize("before", [b"", b"Time;Depth\n"])
def test_one_line_of_100_megabytes_is_refused_at_once(before):
    content = before + b"7" * 100_000_000
    with ends_soon():
        assert "characters in one line" in refusal(content)
        assert confidence(content) == 0


def test_encoding_named_wrongly():
    content = "Time;Depth [µm]\n1;2\n".encode("cp1252")
    assert "byte 12, which is not utf-8" in refusal(content, encoding="utf-8")
    assert "unknown encoding 'klingon'" in refusal(content, encoding="klingon")
    assert "unknown encoding 'hex'" in refusal(content, encoding="hex")


def test_cut_in_the_middle_of_a_character():
    assert "not utf-16" in refusal("Time;Depth\n1;2\n".encode("utf-16")[:-1])
    assert "not utf-8" in refusal("Time;Depth [µm];Note\n1;2;µ".encode()[:-1])


def test_separator_that_yields_one_column():
    assert "a single column with the separator ';'" in refusal("Time|Depth\n1|2\n", separator=";")
    assert "a single column" in refusal("Depth [um]\n1.5\n2.5\n")


@pytest.mark.parametrize("separator", ["", "ab", "5", "é", '"'])
def test_separator_that_is_none(separator):
    assert "expected one character" in refusal("Time;Depth\n1;2\n", separator=separator)


def test_separator_that_is_the_decimal_sign():
    assert "two different characters" in refusal("Time;Depth\n1;2\n", separator=",", decimal=",")


@pytest.mark.parametrize(
    "content",
    [
        "Time, s Force, N\n1,5 2,5\n1,6 2,6\n",
        "Time, s  Force, N\n1,234.5 2,345.6\n",
        "Depth, um\n1,5\n2,5\n",
        "Time, s, Depth, um\n1,5,2,5\n",
    ],
)
def test_comma_that_may_be_separator_or_decimal_sign(content):
    message = refusal(content)
    assert "separator and decimal" in message
    assert confidence(content) >= 0.5


@pytest.mark.parametrize("number", ["1,000", "1.000"])
@pytest.mark.parametrize("rows", [3, 999])
def test_number_that_may_be_thousands(number, rows):
    content = "Cycle\tLoad\n" + "".join(f"{n}\t5\n" for n in range(1000 - rows, 1000)) + f"{number}\t6\n"
    assert f"line {rows + 2}: found '{number}'" in refusal(content)


def test_decimal_sign_that_shows_late():
    content = "Cycle\tLoad\n" + "0\t5\n" * 200_000 + "0,25\t5\n"
    assert column(read(content), "Cycle").values[-1] == 0.25


def test_two_decimal_signs():
    message = refusal("Time;Depth\n0,5;1\n0,6;1.5\n")
    assert "line 3: found '1.5', while line 2 contains '0,5'" in message


def test_two_tables():
    assert "one table per file" in refusal("A;B\n1;2\n2;3\n\nC;D;E\n1;2;3\n1;2;3\n1;2;4\n")


@pytest.mark.parametrize(
    "prose",
    [
        "We ran 12 tests at 5 N.\nOf these 3 failed, as Table 4 shows\n\nin 2006 and 2007, with 14 pins.\n",
        "Rows       : 460, 460 and 427\nOracle     : the mean of 9 runs\n",
    ],
)
def test_prose_with_numbers_is_no_table(prose):
    assert confidence(prose) < 0.5


# --- files of real instruments ---


def _real(name: str) -> bytes:
    path = REAL_DATA / name
    if not path.is_file():
        pytest.skip(f"real data not here: {name}")
    return path.read_bytes()


def test_real_pin_on_disc_log_in_cp1252():
    table = read(_real("pinondiskapp-es/data/test.txt"))
    assert [(each.name, each.unit) for each in table.columns] == [
        ("fuerza[kg]", "kg"),
        ("distancia[m]", "m"),
        ("tiempo[s]", "s"),
        ("temperatura[°C]", "°C"),
        ("humedad[%]", "%"),
    ]
    assert len(table.columns[0].values) == 8561
    assert table.columns[2].values[-1] == 3446.80
    assert table.header.startswith("Fecha\t24/06/20\t17:10:07\n")


def test_real_nanotribometer_table_with_line_ends_in_quotes():
    table = read(_real("nanotribometer-silicone-percycle/CoF-Measurements.csv"))
    assert len(table.columns) == 19
    assert {len(each.values) for each in table.columns} == {4308}
    assert np.isnan(column(table, "CoF.sd").values).sum() == 6
    assert column(table, "SequenceName").first_bad is not None


def test_real_rows_without_names_are_refused():
    assert "line 2: found data rows without" in refusal(_real("newport-rheofriction/Motor_oil_glass/1rps1N.txt"))


def test_real_file_of_several_segments_is_refused():
    assert "found" in refusal(_real("pcs-ehd-labview/examples/data_import/demo_1.txt"))


def test_a_row_that_lacks_a_field_is_refused_where_all_others_end_in_a_separator():
    rows = "Time [s];Depth [um];Ft [N];\n" + "1;2;3;\n" * 4 + "2;4;\n" + "1;2;3;\n"
    with pytest.raises(ReaderError, match=r"line 6: found 3 fields, expected 4"):
        DelimitedReader().read(SourceFile("a.csv", rows.encode()), Hints())


@pytest.mark.parametrize("sign", ["\x0b", "\x0c", "\x85", "\xa0", "\u2028", "\u3000"])
@pytest.mark.parametrize("separator", ["\t", ";", " "])
def test_a_line_of_signs_that_are_no_blanks_is_no_blank_line(sign, separator):
    rows = "".join(f"{number / 2}{separator}{number}\n" for number in range(20))
    said = refusal(f"time_s{separator}force_N\n{rows}{sign * 3}\n{rows}")
    assert "line 22: found 1 field, expected 2" in said


@pytest.mark.parametrize("signs", [".", ",", ".,"])
def test_a_long_run_of_digits_is_judged_at_once(signs):
    assert not is_number("9" * 1_000_000 + "x", signs)
    assert is_number("9" * 1_000_000, signs)


def test_a_line_of_words_below_the_table_is_left_out_with_a_note():
    rows = "Time [s]\tDepth [um]\r\n1,5\t2,5\r\n2,5\t27,\r\n\r\nTest completed at 15:08:24 on 2019-04-11\r\n"
    table = DelimitedReader().read(SourceFile("a.txt", rows.encode()), Hints())
    np.testing.assert_array_equal(table.columns[1].values, [2.5, 27.0])
    assert table.notes == ("omitted the line 'Test completed at 15:08:24 on 2019-04-11' below the table",)


def test_a_table_cut_in_the_middle_of_a_number_is_still_refused():
    rows = "Time [s];Depth [um]\n1.50;2.50\n2.50;2.75\n3.5"
    with pytest.raises(ReaderError, match="ends in the middle of a row"):
        DelimitedReader().read(SourceFile("a.txt", rows.encode()), Hints())


@pytest.mark.parametrize(
    ("rows", "is_table"),
    [
        ("14:00:01;3.480\n14:00:02;3.470\n", True),
        ("2025-11-03 14:00:01;3,480\n2025-11-03 14:00:02;3,47\n", True),
        ("14-00-01;3.480\n14-00-02;3.470\n", False),
    ],
)
def test_times_of_day_and_one_column_of_numbers_are_a_table(rows, is_table):
    assert (confidence(f"Time;Friction [N]\n{rows}") >= 0.5) == is_table


@pytest.mark.parametrize(
    "content",
    [
        '{\n  "a": 1,\n  "b": 2,\n  "c": 3\n}\n',
        "[tool.ruff]\nwidth = 1\nheight = 2\n",
        "<table>\n<td>,1,2\n<td>,3,4\n",
        "name,kind,size\na,b,1\nc,d,2\n",
    ],
)
def test_documents_and_lists_of_words_are_no_tables(content):
    assert DelimitedReader().match(SourceFile("a.txt", content.encode())).confidence < 0.5


# --- decimal commas in quotation marks ---


def test_quoted_decimal_commas_between_commas():
    table = read('"Time [s]","Depth [um]"\n"0,00050","0,03"\n"0,00100","-1,5"\n')
    assert column(table, "Time [s]").values.tolist() == [0.0005, 0.001]
    assert column(table, "Depth [um]").values.tolist() == [0.03, -1.5]


def test_quoted_thousands_are_in_doubt():
    assert "thousands" in refusal('Time,Cycles\n1,"1,234"\n2,"2,345"\n')
    assert "one decimal separator" in refusal('Time,Cycles\n1.5,"1,234"\n2.5,"2,345"\n')


def test_a_row_of_symbols_with_units_is_a_row_of_names():
    assert [(each.name, each.unit) for each in read("t/s;F/N;h/µm\n0;5;0\n1;5;2\n").columns] == [
        ("t/s", "s"),
        ("F/N", "N"),
        ("h/µm", "µm"),
    ]


@pytest.mark.parametrize(("row", "noted"), [("s;µm;mN", True), ("s;um;N", False), ("s;;", False)])
def test_another_unit_in_the_row_of_units_than_in_the_name_is_named(row, noted):
    table = read(f"Time [s];Wear [um];load_N\n{row}\n0;0;5\n1;1;5\n")
    note = "column 'load_N' has another unit in the row of units, mN, than in its name, N; mN is used"
    assert (note in table.notes) == noted


@pytest.mark.parametrize("number", ["1.457,2", "1,457.2", "1'457.2", "1 457,2"])
def test_numbers_with_thousands_separators_are_the_reason_why_a_table_is_refused(number):
    rows = "".join(f"{n};{number};{number}\n" for n in range(5))
    match = DelimitedReader().match(SourceFile("a.csv", f"Time [s];Fn [mN];Ff [mN]\n{rows}".encode()))
    assert match.confidence < 0.5
    assert f"line 2 contains {number!r}; expected numbers without thousands separators" in match.why
