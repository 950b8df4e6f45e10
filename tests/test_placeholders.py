"""Placeholders for numbers in every column of every reader: no channel is lost without a message."""

import re
from functools import cache

import numpy as np
import pytest
from built_files import tdms, xlsx
from hypothesis import given
from hypothesis import strategies as st
from reader_examples import EXAMPLES, FORCES, SHEET
from sweeps import others_slow

from tribopipe.base.errors import ReaderError
from tribopipe.readers.column_meanings import meanings_of
from tribopipe.readers.number_fields import is_mostly_numbers, parse_fields, remarks
from tribopipe.readers.reader import Hints, ReadTable, readers
from tribopipe.readers.tables import is_placeholder
from tribopipe.results.run import SourceFile

PLACEHOLDERS = [
    "OVL",
    "-",
    "---",
    "...",
    "*****",
    "#ERR",
    "1.#INF",
    "n/a",
    "#DIV/0!",
    "Overload",
    "-nan(ind)",
    "\u2013",
]
PLAIN = ["NaN", "nan", "NA"]
JUNK = ["8.0.1", "59.84.1", "12:30:05", "5N", "abc"]
FIRST = ("OVL", "NaN", "8.0.1")
"""One of each kind; the others are left to the slow tests."""
BINARY = {"ni-tdms", "workbook", "matlab", "tribopipe-hdf5", "surface-topography"}
"""Readers of files that are no text; of the first two, files are made here, and the others hold numbers as such."""
_NUMBERS = [re.compile(rf"\d+(?:{sign}\d+)?(?:[eE][+-]?\d+)?") for sign in (r"\.", ",")]


def read(name: str, content: bytes) -> ReadTable:
    return readers()[name].read(SourceFile("file", content), Hints())


def differences(table: ReadTable, whole: ReadTable) -> list[tuple[str, int]]:
    """Name column and row of each value that is another one; nothing where the tables differ otherwise."""
    if [c.name for c in table.columns] != [c.name for c in whole.columns]:
        return []
    pairs = [(one.name, one.values, other.values) for one, other in zip(table.columns, whole.columns, strict=True)]
    if any(one.shape != other.shape or one.dtype != other.dtype for _, one, other in pairs):
        return []
    return [(name, row) for name, one, other in pairs for row in np.flatnonzero(~same(one, other)).tolist()]


def same(one, other):
    return (one == other) | ((one != one) & (other != other))


@cache
def fields_of(name: str) -> list[tuple[int, int, str, int]]:
    """Find where each number of the table stands in the text: start, end, column and row.

    A number stands there if another one in its place changes one value of the table, and nothing else.
    """
    (example, *_) = EXAMPLES[name]
    text, whole = example.content.decode(example.encoding), read(name, example.content)
    found: dict[tuple[str, int], tuple[int, int, str, int]] = {}
    numbers = {number.span(): number for pattern in _NUMBERS for number in pattern.finditer(text)}
    for number in sorted(numbers.values(), key=lambda number: len(number[0])):
        digit = "7" if number[0][0] != "7" else "8"
        spoiled = text[: number.start()] + digit + text[number.end() :]
        try:
            changed = differences(read(name, spoiled.encode(example.encoding)), whole)
        except ReaderError:
            continue
        if len(changed) == 1:
            found[changed[0]] = (*number.span(), *changed[0])
    return list(found.values())


def with_field(name: str, field: tuple[int, int, str, int], text: str) -> bytes:
    (example, *_) = EXAMPLES[name]
    content = example.content.decode(example.encoding)
    start = field[0] - (content[field[0] - 1] in "+-")
    return (content[:start] + text + content[field[1] :]).encode(example.encoding)


def text_readers() -> list[str]:
    return sorted(set(readers()) - BINARY)


@pytest.mark.slow
@pytest.mark.parametrize("name", text_readers())
def test_the_numbers_of_every_column_are_found(name):
    """Without it, the tests below would hold of nothing."""
    (example, *_) = EXAMPLES[name]
    whole = read(name, example.content)
    made = {"segment", "motion"} | ({"x", "y"} if name == "gwyddion-text" else set())
    numeric = {column.name for column in whole.columns if column.first_bad is None} - made
    assert {column for _, _, column, _ in fields_of(name)} == numeric


@pytest.mark.parametrize("token", others_slow([*PLACEHOLDERS, *PLAIN, *JUNK], *FIRST))
@pytest.mark.parametrize("name", text_readers())
def test_no_channel_is_lost_without_a_message(name, token):
    (example, *_) = EXAMPLES[name]
    whole = read(name, example.content)
    if example.encoding == "shift_jis" and not token.isascii():
        pytest.skip("this encoding has no such sign")
    for field in fields_of(name):
        check(name, whole, with_field(name, field, token), field[2], field[3], token)


@pytest.mark.parametrize("name", others_slow(text_readers(), "delimited", "pcs-instruments"))
def test_no_number_with_the_other_decimal_sign_is_read_as_another_number(name):
    """59.841 where the others have commas is neither 59841 nor a reason to drop the column."""
    (example, *_) = EXAMPLES[name]
    whole = read(name, example.content)
    text = example.content.decode(example.encoding)
    commas = any("," in text[start:end] for start, end, _, _ in fields_of(name))
    token = "59.841" if commas else "59,841"
    for field in fields_of(name):
        content = with_field(name, field, token)
        table, _ = attempt(name, content)
        read_right = table is not None and 59.841 in next(c for c in table.columns if c.name == field[2]).values
        if not read_right:
            check(name, whole, content, field[2], field[3], token)


def attempt(name: str, content: bytes) -> tuple[ReadTable | None, str]:
    try:
        return read(name, content), ""
    except ReaderError as error:
        return None, str(error)


def check(name: str, whole: ReadTable, content: bytes, column: str, row: int, token: str) -> None:
    """Check that one spoiled field is refused, or is missing and named, and all else is as it was."""
    case = f"{name}: {token!r} in row {row} of {column!r}"
    table, refused = attempt(name, content)
    if table is None:
        assert re.search(r"line \d+", refused), f"{case}: refused without a line: {refused}"
        assert token not in [*PLAIN, *PLACEHOLDERS] or row == 0, f"{case}: refused: {refused}"
        return
    before, after = (next((c for c in each.columns if c.name == column), None) for each in (whole, table))
    assert after is not None, f"{case}: the column is gone: {[c.name for c in table.columns]}"
    said = " ".join(remarks(table))
    assert (after.unit, after.signal, after.axis) == (before.unit, before.signal, before.axis), case
    if len(after.values) < len(before.values):
        assert re.search("omitted|left out|declares", said), f"{case}: the row is lost: {said!r}"
        return
    if after.first_bad is not None:
        assert token not in [*PLAIN, *PLACEHOLDERS], f"{case} is kept as text"
        assert after.first_bad[1] in token, case
        assert is_mostly_numbers(after), case
        assert token in said, case
        assert meanings_of(table.columns).keys() == meanings_of(whole.columns).keys(), case
        return
    assert np.isnan(after.values[row]), f"{case} is {after.values[row]}"
    assert np.isnan(np.delete(after.values, row)).sum() == np.isnan(np.delete(before.values, row)).sum(), case
    assert token in PLAIN or token in said, f"{case} is not named: {said!r}"


@pytest.mark.parametrize("token", others_slow([*PLACEHOLDERS, *JUNK], "OVL", "---", "1.#INF", "8.0.1"))
@pytest.mark.parametrize(("name", "at"), [("workbook", 0), ("workbook", 1), ("ni-tdms", 0), ("ni-tdms", 1)])
def test_no_channel_of_a_binary_file_is_lost_without_a_message(name, at, token):
    whole = read(name, EXAMPLES[name][0].content)
    column = whole.columns[at + (name == "ni-tdms")].name
    check(name, whole, with_cell(name, at, token), column, 1, token)


def with_cell(name: str, at: int, token: str) -> bytes:
    """Make a workbook or TDMS file with a text in the second row of a column."""
    if name == "workbook":
        rows = [list(row) for row in SHEET]
        rows[4][at] = token
        return xlsx({"Data": rows})
    channel = list(FORCES)[at]
    values, properties = FORCES[channel]
    texts = [str(value) for value in values]
    texts[1] = token
    return tdms({"Test": FORCES | {channel: (texts, properties)}}, author="N. N.")


@given(st.lists(st.one_of(st.sampled_from([*PLACEHOLDERS, *PLAIN, ""]), st.floats(-1e9, 1e9).map(repr)), max_size=20))
def test_numbers_among_placeholders_are_themselves(fields):
    parsed = parse_fields(fields, ".")
    gaps = [field in PLAIN or field == "" or is_placeholder(field) for field in fields]
    assert np.isnan(parsed.values).tolist() == gaps
    assert parsed.values[~np.array(gaps, bool)].tolist() == [
        float(f) for f, gap in zip(fields, gaps, strict=True) if not gap
    ]
    assert (parsed.placeholders or (0,))[0] == sum(field in PLACEHOLDERS for field in fields)


@given(st.floats(allow_nan=False, allow_infinity=False), st.sampled_from(".,"))
def test_no_number_is_a_placeholder(number, decimal):
    assert not is_placeholder(repr(number).replace(".", decimal))
