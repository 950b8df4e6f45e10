"""WINDUCOM files: read by the format's definition, or refused where they are cut."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tribopipe.base.errors import ReaderError
from tribopipe.readers.delimited import DelimitedReader
from tribopipe.readers.formats.winducom import WinducomReader
from tribopipe.readers.reader import Hints, Reader, ReadTable
from tribopipe.results.run import SourceFile

READER = WinducomReader()
REAL_DATA = Path(__file__).resolve().parents[2] / "shared" / "realdata" / "winducom-dwf-al10cu"
SMALL = (
    b"          TIME;          FF;\r"
    b"        0,9150;        4,80;;\r"
    b"        1,8240;       16,13;;\r"
    b"      418,3920;       17,04;;\r"
)


def read(content: bytes, **hints: str) -> ReadTable:
    return READER.read(SourceFile("run.dwf", content), Hints(**hints))


def write(names: list[str], rows: list[list[str]], end: str) -> bytes:
    lines = ["".join(f"{name:>14};" for name in names)]
    lines += ["".join(f"{number.replace('.', ','):>14};" for number in row) + ";" for row in rows]
    return "".join(line + end for line in lines).encode("ascii")


def test_is_a_reader():
    assert isinstance(READER, Reader)


def test_small_file():
    table = read(SMALL)
    time, force = table.columns
    assert (time.name, time.signal, time.unit) == ("TIME", "time", "s")
    assert (force.name, force.signal, force.unit) == ("FF", "friction_force", "N")
    assert time.values.tolist() == [0.915, 1.824, 418.392]
    assert force.values.tolist() == [4.8, 16.13, 17.04]
    assert table.header == "          TIME;          FF;\r"
    assert table.notes == ()


def test_only_what_is_certain_has_a_meaning():
    names = ["TIME", "FF", "COF", "WEAR", "LOAD", "SPEED", "TEMP"]
    table = read(write(names, [["0.5", "1", "0.1", "2.5", "50", "300", "23"]], "\r"))
    assert {column.name: (column.signal, column.unit) for column in table.columns} == {
        "TIME": ("time", "s"),
        "FF": ("friction_force", "N"),
        "COF": ("friction_coefficient", "1"),
        "WEAR": ("depth", "um"),
        "LOAD": ("normal_force", "N"),
        "SPEED": (None, None),
        "TEMP": (None, None),
    }


DECIMALS = st.decimals(-9999, 9999, places=4).map(str)


@st.composite
def written_files(draw: st.DrawFn) -> tuple[bytes, np.ndarray]:
    width = draw(st.integers(2, 4))
    rows = draw(st.lists(st.lists(DECIMALS, min_size=width, max_size=width), min_size=1, max_size=6))
    names = ["TIME", "FF", "COF", "WEAR"][:width]
    return write(names, rows, draw(st.sampled_from(["\r", "\n", "\r\n"]))), np.array(rows, dtype=float)


@pytest.mark.slow
@settings(max_examples=100, deadline=None)
@given(written_files())
def test_written_numbers_come_back_exactly(written):
    content, values = written
    table = read(content)
    assert np.array_equal(np.column_stack([column.values for column in table.columns]), values)
    assert READER.match(SourceFile("run.txt", content)).confidence >= 0.9


@pytest.mark.slow
@settings(max_examples=200, deadline=None)
@given(written_files(), st.data())
def test_cut_anywhere_it_is_right_or_refused(written, data):
    content, values = written
    _check_cut(content[: data.draw(st.integers(0, len(content)))], values)


def test_small_file_cut_at_every_byte():
    values = np.array([[0.915, 4.8], [1.824, 16.13], [418.392, 17.04]])
    for size in range(len(SMALL)):
        _check_cut(SMALL[:size], values)


def _check_cut(content: bytes, values: np.ndarray) -> None:
    try:
        table = read(content)
    except ReaderError:
        return
    found = np.column_stack([column.values for column in table.columns])
    assert np.array_equal(found, values[: len(found)])


@pytest.mark.parametrize("lost", [b";\r", b"04;;\r", b"       17,04;;\r"])
def test_row_without_its_end_is_named(lost):
    with pytest.raises(ReaderError, match=r"^run\.dwf, line 4: found \d fields?, expected 4; the file ends in"):
        read(SMALL.removesuffix(lost))


@pytest.mark.parametrize("content", [SMALL[:29], SMALL[:30], SMALL[:28], SMALL[:20], b"", b"Time;Depth\n1;2\n"])
def test_no_table(content):
    with pytest.raises(ReaderError, match=r"^run\.dwf"):
        read(content)


def test_row_in_the_middle_with_too_few_fields():
    with pytest.raises(ReaderError, match="line 3: found 3 fields, expected 4"):
        read(SMALL.replace(b"16,13;;", b"16,13;"))


def test_a_field_that_is_no_number_is_named():
    force = read(SMALL.replace(b"16,13", b"8.0.1")).columns[1]
    assert force.first_bad == (3, "8.0.1")
    assert force.values.tolist() == ["4,80", "8.0.1", "17,04"]


def test_found_by_content_whatever_the_name():
    for name in ("run.dwf", "run.csv", "run"):
        assert READER.match(SourceFile(name, SMALL)).confidence >= 0.9


@pytest.mark.parametrize("size", range(30, len(SMALL), 7))
def test_a_cut_file_is_not_left_to_another_reader(size):
    source = SourceFile("run.dwf", SMALL[:size])
    assert READER.match(source).confidence > DelimitedReader().match(source).confidence


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"\x00\x01\x02",
        b"TIME;FF;\r0,5;1,5;;\r",
        b"          TIME;          FF\r        0,5;    1,5;\r",
        b"Time [s];Depth [um]\n0,5;1,5\n",
        b"          TIME;          FF;\r        0.9150;        4.80;;\r        0.9250;        4.90;;\r",
    ],
    ids=["empty", "binary", "unpadded", "unclosed", "other", "points"],
)
def test_other_files_are_left_alone(content):
    assert READER.match(SourceFile("run.dwf", content)).confidence < 0.5


# Mean and standard deviation of the friction coefficient as the vendor's software shows them, at 50 N.
VENDOR = {
    "2.5/1-2-MoS2-2.5-Al2O3-Al10Cu-50N-130m-353.dwf": (0.539, 0.065),
    "2.5/2-2-MoS2-2.5-Al2O3-Al10Cu-50N-120mm-382.dwf": (0.495, 0.052),
    "2.5/4-2-MoS2-2.5-Al2O3-Al10Cu-50N-.dwf": (0.448, 0.062),
    "5/1-2-MoS2-5.0-Al2O3-Al10Cu-50N-.dwf": (0.426, 0.033),
    "5/3-2-MoS2-5.0-Al2O3-Al10Cu-50N-.dwf": (0.501, 0.044),
    "5/4-2-MoS2-5.0-Al2O3-Al10Cu-50N-.dwf": (0.515, 0.060),
    "7.5/1-2-MoS2-7.5-Al2O3-Al10Cu-50N-.dwf": (0.496, 0.044),
    "7.5/2-2-MoS2-7.5-Al2O3-Al10Cu-50N-.dwf": (0.495, 0.051),
    "7.5/3-2-MoS2-7.5-Al2O3-Al10Cu-50N-.dwf": (0.507, 0.045),
}


@pytest.mark.parametrize("name", VENDOR)
def test_real_files_agree_with_the_vendor(name):
    path = REAL_DATA / name
    if not path.is_file():
        pytest.skip(f"real data not here: {name}")
    source = SourceFile(path.name, path.read_bytes())
    force = READER.read(source, Hints()).columns[1]
    mean, deviation = VENDOR[name]
    assert np.mean(force.values) / 50 == pytest.approx(mean, abs=6e-4)
    assert np.std(force.values) / 50 == pytest.approx(deviation, abs=6e-4)


def test_all_real_files_are_known_and_whole():
    paths = sorted(REAL_DATA.rglob("*.dwf"))
    if not paths:
        pytest.skip("real data not here: winducom-dwf-al10cu")
    sources = [SourceFile(path.name, path.read_bytes()) for path in paths]
    assert all(READER.match(source).confidence >= 0.9 for source in sources)
    rows = sorted(len(READER.read(source, Hints()).columns[0].values) for source in sources)
    assert rows == [427] * 10 + [460] * 2
