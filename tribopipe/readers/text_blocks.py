"""Texts in which words and rows of numbers take turns: a head, the rows of a step, the next head, its rows.

A line of words begins with a letter, or with a mark such as ``*``; whatever else is not blank is a row. A head is a
run of lines of words, and the rows below it reach to the next head. The rows of several blocks are put one below the
other, with a column ``segment`` that counts them from 1.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import accumulate, groupby, pairwise
from typing import NamedTuple

import numpy as np

from tribopipe.base.errors import ReaderError, UnitError
from tribopipe.base.units import to_si
from tribopipe.documents.signals import SIGNALS, SignalName
from tribopipe.readers.delimited import read_table
from tribopipe.readers.layout import Decimal, Layout
from tribopipe.readers.number_fields import is_mostly_numbers
from tribopipe.readers.reader import ReadColumn, ReadTable
from tribopipe.readers.table_parts import SEGMENT, column_below
from tribopipe.readers.tables import PLACEHOLDER, is_number
from tribopipe.readers.text import LINE_END, LONGEST_LINE, Text, sampled_rows

_SAMPLE_ROWS = 50
_MOST_LISTED = 4
_GAP = b"(?i:" + PLACEHOLDER.encode() + b")"
# A placeholder with a number, or another one, behind it is the first field of a row.
_NO_WORD = (
    rb"(?!(?i:nan|na|inf|infinity)(?![A-Za-z]))"
    rb"(?!" + _GAP + rb"\"?(?: *[,;\t]| ) *\"?(?:[+-]?[.,]?\d|" + _GAP + rb"\"? *[,;\t\r\n]))"
)
_WORDS = re.compile(rb"[\r\n] *[\"'+-]?" + _NO_WORD + rb"[A-Za-z_*#<\[(\\\x80-\xff][^\r\n]*")
_BLANK_LINES = re.compile(rb"(?:[ \t,;]*(?:\r\n?|\n))*")
_ROW = re.compile(rb"[^\r\n ][^\r\n]*")
# One digit other than 0 before the decimal separator may be what is left of 1.953125E-5.
_WHOLE = re.compile(r"[+-]?(?:0|\d\d+)[.,](?P<decimals>\d+)", re.ASCII)


class Block(NamedTuple):
    """Lines of words, and the rows of numbers below them."""

    head: tuple[str, ...]
    """Lines that are not blank, without blanks around them."""
    start: int
    """Byte at which the rows start; the same as ``end`` where there are none."""
    end: int


@dataclass(frozen=True)
class Segment:
    """A block's rows, how they are written, and how many of them its head claims."""

    block: Block
    layout: Layout
    claimed: int | None = None


def find_blocks(text: Text) -> list[Block]:
    """Divide a text into heads and rows; the last block has no rows where the text ends in words.

    Raises ``ReaderError`` where a first row is too long for one.
    """
    blocks: list[Block] = []
    head: list[str] = []
    for (start, end), (following, _) in pairwise([*_words(text), (len(text.content),) * 2]):
        line = text.content[start:end].decode().strip(" \r\n")
        head += [line] if line.strip() else []
        rows = _rows_between(text, end, following)
        if rows is not None:
            blocks.append(Block(tuple(head), *rows))
            head = []
    return [*blocks, Block(tuple(head), len(text.content), len(text.content))] if head else blocks


def _words(text: Text) -> Iterator[tuple[int, int]]:
    """Give start and end of each line of words; nothing, but its place, of a first line that is none."""
    first = _WORDS.match(b"\n" + text.content[text.start : text.start + LONGEST_LINE])
    yield text.start, text.start + (first.end() - 1 if first else 0)
    for line in _WORDS.finditer(text.content, text.start):
        yield line.start() + 1, line.end()


def _rows_between(text: Text, start: int, end: int) -> tuple[int, int] | None:
    """Find the rows in a part of a text, without lines of nothing but separators around them."""
    content = text.content
    filled = start + len(content[start:end].rstrip(b" \t\r\n,;"))
    if filled == start:
        return None
    blank = _BLANK_LINES.match(content, start, end)
    first = blank.end() if blank else start
    if filled - first > LONGEST_LINE and not LINE_END.search(content, first, first + LONGEST_LINE):
        raise ReaderError(
            f"{text.name}, line {line_at(text, first)}: found more than {LONGEST_LINE:,} characters in one line; "
            "expected a data row; check that the line endings of the file are intact"
        )
    last = LINE_END.search(content, filled, end)
    return first, last.end() if last else end


def line_at(text: Text, offset: int) -> int:
    """Return the number of the line that starts at a byte."""
    return 1 + _line_ends(text.content, text.start, offset)


def _line_ends(content: bytes, start: int, end: int) -> int:
    pairs = content.count(b"\r\n", start, end)
    return content.count(b"\n", start, end) + content.count(b"\r", start, end) - pairs


def count_rows(text: Text, block: Block) -> int:
    """Count the rows of a block."""
    return sum(1 for _ in _ROW.finditer(text.content, block.start, block.end))


def sample_rows(text: Text, block: Block, separator: str) -> list[list[str]]:
    """Split the first rows of a block into fields."""
    return _split(text.content[block.start : min(block.end, block.start + LONGEST_LINE)], separator)[:_SAMPLE_ROWS]


def _split(rows: bytes, separator: str) -> list[list[str]]:
    lines = re.split(r"\r\n?|\n", rows.decode(errors="ignore"))
    return [row.cells for row in sampled_rows([f"{line}\n" for line in lines if line.strip(" ")], separator)]


def row_width(names: int, rows: Sequence[Sequence[str]]) -> int:
    """Return the number of fields of the longest sampled row, where those beyond the names are empty."""
    return max(names, *(len(row) for row in rows if not any(row[names:])), 0)


def row_layout(text: Text, block: Block, names: Sequence[str], separator: str, decimal: Decimal | None) -> Layout:
    """Lay out the rows of a block below known column names; the decimal separator is found if not given."""
    rows = sample_rows(text, block, separator)
    sign = decimal or decimal_sign(rows, separator)
    return Layout(separator, sign, tuple(names), 1, "", row_width(len(names), rows), len(names))


def decimal_sign(rows: Sequence[Sequence[str]], separator: str) -> Decimal:
    """Report the decimal separator of sampled rows: a comma where numbers have one, and none has a point."""
    cells = [cell for row in rows for cell in row]
    commas = any(re.fullmatch(r"[+-]?\d+,\d+(?:[eE][+-]?\d+)?", cell) for cell in cells)
    return "," if separator != "," and commas and not any("." in cell for cell in cells) else "."


def refuse_torn_rows(text: Text, segments: Sequence[Segment], blocks: Sequence[Block]) -> None:
    """Refuse a row that a word at its beginning makes the first line of the next head, so that it would be lost.

    Raises ``ReaderError`` with its line, also where that line has a field too long to show whether it is such a
    row.
    """
    layouts = {segment.block.end: segment.layout for segment in segments if segment.block.start < segment.block.end}
    for block, following in pairwise(blocks):
        layout = layouts.get(block.end)
        if layout and following.head:
            _refuse_torn_row(text, block.end, following.head[0], layout)


def _refuse_torn_row(text: Text, end: int, line: str, layout: Layout) -> None:
    """Refuse the first line below the rows that end at a byte where it is a row itself, or cannot be divided."""
    fields = next(iter(_split(line.encode(), layout.separator)), None)
    if fields is None:
        raise ReaderError(
            f"{text.name}, line {_filled_line_at(text, end)}: found a field of more than {LONGEST_LINE:,} "
            "characters; expected a data row or the next step; correct or delete that line"
        )
    first, *others = fields
    numbers = [cell for cell in others if cell]
    if len(fields) >= layout.least > 1 and numbers and all(is_number(cell, ".,") for cell in numbers):
        raise ReaderError(
            f"{text.name}, line {_filled_line_at(text, end)}: found {first!r} at the beginning of a row; expected a "
            "number; correct or delete that line"
        )


def _filled_line_at(text: Text, offset: int) -> int:
    """Give the number of the first line from a byte on that holds more than blanks and separators."""
    blank = _BLANK_LINES.match(text.content, offset)
    return line_at(text, blank.end() if blank else offset)


def read_segments(text: Text, segments: Sequence[Segment], *, numbered: bool = True) -> ReadTable:
    """Read the rows of all segments, one below the other; ``numbered`` adds the column that counts the segments.

    The last row is left out, with a note, where the file ends without a line end and may have cut it. Raises
    ``ReaderError`` where rows do not fit their names, or where one column comes in two units.
    """
    whole, notes = _without_cut_row(text, segments)
    if not whole:
        raise ReaderError(
            f"{text.name}: found no complete data row; expected at least one; the file is incomplete: copy it again "
            "from the instrument"
        )
    groups = [list(group) for _, group in groupby(whole, key=lambda segment: segment.layout)]
    tables = [read_table(_alone(text, group), group[0].layout) for group in groups]
    counts = [count_rows(text, segment.block) for segment in whole]
    columns = _joined(text, tables)
    if sum(counts) != len(columns[0].values):
        raise ReaderError(
            f"{text.name}: found {len(columns[0].values):,} rows in {sum(counts):,} data lines; expected one line per "
            "row; remove quotation marks"
        )
    notes += [note for table in tables for note in table.notes if note not in notes]
    notes += _broken_claims(segments, counts) + _repeated(columns, counts)
    if numbered:
        number = np.repeat(np.arange(1.0, len(counts) + 1), counts)
        columns = (*columns, ReadColumn(SEGMENT, number, "1"))
    header, line_of = outside(text, segments), partial(_line_of, tables)
    return ReadTable(columns, header, (*text.notes, *notes), line_of=line_of, decimal=tables[0].decimal)


def _line_of(tables: Sequence[ReadTable], row: int) -> int:
    """Return the line number of a row in tables that follow each other in one file."""
    first, *others = tables
    rows = len(first.columns[0].values)
    if row >= rows and others:
        return _line_of(others, row - rows)
    return first.line_of(row) if first.line_of is not None else row + 1


def _without_cut_row(text: Text, segments: Sequence[Segment]) -> tuple[list[Segment], list[str]]:
    """Leave out the row at the end of a file that may have been cut."""
    *others, last = segments
    block = last.block
    if not text.unterminated or block.end < len(text.content):
        return list(segments), []
    start = max(text.content.rfind(end, block.start) for end in (b"\r", b"\n")) + 1 or block.start
    above = _split(text.content[max(block.start, start - LONGEST_LINE) : start], last.layout.separator)[-_SAMPLE_ROWS:]
    if _is_whole(_split(text.content[start:], last.layout.separator), above):
        return list(segments), []
    note = f"line {line_at(text, start)}, the last one, has no line ending and is omitted, since it may be truncated"
    kept = [replace(last, block=block._replace(end=start))] if start > block.start else []
    return [*others, *kept], [note]


def _is_whole(final: Sequence[Sequence[str]], above: Sequence[Sequence[str]]) -> bool:
    """Return whether a row without a line end is whole: it ends in a separator or as many decimals as all above."""
    last = final[-1] if final else ()
    if not last or {len(row) for row in above} != {len(last)}:
        return False
    endings = [_WHOLE.fullmatch(row[-1]) for row in above]
    end = _WHOLE.fullmatch(last[-1])
    if not last[-1] or end is None:
        return not last[-1] and not any(row[-1] for row in above)
    return {len(ending["decimals"]) if ending else 0 for ending in endings} == {len(end["decimals"])}


def _alone(text: Text, segments: Sequence[Segment]) -> Text:
    """Give the rows of some segments alone, everything else made blank so that lines keep their numbers."""
    parts = []
    done = text.start
    for block in (segment.block for segment in segments):
        parts += [b"\n" * _line_ends(text.content, done, block.start), text.content[block.start : block.end]]
        done = block.end
    return Text(text.name, b"".join(parts) + b"\n")


def outside(text: Text, segments: Sequence[Segment]) -> str:
    """Give everything but the rows, verbatim."""
    starts = [text.start, *(segment.block.end for segment in segments)]
    ends = [*(segment.block.start for segment in segments), len(text.content)]
    return b"".join(text.content[start:end] for start, end in zip(starts, ends, strict=True)).decode()


def _joined(text: Text, tables: Sequence[ReadTable]) -> tuple[ReadColumn, ...]:
    """Put tables one below the other, column by name; a column missing in one has no values there."""
    if len(tables) == 1:
        return tables[0].columns
    named = [{column.name: column for column in table.columns} for table in tables]
    lengths = [len(table.columns[0].values) for table in tables]
    return tuple(_one_column(text, name, named, lengths) for name in dict.fromkeys(n for each in named for n in each))


def _one_column(text: Text, name: str, named: Sequence[Mapping[str, ReadColumn]], lengths: Sequence[int]) -> ReadColumn:
    found = [each[name] for each in named if name in each]
    units = {column.unit for column in found}
    if len(units) > 1:
        raise ReaderError(
            f"{text.name}, column {name!r}: found the units {', '.join(sorted(map(str, units)))} in different "
            "segments; expected one unit; split the file"
        )
    missing = replace(found[0], first_bad=None, placeholders=None)
    return column_below(
        [
            each.get(name) or replace(missing, values=np.full(length, np.nan))
            for each, length in zip(named, lengths, strict=True)
        ]
    )


def _broken_claims(segments: Sequence[Segment], counts: Sequence[int]) -> list[str]:
    """Report where heads claim other numbers of rows than there are."""
    held = [*counts, *[0] * (len(segments) - len(counts))]
    broken = [
        f"segment {number} declares {segment.claimed} and contains {count}"
        for number, (segment, count) in enumerate(zip(segments, held, strict=True), 1)
        if segment.claimed is not None and segment.claimed != count
    ]
    return [f"the numbers of rows differ from those in the header: {listed(broken)}"] if broken else []


def _repeated(columns: Sequence[ReadColumn], counts: Sequence[int]) -> list[str]:
    """Report which segments repeat the one before, number for number."""
    numeric = [column.values for column in columns if column.first_bad is None]
    repeated = [
        str(number)
        for number, ((first, start), (_, end)) in enumerate(pairwise(pairwise([0, *accumulate(counts)])), 2)
        if start - first == end - start > 1
        and all(np.array_equal(values[first:start], values[start:end], equal_nan=True) for values in numeric)
    ]
    return [f"segments identical to the one before: {listed(repeated)}"] if repeated else []


def listed(items: Sequence[str]) -> str:
    """Name the first few of many, and report how many more there are."""
    more = [f"and {len(items) - _MOST_LISTED} more"] if len(items) > _MOST_LISTED else []
    return ", ".join([*items[:_MOST_LISTED], *more])


def measures(unit: str | None, signal: SignalName) -> bool:
    """Return whether a column of this unit can be the signal; one without a unit may be, once it has one."""
    try:
        return unit is None or to_si(1.0, unit, SIGNALS[signal].kind) is not None
    except UnitError:
        return False


def with_meaning(column: ReadColumn, signal: SignalName | None) -> ReadColumn:
    """Report what a column of numbers is, where its unit allows that and it is not empty."""
    if signal is None or not measures(column.unit, signal) or not is_mostly_numbers(column):
        return column
    empty = column.first_bad is None and np.isnan(column.values).all()
    return column if empty else replace(column, signal=signal)
