"""Spreadsheets: the same table in each of their formats; several sheets; what cells may hold; damaged files."""

import io
import zipfile
from contextlib import suppress

import numpy as np
import pytest
from built_files import Xml, ods, xls, xlsx
from sweeps import others_slow

from tribopipe.base.errors import ReaderError
from tribopipe.readers.formats import workbook
from tribopipe.readers.formats.workbook import WorkbookReader
from tribopipe.readers.reader import Hints, ReadTable
from tribopipe.results.run import SourceFile

READER = WorkbookReader()
ROWS = [["Run 5", None], ["Time [s]", "Ft"], [None, "mN"], [0.0, 1.5], [0.1, -2.5e-7], [0.2, 12345678.9]]
WRITERS = {"xlsx": xlsx, "ods": ods, "xls": xls}
ERROR = Xml('<c r="{ref}" t="e"><v>#DIV/0!</v></c>')
EMPTY_FORMULA = Xml('<c r="{ref}"><f>A1</f></c>')


def read(content: bytes, **hints: str) -> ReadTable:
    return READER.read(SourceFile("run.xlsx", content), Hints(**hints))


def columns(table: ReadTable) -> dict[str, list]:
    return {column.name: column.values.tolist() for column in table.columns}


@pytest.mark.parametrize("kind", WRITERS)
def test_the_table_of_each_kind(kind):
    content = WRITERS[kind]({"Data": ROWS})
    assert READER.match(SourceFile("run", content)).confidence >= 0.9
    table = read(content)
    assert columns(table) == {"Time [s]": [0, 0.1, 0.2], "Ft": [1.5, -2.5e-7, 12345678.9]}
    assert [column.unit for column in table.columns] == ["s", "mN"]
    assert table.header == "Run 5\t\nTime [s]\tFt\n\tmN\n"
    assert table.notes == ()


def test_sheets_in_which_time_goes_on_are_segments():
    later = [*ROWS[:3], [0.3, 1.0], [0.4, 2.0]]
    table = read(xlsx({"Notes": [["Dear reader"]], "1": ROWS, "2": later}))
    assert columns(table)["segment"] == [1, 1, 1, 2, 2]
    assert columns(table)["Ft"] == [1.5, -2.5e-7, 12345678.9, 1, 2]


@pytest.mark.slow
@pytest.mark.parametrize("names", [["Time [s]", "Ft"], ["Time [s]", "Fz"]], ids=["the same", "different"])
def test_several_tests_are_refused_until_one_is_named(names):
    book = xlsx({"A": ROWS, "B": [names, [0.0, 1.0], [1.0, 2.0]]})
    with pytest.raises(ReaderError, match=r"run.xlsx: found a test table in each of the sheets 'A' and 'B'"):
        read(book)
    assert list(columns(read(book, sheet="B"))) == names
    assert read(book, sheet="B").notes == ()
    with pytest.raises(ReaderError, match=r"found no sheet 'C'; expected one of 'A', 'B'"):
        read(book, sheet="C")


def test_sheet_of_words_alone_is_no_table():
    words = [["Measuring Tool", "SurfTest"], ["Filter", "GAUSS"], ["Standard", "ISO 1997"], ["Length", "2.5mm"]]
    words += [[f"Ra {number}", number] for number in (1, 2)] + [["Rz", "um"]]
    with pytest.raises(ReaderError, match=r"sheet 'Sheet1': found no column that contains only numbers; expected"):
        read(xlsx({"Sheet1": words}))
    assert columns(read(xlsx({"Sheet1": words, "Data": ROWS})))["Ft"] == [1.5, -2.5e-7, 12345678.9]


def test_settings_and_hidden_sheets_are_left_out_with_notes():
    other = [["Time [s]", "Fz"], [0.0, 1.0], [1.0, 2.0]]
    settings = [["Parameter", "Value"], ["Load", 5.0], ["Speed", 3.0]]
    table = read(xlsx({"Settings": settings, "Data": ROWS, "Old": other}, hidden=["Old"]))
    assert list(columns(table)) == ["Time [s]", "Ft"]
    assert table.notes == (
        "sheet 'Settings' contains no test data and is omitted",
        "sheet 'Old' is hidden and omitted",
    )


def test_rows_and_columns_that_repeat_in_ods():
    value = '<table:table-cell table:number-columns-repeated="2" office:value-type="float" office:value="7"/>'
    table = read(
        ods({"Data": [*ROWS, [Xml(value)], [Xml('<table:table-cell table:number-columns-repeated="16384"/>')]]})
    )
    assert columns(table)["Ft"] == [1.5, -2.5e-7, 12345678.9, 7]
    assert columns(table)["Time [s]"][-1] == 7


def test_a_table_away_from_the_corner():
    shifted = [[], *([None, *row, None] for row in ROWS)]
    table = read(xlsx({"Data": shifted}))
    assert columns(table) == columns(read(xlsx({"Data": ROWS})))
    assert table.header == "\n\tRun 5\t\n\tTime [s]\tFt\n\t\tmN\n"


def test_an_average_below_the_rows_is_no_number():
    table = read(xlsx({"Data": [*ROWS, [], ["Mean", 2.0]]}))
    assert table.columns[0].first_bad == (8, "Mean")


def test_what_cells_may_hold():
    head = ["Time [s]", "Ft [N]", "Step\tno.\n(1)", 'the "mark"']
    first, last = [0.0, ERROR, 1.0, 'a\t"b"\n'], [1.0, 3.0, 3.0, None]
    rows = [head, first, [None, None, None, None], [0.5, EMPTY_FORMULA, 2.0, "c"], last]
    table = read(xlsx({"Data": rows}))
    found = columns(table)
    assert list(found) == ["Time [s]", "Ft [N]", "Step no. (1)", 'the "mark"']
    assert found["Time [s]"] == [0, 0.5, 1]
    assert np.isnan(found["Ft [N]"][:2]).all()
    assert found['the "mark"'] == ['a "b"', "c", ""]
    assert table.columns[3].first_bad == (2, 'a "b"')


def formatted(style: int, number: float) -> Xml:
    return Xml(f'<c r="{{ref}}" s="{style}"><v>{number!r}</v></c>')


def test_durations_are_seconds():
    rows = [[formatted(2, day), 1.0] for day in (1.5 / 86400, 3 / 86400, 1.25)]
    table = read(xlsx({"Data": [["Time", "Ft [N]"], *rows]}))
    assert table.columns[0].unit == "s"
    assert columns(table)["Time"] == pytest.approx([1.5, 3, 108_000])
    assert table.notes == ("column 'Time' contains durations, which are converted to seconds",)


def of_day(*hours: float | None) -> list[list]:
    return [["Time", "Ft [N]"], *([None if hour is None else formatted(3, hour / 24), 1.0] for hour in hours)]


@pytest.mark.parametrize(
    ("hours", "seconds"),
    [
        ((14.1, 14.2, 14.5), (0, 360, 1440)),
        ((23.5, 23.75, 0.0, 0.25, 23.5, 0.5), (0, 900, 1800, 2700, 86_400, 90_000)),
        ((23.5, None, 0.5), (0, np.nan, 3600)),
        ((None, 23.5, 0.5), (np.nan, 0, 3600)),
    ],
    ids=["one day", "past midnight", "one missing", "first missing"],
)
def test_times_of_day_are_seconds_since_the_first_row(hours, seconds):
    table = read(xlsx({"Data": of_day(*hours)}))
    assert (table.columns[0].unit, table.columns[0].first_bad) == ("s", None)
    np.testing.assert_allclose(table.columns[0].values, seconds, atol=1e-5)
    assert table.notes == ("column 'Time' contains times of day, which are converted to seconds since the first row",)


def test_times_of_day_go_on_in_the_next_sheet():
    table = read(xlsx({"1": of_day(14.0, 14.1, 14.2), "2": of_day(14.3, 14.4)}))
    assert columns(table)["segment"] == [1, 1, 1, 2, 2]
    assert columns(table)["Time"] == pytest.approx([0, 360, 720, 1080, 1440])


def test_times_of_day_written_as_text_are_read_as_in_other_files():
    table = read(xlsx({"Data": [["Time", "Ft [N]"], ["9:59:59", 1.0], ["10:00:00,5", 2.0]]}))
    assert columns(table)["Time"] == [0, 1.5]


def test_dates_with_times_are_seconds_since_the_first():
    rows = [[formatted(1, 45000.5 + second * 0.5 / 86400), 1.0] for second in range(3)]
    table = read(xlsx({"Data": [["When", "Ft [N]"], *rows]}))
    when = table.columns[0]
    assert (when.unit, when.signal) == ("s", "time")
    assert when.values == pytest.approx([0, 0.5, 1], abs=2e-3)
    assert table.notes == ("column 'When' contains dates since 2023-03-15T12:00:00, which are converted to seconds",)


def test_a_date_at_midnight_has_no_time():
    rows = [[formatted(1, 45000 + hour / 24), 1.0] for hour in (-1, 0, 1)]
    assert columns(read(xlsx({"Data": [["When", "Ft [N]"], *rows]})))["When"] == pytest.approx([0, 3600, 7200])


def test_dates_of_days_are_text():
    rows = [[formatted(1, 45000 + day), 0.5 * day, 1.0] for day in range(3)]
    found = columns(read(xlsx({"Data": [["Day", "Time [s]", "Ft [N]"], *rows]})))
    assert found["Day"] == ["2023-03-15", "2023-03-16", "2023-03-17"]


def test_a_date_that_does_not_run_is_text():
    rows = [[formatted(1, 45000), 0.5 * number, 1.0] for number in range(3)]
    table = read(xlsx({"Data": [["Day", "Time [s]", "Ft [N]"], *rows]}))
    assert table.columns[0].values.tolist() == ["2023-03-15"] * 3


@pytest.mark.parametrize("text", ["2023-99-15T12:00:00", "PT1.5.5S", "PTS"])
def test_a_text_that_looks_like_a_time_is_text(text):
    rows = [["Mark", "Time [s]", "Ft [N]"], [text, 0.5, 1.0], [text, 1.0, 1.0]]
    assert read(xlsx({"Data": rows})).columns[0].values.tolist() == [text, text]


def test_numbers_stored_as_text():
    rows = [["Time [s]", "Ft [N]"], [0.5, "1,500"], [1.0, "2,500"]]  # may be thousands
    table = read(xlsx({"Data": rows}))
    assert table.columns[1].first_bad == (2, "1,500")
    expected = {"Time [s]": [0.5, 1], "Ft [N]": [1.5, 2.5]}
    assert columns(read(xlsx({"Data": rows}), decimal=",")) == expected
    rows = [["Time [s]", "Ft [N]"], ["0,5", "1,500"], [1, "2,5"]]
    assert columns(read(xlsx({"Data": rows}))) == expected


@pytest.mark.parametrize(
    ("sheets", "expected"),
    [
        ({"Data": []}, "found no visible sheet with data"),
        ({"Data": [["Time [s]", "Ft [N]"]]}, r"sheet 'Data', line 1: found .*, but no data row"),
        ({"Data": [[1.0, 2.0], [3.0, 4.0]]}, r"sheet 'Data', line 1: found data rows without a header row"),
    ],
    ids=["empty", "names-alone", "numbers-alone"],
)
def test_no_table(sheets, expected):
    with pytest.raises(ReaderError, match=expected):
        read(xlsx(sheets))


def test_a_stray_cell_cannot_take_the_memory():
    far = Xml('<c r="XFD1048576"><v>1</v></c>')
    with pytest.raises(ReaderError, match="found a file that cannot be read"):
        read(xlsx({"Data": [*ROWS, [far]]}))


def test_a_zip_bomb_is_refused_unpacked():
    content = bytearray(xlsx({"Data": ROWS}))
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        declared = max(member.file_size for member in archive.infolist())
    entry = content.rindex(declared.to_bytes(4, "little"))
    content[entry : entry + 4] = (3 << 30).to_bytes(4, "little")
    with pytest.raises(ReaderError, match=r"found 3\d{3} MB in the unpacked sheets"):
        read(bytes(content))


@pytest.mark.parametrize("kind", others_slow(WRITERS))
def test_cut_it_is_refused_or_the_same(kind):
    content = WRITERS[kind]({"Data": ROWS})
    whole = columns(read(content))
    for size in range(1, len(content), len(content) // 12):
        READER.match(SourceFile("run", content[:size]))
        with suppress(ReaderError):
            assert columns(read(content[:size])) == whole


def test_a_cut_file_is_still_known():
    assert READER.match(SourceFile("run", xlsx({"Data": ROWS})[:-200])).confidence >= 0.9


@pytest.mark.parametrize(
    "content",
    [b"", b"PK", b"PK\x03\x04" + bytes(100), b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1" + bytes(600), b"Time\tFt\n1\t2\n"],
    ids=["empty", "short", "zip", "ole2", "text"],
)
def test_other_files_are_left_alone(content):
    assert READER.match(SourceFile("run.xlsx", content)).confidence <= 0.2
    with pytest.raises(ReaderError, match=r"^run\.xlsx"):
        read(content)


def test_without_the_package_it_says_how_to_install(monkeypatch):
    monkeypatch.setattr(workbook, "find_spec", lambda _name: None)
    with pytest.raises(ReaderError, match=r'python-calamine is not installed; .*pip install "tribopipe\[excel\]"'):
        read(xlsx({"Data": ROWS}))
