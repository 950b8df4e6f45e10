"""Kyowa PCD-400A: Shift-JIS, quoted labels, a row of units above the names, channels in gram-force."""

import pytest
from small_exports import KYOWA, check_every_cut, claimed_by, read

from tribopipe.base.errors import ReaderError
from tribopipe.readers.delimited import DelimitedReader
from tribopipe.readers.formats.kyowa import KyowaReader
from tribopipe.readers.reader import Reader
from tribopipe.results.run import SourceFile

READER = KyowaReader()
ROW_OF_NAMES = '"Time(sec)","CH1","CH2"\r\n'.encode("cp932")
COLUMNS = [("Time(sec)", "sec", "time"), ("CH1", "gf", None), ("CH2", "gf", None)]


def test_is_a_reader_and_claims_its_files_alone():
    assert isinstance(READER, Reader)
    assert claimed_by(READER) == ["kyowa-pcd"]


@pytest.mark.parametrize("end", ["\r\n", "\n", "\r"])
@pytest.mark.parametrize("encoding", ["cp932", "utf-8", "utf-8-sig", "utf-16"])
def test_small_file(end, encoding):
    content = KYOWA.decode("cp932").replace("\r\n", end).encode(encoding)
    assert READER.match(SourceFile("x", content)).confidence >= 0.9
    table = read(READER, content)
    assert [(column.name, column.unit, column.signal) for column in table.columns] == COLUMNS
    assert [column.values.tolist() for column in table.columns] == [
        [0.0, 0.01, 0.02],
        [1.25, 1.375, -1.5],
        [-500.5, -501.0, -499.875],
    ]
    assert table.header.startswith('"ID番号","PCD-400A"')
    assert table.facts == {
        "started": "2019-06-03T14:05:33",
        "title": "摩擦試験 No.3",
        "instrument": "Kyowa PCD-400A",
    }
    assert table.notes == ("g and kg of CH1, CH2 are interpreted as gram-force and kilogram-force",)


def test_without_a_row_of_names_channels_are_named_above():
    content = KYOWA.replace(ROW_OF_NAMES, b"")
    assert [(column.name, column.unit, column.signal) for column in read(READER, content).columns] == COLUMNS
    named = content.decode("cp932").replace('"CH名称","",""', '"CH名称","摩擦力"').replace('"g","g"', '"kg","με"')
    table = read(READER, named.encode("utf-8"))
    assert [(column.name, column.unit) for column in table.columns] == [
        ("Time(sec)", "sec"),
        ("摩擦力", "kgf"),
        ("CH2", "με"),
    ]
    assert table.columns[0].values.tolist() == [0.0, 0.01, 0.02]


def test_english_labels_and_quoted_numbers():
    content = (
        b'"ID No.","EDX-100A"\n"Test Date","03/06/2019","14:05:33"\n"CH No","CH1"\n"Unit","N"\n"Time(sec)","CH1"\n'
        b'"0.00","1.5"\n"0.01","-2.5"\n'
    )
    assert READER.match(SourceFile("x", content)).confidence >= 0.9
    table = read(READER, content)
    assert [(column.name, column.unit) for column in table.columns] == [("Time(sec)", "sec"), ("CH1", "N")]
    assert table.columns[1].values.tolist() == [1.5, -2.5]
    assert table.facts == {"instrument": "Kyowa EDX-100A"}  # day or month first: not known


def test_fewer_samples_than_the_header_claims():
    table = read(READER, KYOWA.replace(b",3\r\n", b",2000\r\n"))
    assert table.notes[-1] == "the header declares 2,000 samples; 3 are present"


def test_cut_anywhere_it_is_right_or_refused():
    check_every_cut(READER, KYOWA, from_byte=len(KYOWA) - 120)


def test_a_cut_file_is_not_left_to_another_reader():
    for size in range(len(KYOWA) - 70, len(KYOWA), 7):
        source = SourceFile("x", KYOWA[:size])
        assert READER.match(source).confidence > DelimitedReader().match(source).confidence


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "empty file"),
        (KYOWA[: KYOWA.index(ROW_OF_NAMES) + len(ROW_OF_NAMES)], "no data row"),
        (KYOWA[KYOWA.index(ROW_OF_NAMES) :], "no unit row"),
        (KYOWA.replace(b"0.01,1.375,", b"0.01,"), "line 19: found 2 fields, expected 3"),
        (KYOWA.replace(b"1.375,", b"1.375,7,"), "line 19: found 4 fields, expected 3"),
    ],
)
def test_broken_files_are_refused(content, message):
    with pytest.raises(ReaderError, match=message):
        read(READER, content)


def test_another_encoding_than_named_is_refused():
    with pytest.raises(ReaderError, match="not utf-8"):
        read(READER, KYOWA, encoding="utf-8")
    with pytest.raises(ReaderError, match="no unit row"):
        read(READER, KYOWA, encoding="latin-1")


def test_columns_in_another_order_and_a_unit_that_is_none():
    content = KYOWA.decode("cp932").replace('"g","g"', '"V","目盛"').replace('"CH1","CH2"\r\n0', '"CH2","CH1"\r\n0')
    table = read(READER, content.encode("cp932"))
    assert [(column.name, column.unit) for column in table.columns[1:]] == [("CH2", "V"), ("CH1", None)]
