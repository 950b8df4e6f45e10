"""Maps that Gwyddion wrote as text: a matrix of heights becomes a list of points."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tribopipe.base.errors import ReaderError
from tribopipe.readers.formats.gwyddion import GwyddionReader
from tribopipe.readers.reader import Hints, Reader, ReadTable
from tribopipe.results.run import SourceFile

READER = GwyddionReader()
WORDS = {
    "English": ("Channel", "Width", "Height", "Value units"),
    "German": ("Kanal", "Breite", "Höhe", "Value units"),
    "French": ("Canal", "Largeur", "Hauteur", "Unités"),
    "Russian": ("Канал", "Ширина", "Высота", "Единицы"),
    "Japanese": ("チャンネル", "幅", "高さ", "値の単位"),
}
MATRIX = "1.5\t2.5\t3\n-4e-9\t5\t6\n"


def written(words=WORDS["English"], matrix=MATRIX, wide="12 µm", high="400 nm", unit="m") -> str:
    title, *others = words
    said = dict(zip(others, (wide, high, unit), strict=True))
    return f"# {title}: My: Channel\n" + "".join(f"# {word}: {text}\n" for word, text in said.items()) + matrix


def read(text: str | bytes, **hints: str) -> ReadTable:
    return READER.read(SourceFile("map.txt", text.encode() if isinstance(text, str) else text), Hints(**hints))


def test_is_a_reader():
    assert isinstance(READER, Reader)
    assert READER.holds == "profile"


@pytest.mark.parametrize("language", WORDS)
def test_matrix_becomes_points_in_any_language(language):
    text = written(WORDS[language])
    table = read(text)
    assert [(column.name, column.axis, column.unit) for column in table.columns] == [
        ("x", "x", "µm"),
        ("y", "y", "nm"),
        ("z", "z", "m"),
    ]
    x, y, z = (column.values for column in table.columns)
    assert x.tolist() == [2.0, 6.0, 10.0] * 2
    assert y.tolist() == [100.0] * 3 + [300.0] * 3
    assert z.tolist() == [1.5, 2.5, 3.0, -4e-9, 5.0, 6.0]
    assert table.header == text.removesuffix(MATRIX)
    assert READER.match(SourceFile("a", text.encode())).confidence >= 0.9


def test_decimal_commas_and_blanks():
    table = read(written(matrix="1,5  2,5 3\r\n-4e-9 5 6", wide="1,2e+1 µm"))
    assert table.columns[0].values.tolist() == [2.0, 6.0, 10.0] * 2
    assert table.columns[2].values.tolist() == [1.5, 2.5, 3.0, -4e-9, 5.0, 6.0]
    assert any("no line end" in note for note in table.notes)


def test_pixels_that_were_not_measured():
    assert np.isnan(read(written(matrix="1 nan 3\n4 5 6\n")).columns[2].values).sum() == 1


@given(st.integers(0, len(written().encode())))
def test_cut_anywhere_it_is_right_or_refused(size):
    whole = np.array([1.5, 2.5, 3.0, -4e-9, 5.0, 6.0])
    content = written().encode()[:size]
    try:
        table = read(content)
    except ReaderError:
        return
    values = table.columns[2].values
    if not np.array_equal(values, whole[: len(values)]):
        assert any("no line end" in note for note in table.notes)


@settings(max_examples=50)
@given(st.integers(2, 5), st.integers(2, 6), st.randoms(use_true_random=False))
def test_written_heights_come_back_exactly(rows, columns, random):
    heights = np.array([[random.uniform(-1e-6, 1e-6) for _ in range(columns)] for _ in range(rows)])
    matrix = "".join("\t".join(map(repr, row)) + "\n" for row in heights.tolist())
    assert np.array_equal(read(written(matrix=matrix)).columns[2].values, heights.ravel())


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (written(matrix=""), "above a matrix"),
        (MATRIX, "no comment lines with two extents"),
        (written(wide="12"), "no comment lines with two extents"),
        (written(wide="12 s"), "no comment lines with two extents"),
        (written(wide="0 µm"), "found a map of 0 µm by 400 nm; expected positive extents"),
        (written(unit="parsnips"), "no comment lines with two extents"),
        (written(matrix="x y z\n1 2 3\n"), "line 5: found 'x y z' below the comments"),
        (written(matrix="1 2 3\n4 five 6\n"), "line 6: found 'five' in the matrix"),
        (written(matrix="1 2 3\n4 5\n6 7 8\n"), "line 6: found 2 fields, expected 3"),
        (written(matrix="1 2 3\n4 5 6 7\n"), "line 6: found 4 fields, expected 3"),
        (written(matrix="1.5 2,5 3\n"), "both . and ,"),
        ("", "empty file"),
    ],
)
def test_what_is_no_map_is_refused(text, said):
    with pytest.raises(ReaderError, match=r"^map\.txt") as caught:
        read(text)
    assert said in str(caught.value)


@pytest.mark.parametrize("content", [b"", b"\0", b"# a: 1 mm\nx,y\n1,2\n", MATRIX.encode(), b"#" * (1 << 20)])
def test_other_files_are_left_alone(content):
    assert READER.match(SourceFile("a.txt", content)).confidence <= 0.2
