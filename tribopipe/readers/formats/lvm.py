r"""LabVIEW measurement file (.lvm): what "Write To Measurement File" puts into text, segment after segment.

    LabVIEW Measurement
    Writer_Version⟨TAB⟩2
    Separator⟨TAB⟩Tab
    Decimal_Separator⟨TAB⟩.
    Multi_Headings⟨TAB⟩Yes
    X_Columns⟨TAB⟩One
    Date⟨TAB⟩2017/09/20
    ***End_of_Header***

    Channels⟨TAB⟩2
    Samples⟨TAB⟩2000⟨TAB⟩2000
    Date⟨TAB⟩2017/09/25⟨TAB⟩2017/09/25
    Time⟨TAB⟩13:45:59.2289⟨TAB⟩13:45:59.2289
    Y_Unit_Label⟨TAB⟩N⟨TAB⟩micrometer
    X_Dimension⟨TAB⟩Time⟨TAB⟩Time
    X0⟨TAB⟩0.0E+0⟨TAB⟩0.0E+0
    Delta_X⟨TAB⟩0.000143⟨TAB⟩0.000143
    ***End_of_Header***
    X_Value⟨TAB⟩fz_N⟨TAB⟩dx_um⟨TAB⟩Comment
    0.000000⟨TAB⟩13.157429⟨TAB⟩164.995293

* The file's header comes once. Each segment has a header of its own and a row of names (Multi_Headings Yes), or all
  packets of samples follow one such header (Multi_Headings No; Samples is then the length of one packet).
* In a segment's header, what belongs to a column stands in that column. Labels of units are free texts: one that is
  no unit, and brackets in the name neither, leaves the column without.
* X_Columns One: a first column X_Value for all. Multi: an X_Value before each channel. No: the first column is empty,
  and X_Value is computed as X0 + n·Delta_X; where rows are more than Samples, packets may lie apart, so that the
  computed column has no meaning. Where X_Dimension is Time, X_Value is the time in s from the start of the segment.
* The last column, Comment, has mostly neither values nor separators in the rows.
* Separator is Tab or Comma. Files of version 1 have no Decimal_Separator: the sign is taken from the numbers.
* Blocks from ***Start_Special*** to ***End_Special*** are left out with a note.

Facts: NI, "Specification for the LabVIEW Measurement File (.lvm)", tutorial 4139. What a channel measures, and on
which machine, is not in the file.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from tribopipe.base.errors import ReaderError
from tribopipe.base.units import is_unit
from tribopipe.readers.headed_tables import judge_lines, moment
from tribopipe.readers.layout import Decimal, Layout
from tribopipe.readers.reader import Hints, Holds, Match, ReadColumn, ReadTable
from tribopipe.readers.table_parts import SEGMENT
from tribopipe.readers.tables import count_in
from tribopipe.readers.text import Text, decode, trimmed
from tribopipe.readers.text_blocks import (
    Block,
    Segment,
    count_rows,
    decimal_sign,
    find_blocks,
    line_at,
    outside,
    read_segments,
    row_width,
    sample_rows,
    with_meaning,
)
from tribopipe.results.run import SourceFile

_TITLE = re.compile(r"LabVIEW Measurement[\t,; ]*")
_SPECIAL = re.compile(rb"\*\*\*Start_Special\*\*\*.*?(?:\*\*\*End_Special\*\*\*[^\r\n]*|\Z)", re.DOTALL)
_X = "X_Value"
_COMMENT = "Comment"
_END = "***End_of_Header***"
_NO_DATE = "1970"
"""Channels without a time have the beginning of LabVIEW's own, 1903/12/31 or 1904/01/01."""
_LONGEST_SYMBOL = 3
_UNIT_LABELS = {"Deg C": "degC", "Deg F": "degF", "Deg K": "K"}
_FACTS = {"Operator": "operator", "Test_Name": "title", "Project": "title", "Description": "comment"}
_SINCE_1904 = 1e9
"""Seconds from which X_Value is no time since a start, but one since 1904."""

Tags = Mapping[str, list[str]]
"""Lines of a header by their first field; the fields keep the column they stand in."""


@dataclass(frozen=True)
class _Heading:
    """Entries of the file header and the segment header that apply to the rows of the segment."""

    file: Tags
    own: Tags
    names: list[str]

    def flag(self, tag: str, default: str) -> str:
        """Give a setting of the file in small letters."""
        return (trimmed(self.file.get(tag, []))[1:] or [default])[0].lower()

    def at(self, tag: str, column: int) -> str:
        """Give what a tag states about a column."""
        fields = self.own.get(tag, [])
        return fields[column] if 0 < column < len(fields) else ""

    @property
    def is_time(self) -> bool:
        """Whether the values of x are times: by the dimension of the first channel, Time where none is given."""
        return (trimmed(self.own.get("X_Dimension", []))[1:] or ["Time"])[0] == "Time"

    @property
    def samples(self) -> int | None:
        """Number of samples that the longest channel claims."""
        claims = map(count_in, self.own.get("Samples", [])[1:])
        return max((claim for claim in claims if claim is not None), default=None)


class LvmReader:
    """LabVIEW measurement files, of one segment or several."""

    name = "labview-lvm"
    title = "LabVIEW measurement file (.lvm)"
    holds: Holds = "signals"
    suffixes = (".lvm",)

    @judge_lines
    def match(self, lines: list[str]) -> Match:
        """Judge by the first line."""
        first = next((line for line in lines if line.strip()), "").strip("\r\n")
        if _TITLE.fullmatch(first):
            return Match(0.98, "the first line is 'LabVIEW Measurement'")
        return Match(0.0, "the first line is not 'LabVIEW Measurement'")

    def read(self, source: SourceFile, hints: Hints) -> ReadTable:
        """Parse the file; ``ReaderError`` with file and line where it is broken."""
        written = decode(source, hints.encoding)
        text = _without_specials(written)
        segments, headings = _segments(text, find_blocks(text), hints)
        table = read_segments(text, segments, numbered=len(segments) > 1)
        columns, notes = _with_x(table.columns, headings)
        return replace(
            table,
            columns=tuple(column for column in columns if column.name != _COMMENT or column.first_bad),
            notes=(*table.notes, *notes, *_remarks(headings)),
            facts=_facts(headings[0]),
            header=outside(written, segments),
        )


def _without_specials(text: Text) -> Text:
    """Make special blocks blank, so that bytes and lines keep their places."""
    content = _SPECIAL.sub(lambda block: re.sub(rb"[^\r\n]", b" ", block[0]), text.content)
    if content == text.content:
        return text
    return replace(text, content=content, notes=(*text.notes, "blocks marked ***Start_Special*** are omitted"))


def _segments(text: Text, blocks: Sequence[Block], hints: Hints) -> tuple[list[Segment], list[_Heading]]:
    """Find the rows of each segment, and what is stated about them above."""
    if not blocks or not blocks[0].head or not _TITLE.fullmatch(blocks[0].head[0]):
        raise ReaderError(
            f"{text.name}, line 1: found a first line other than 'LabVIEW Measurement'; expected a LabVIEW measurement "
            "file; specify another reader in run.toml"
        )
    separator = hints.separator or ("\t" if any("\t" in line for line in blocks[0].head) else ",")
    file, first = _divided(blocks[0].head)
    settings = _tags(file, separator)
    headings: list[_Heading] = []
    segments: list[Segment] = []
    for block in (block for block in blocks if block.start < block.end):
        names = _fields(block.head[-1], separator) if block.head else []
        if len(names) < 2 or names[0] != _X:
            raise ReaderError(
                f"{text.name}, line {line_at(text, block.start)}: found data with no header line above them; expected "
                f"a header line that begins with {_X}; add or correct the header line, or export the file again with "
                "column headers"
            )
        own = first if block is blocks[0] else block.head
        heading = _Heading(settings, _tags(own, separator), trimmed(names))
        headings.append(heading)
        segments.append(_segment(text, block, heading, Hints(separator=separator, decimal=hints.decimal)))
    if not segments:
        raise ReaderError(
            f"{text.name}: found no data below the headers; expected a line that begins with {_X} and data rows; "
            "the file is incomplete: copy it again, or record the test again"
        )
    return segments, headings


def _divided(head: Sequence[str]) -> tuple[list[str], list[str]]:
    """Divide the first head into what is the file's and what is the first segment's."""
    end = next((number for number, line in enumerate(head) if line.startswith(_END)), len(head) - 1)
    return list(head[:end]), list(head[end + 1 :])


def _fields(line: str, separator: str) -> list[str]:
    return [field.strip() for field in line.split(separator)]


def _tags(head: Sequence[str], separator: str) -> dict[str, list[str]]:
    return {fields[0]: fields for line in head if (fields := _fields(line, separator))[0] not in (_X, _END)}


def _segment(text: Text, block: Block, heading: _Heading, hints: Hints) -> Segment:
    separator = hints.separator or "\t"
    names = heading.names
    if names[-1] == _COMMENT and not _has_comments(text, block, separator, len(names)):
        names = names[:-1]
    rows = sample_rows(text, block, separator)
    layout = Layout(
        separator=separator,
        decimal=hints.decimal or _decimal(heading, rows, separator),
        names=tuple(names),
        line=1,
        header="",
        width=row_width(len(names), rows),
        least=len(names) - (names[-1] == _COMMENT),
        units=tuple(_unit(heading, number) for number in range(len(names))),
        textual=frozenset({len(names) - 1} if names[-1] == _COMMENT else ()),
    )
    continued = heading.flag("Multi_Headings", "no") == "no" and count_rows(text, block) >= (heading.samples or 0)
    return Segment(block, layout, None if continued else heading.samples)


def _has_comments(text: Text, block: Block, separator: str, width: int) -> bool:
    """Return whether rows reach into the last column, by the number of separators."""
    separators = text.content.count(separator.encode(), block.start, block.end)
    return separators > count_rows(text, block) * (width - 2)


def _decimal(heading: _Heading, rows: Sequence[Sequence[str]], separator: str) -> Decimal:
    if heading.flag("Decimal_Separator", "") == "," and separator != ",":
        return ","
    return "." if heading.flag("Decimal_Separator", "") == "." else decimal_sign(rows, separator)


def _unit(heading: _Heading, column: int) -> str:
    """Give the unit of a column as its label has it, or nothing where that is none."""
    if heading.names[column] == _X:
        label = "s" if heading.is_time else heading.at("X_Unit_Label", column + 1)
    else:
        label = heading.at("Y_Unit_Label", column)
    label = _UNIT_LABELS.get(label, label)
    # A word such as "Volts" is a unit in small letters; of symbols, small letters are others.
    spellings = (label, label.lower()) if len(label) > _LONGEST_SYMBOL else (label,)
    return next((unit for unit in spellings if is_unit(unit)), "")


def _with_x(columns: Sequence[ReadColumn], headings: Sequence[_Heading]) -> tuple[list[ReadColumn], list[str]]:
    """Compute the values of x where the file leaves them out, and report where they are the time."""
    left_out = headings[0].flag("X_Columns", "one") == "no"
    if not left_out or columns[0].first_bad or not np.isnan(columns[0].values).all():
        return _with_time(columns, headings)
    columns, certain = _computed(columns, headings)
    if not certain:
        note = (
            "it is not used as time, since there may be gaps between packets or differences between channels; if "
            "X_Value is the time, map it to time in run.toml"
        )
        return columns, [f"X_Value is computed as X0 + n Delta_X, but {note}"]
    columns, notes = _with_time(columns, headings)
    return columns, ["X_Value is not in the file and is computed as X0 + n Delta_X", *notes]


def _with_time(columns: Sequence[ReadColumn], headings: Sequence[_Heading]) -> tuple[list[ReadColumn], list[str]]:
    """Take the values of x as the time where they are one, the same for all channels."""
    xs = [column for column in columns if re.fullmatch(rf"{_X}(?: \(\d+\))?", column.name)]
    broken = next((column for column in xs if column.first_bad), None)
    if broken is not None:
        xs = [broken]  # taken as the time, it is refused with its line
    if not xs or not all(heading.is_time for heading in headings):
        return list(columns), []
    if any(not np.array_equal(xs[0].values, other.values, equal_nan=True) for other in xs[1:]):
        return list(columns), [
            "the channels were sampled at different times, so that no X_Value column applies to all of them"
        ]
    if broken is None and np.nanmax(xs[0].values, initial=0.0) > _SINCE_1904:
        return list(columns), ["X_Value counts seconds from 1904, not from the start, and is not used as time"]
    return [with_meaning(column, "time") if column is xs[0] else column for column in columns], []


def _computed(columns: Sequence[ReadColumn], headings: Sequence[_Heading]) -> tuple[list[ReadColumn], bool]:
    """Fill the first column by X0 and Delta_X; return whether that holds for every row."""
    number = next((column.values for column in columns if column.name == SEGMENT), np.ones(len(columns[0].values)))
    values = np.full(len(number), np.nan)
    certain = True
    for segment, heading in enumerate(headings, 1):
        rows = int(np.sum(number == segment))
        grid = _grid(heading)
        certain = certain and grid is not None and rows <= (heading.samples or rows)
        if grid is not None:
            values[number == segment] = grid[0] + grid[1] * np.arange(rows)
    return [replace(columns[0], values=values, first_bad=None), *columns[1:]], certain


def _grid(heading: _Heading) -> tuple[float, float] | None:
    """Give X0 and Delta_X where all channels have the same."""
    try:
        first, step = (
            {float(field.replace(",", ".")) for field in heading.own.get(tag, [])[1:] if field}
            for tag in ("X0", "Delta_X")
        )
    except ValueError:
        return None
    return (first.pop(), step.pop()) if len(first) == len(step) == 1 else None


def _remarks(headings: Sequence[_Heading]) -> list[str]:
    """Give what was noted in the headers of segments."""
    notes = [" ".join(trimmed(heading.own.get("Notes", []))[1:]) for heading in headings]
    return [f"the header states: {note}" for note in dict.fromkeys(notes) if note]


def _facts(heading: _Heading) -> dict[str, str]:
    tags = {**heading.file, **{tag: fields for tag, fields in heading.own.items() if tag in _FACTS}}
    facts = {key: fields[1] for tag, key in _FACTS.items() if len(fields := tags.get(tag, [])) > 1 and fields[1]}
    for header in (heading.own, heading.file):
        stamps = zip(header.get("Date", [])[1:], header.get("Time", [])[1:], strict=False)
        started = next((moment(f"{date} {time}") for date, time in stamps if date >= _NO_DATE), None)
        if started:
            return {"started": started, **facts}
    return facts
