"""T-11 pin-on-disc tester: semicolons, rows closed by one more, [C] for °C."""

import pytest
from small_exports import T11, check_every_cut, claimed_by, read

from tribopipe.base.errors import ReaderError
from tribopipe.readers.formats.t11 import T11Reader
from tribopipe.readers.reader import Reader

READER = T11Reader()


def test_is_a_reader_and_claims_its_files_alone():
    assert isinstance(READER, Reader)
    assert claimed_by(READER) == ["t-11"]


@pytest.mark.parametrize("end", [b"\r\n", b"\n", b"\r"])
@pytest.mark.parametrize("closed", [True, False])
@pytest.mark.parametrize("decimal", [b",", b"."])
def test_small_file(end, closed, decimal):
    content = T11 if closed else T11.replace(b";\r\n", b"\r\n")
    table = read(READER, content.replace(b",", decimal).replace(b"\r\n", end))
    assert [(column.name, column.unit, column.signal) for column in table.columns] == [
        ("Time [s]", "s", "time"),
        ("Friction force [N]", "N", "friction_force"),
        ("Displacement [um]", "um", "depth"),
        ("Temperature2 [C]", "degC", None),
        ("Temperature1 [C]", "degC", None),
        ("Rotational speed [rpm]", "rpm", None),
        ("Number of revolutions", "1", "rotations"),
    ]
    assert table.columns[1].values.tolist() == [1.25, 1.5, 0.0]
    assert table.columns[4].values.tolist() == [23.125, 23.25, 23.5]
    assert table.columns[6].values.tolist() == [0.0, 1.0, 2.0]
    assert table.notes == ()


def test_lines_above_mixed_ends_and_columns_in_another_order():
    content = (
        b"T-11 tester\r\nSample: 100Cr6 / C45\n\rNumber of revolutions; Rotational speed [rpm] ;Friction force [mN];"
        b"Time [min]\n1;60;500;0.5\r2;60;510;1\r\n"
    )
    table = read(READER, content)
    assert table.header.startswith("T-11 tester\r\nSample")
    assert [(column.unit, column.signal) for column in table.columns] == [
        ("1", "rotations"),
        ("rpm", None),
        ("mN", "friction_force"),
        ("min", "time"),
    ]
    assert table.columns[3].values.tolist() == [0.5, 1.0]


def test_cut_anywhere_it_is_right_or_refused():
    check_every_cut(READER, T11, from_byte=90)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "empty file"),
        (T11.splitlines()[0], "no data row"),
        (b"\n".join(T11.splitlines()[1:]), "no header row"),
        (T11.replace(b"0,5;1,5;", b"0,5;"), "line 3: found 7 fields, expected 8"),
        (T11.decode().encode("utf-16")[:-1], "not utf-16"),
    ],
)
def test_broken_files_are_refused(content, message):
    with pytest.raises(ReaderError, match=message):
        read(READER, content)


def test_a_unit_that_is_none_is_left_open():
    assert read(READER, T11.replace(b"[N]", b"[div]")).columns[1].unit is None


def test_two_decimal_signs_never_give_a_number():
    column = read(READER, T11.replace(b"1,5;0,75", b"1.5;0,75")).columns[1]
    assert column.first_bad == (3, "1.5")
