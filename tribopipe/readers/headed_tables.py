"""Tables that begin at a line known by its content: from that line to the layout, and to what it is made of."""

import re
from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Callable, Iterable, Set
from dataclasses import replace
from datetime import datetime
from functools import wraps
from typing import Any, ClassVar

from tribopipe.base.errors import ReaderError
from tribopipe.readers.delimited import read_table
from tribopipe.readers.layout import Decimal, Layout
from tribopipe.readers.reader import Hints, Holds, Match, ReadTable, refused
from tribopipe.readers.tables import bare_name, is_number
from tribopipe.readers.text import (
    BLANKS,
    LONGEST_LINE,
    SAMPLE_BYTES,
    Row,
    Text,
    decode,
    sample_lines,
    sampled_rows,
    trimmed,
)
from tribopipe.results.run import SourceFile

_YEAR_FIRST = re.compile(
    r"(?P<date>[12]\d{3}[-./]\d{1,2}[-./]\d{1,2})[\s,T]+(?P<hour>\d{1,2}):(?P<rest>[0-5]\d(?::[0-5]\d)?)(?![\d:])",
    re.ASCII,
)
_YEAR_LAST = re.compile(
    r"\b(?P<first>\d{1,2})[/.-](?P<second>\d{1,2})[/.-](?P<year>\d{4}) +(?P<hour>\d{1,2}):(?P<minute>\d\d)"
    r"(?::(?P<seconds>\d\d))?(?: *(?P<half>[AaPp])[Mm])?(?!\d)",
    re.ASCII,
)
_SIGN = re.compile(rb"\d([.,])\d")
_BRACKETS = re.compile(r"(?<!\s)\s*\[[^\[\]]*\]$")
"""Brackets at the end, matched from the first of the spaces before them: from each space would take quadratic time."""
_ALIKE = 10
"""Rows that have to end alike before a last line without a line end is taken for a whole one."""


def head_lines(source: SourceFile, encoding: str | None = None) -> list[str]:
    """Return the first lines of a file. Raises ``ReaderError`` if it is not text."""
    head = SourceFile(source.name, source.content[:SAMPLE_BYTES])
    return sample_lines(decode(head, encoding, partial=len(source.content) > SAMPLE_BYTES))


def judge_lines(judge: Callable[[Any, list[str]], Match]) -> Callable[[Any, SourceFile], Match]:
    """Make the method ``match`` of a reader from a method that judges the first lines of a text file."""

    @wraps(judge)
    def match(reader: Any, source: SourceFile) -> Match:
        try:
            return judge(reader, head_lines(source))
        except ReaderError as error:
            return refused(source, error)

    return match


def cells_of(line: str, separator: str) -> tuple[str, ...]:
    """Split one line into fields stripped of blanks; none where it is blank."""
    rows = sampled_rows([line], separator)
    return tuple(rows[0].cells) if rows else ()


def bare_key(name: str) -> str:
    """Write a column's name without unit, blanks and capitals: "Friction Force [N]" is "frictionforce"."""
    return re.sub(r"\s+", "", bare_name(_BRACKETS.sub("", name))).casefold()


def layout_below(
    text: Text, lines: list[str], body: int, names: tuple[str, ...], separator: str, decimal: Decimal | None
) -> Layout:
    """Lay out a table whose numbers begin at the index ``body`` of the lines; the decimal sign is found if not given.

    Rows may end in separators that the row of names does not have; where most do, one that does not is not whole.
    """
    header = "".join(lines[:body])
    rows = sampled_rows(lines[body:], separator)
    widths = Counter(len(row.cells) for row in rows if not any(row.cells[len(names) :]))
    usual = max(widths, key=lambda width: (widths[width], width), default=0)
    return Layout(
        separator=separator,
        decimal=decimal or _decimal_sign(text, len(header.encode()), rows, separator),
        names=names,
        line=body + 1,
        header=header,
        width=max([len(names), *widths]),
        least=max(len(names), usual),
    )


def _decimal_sign(text: Text, header_bytes: int, rows: Iterable[Row], separator: str) -> Decimal:
    """Report which sign most numbers of the sample have, or else the first one below it: others are no numbers then."""
    numbers = [cell for row in rows for cell in row.cells if is_number(cell, ".,")]
    points, commas = (sum(sign in number for number in numbers) for sign in ".,")
    first = None if points or commas or separator == "," else _SIGN.search(text.content, text.start + header_bytes)
    return "," if commas > points or (first and first[1] == b",") else "."


def without_cut_row(text: Text, separator: str) -> Text:
    """Leave out a last line without a line end, with a note, unless it ends as all lines above it do."""
    if not text.unterminated:
        return text
    tail = re.split(r"\r\n?|\n", text.content[-LONGEST_LINE:].decode(errors="ignore"))
    endings = [_ending(line, separator) for line in tail[1:] if line.strip()][-1 - _ALIKE :]
    if len(endings) > _ALIKE and endings[-1] is not None and len(set(endings)) == 1:
        return text
    end = max(text.content.rfind(sign) for sign in (b"\r", b"\n")) + 1
    note = "the last line has no line ending; it is omitted, since it may be truncated"
    return replace(text, content=text.content[:end], notes=(*text.notes, note))


def _ending(line: str, separator: str) -> tuple[int, int] | None:
    """Give the number of separators and of signs behind the decimal sign of the last number; none where it has none."""
    *before, last = line.rstrip(" ").split(None if separator == BLANKS else separator)
    _, sign, decimals = last.partition("." if "." in last else ",")
    return (len(before), len(decimals)) if sign or not last.strip() else None


def moment(text: str) -> str | None:
    """Find a date and time of day in ISO 8601, where the year comes first: else the order of the others is unknown."""
    found = _YEAR_FIRST.search(text)
    if found is None:
        return None
    year, month, day = map(int, re.split("[-./]", found["date"]))
    try:
        begun = datetime(year, month, day, int(found["hour"]))  # noqa: DTZ001
    except ValueError:
        return None
    return f"{begun:%Y-%m-%dT%H}:{found['rest']}"


def moment_by(text: str, others: Iterable[str]) -> tuple[str, str | None] | None:
    """Find a date and time of day whose year comes last: as it is written, and in ISO 8601.

    Which of day and month comes first is given by other dates of the same file; not in ISO 8601 where none shows.
    """
    found = _YEAR_LAST.search(text)
    if found is None:
        return None
    dates = [found, *(date for other in others for date in _YEAR_LAST.finditer(other))]
    day_first = any(int(date["first"]) > 12 for date in dates)
    month_first = any(int(date["second"]) > 12 for date in dates)
    return found[0], None if day_first == month_first else _iso(found, "first" if day_first else "second")


def start_from(written: str, others: Iterable[str]) -> tuple[dict[str, str], list[str]]:
    """Return the start of the test from a date whose year comes last, or a note if its day and month are ambiguous."""
    found, started = moment_by(written, others) or ("", None)
    if started:
        return {"started": started}, []
    ambiguous = f"the start time {found} is not taken from the header, since the order of day and month is ambiguous"
    return {}, [ambiguous] if found else []


def _iso(date: re.Match[str], day: str) -> str | None:
    month = "second" if day == "first" else "first"
    hour = int(date["hour"])
    if date["half"]:
        hour = hour % 12 + (12 if date["half"] in "Pp" else 0)
    fields = (int(date["year"]), int(date[month]), int(date[day]), hour, int(date["minute"]), int(date["seconds"] or 0))
    try:
        return datetime(*fields).isoformat()  # noqa: DTZ001
    except ValueError:
        return None


def read_below(text: Text, lines: list[str], at: int, separator: str, decimal: Decimal | None) -> ReadTable:
    """Read the table whose row of names is that of the lines; a last row that may have been cut is left out."""
    text = without_cut_row(text, separator)
    names = tuple(trimmed(cells_of(lines[at], separator)))
    return read_table(text, layout_below(text, lines, at + 1, names, separator, decimal))


class HeaderRowReader(ABC):
    """A reader of tables in which the row of names, wherever it is, shows what wrote them."""

    holds: Holds = "signals"
    separator: ClassVar[str]
    sought: ClassVar[str]
    """The row of names in words."""
    whose: ClassVar[str]
    """What writes such a row."""

    @abstractmethod
    def is_header(self, line: str, names: Set[str]) -> bool:
        """Return whether a line with these names, each as ``bare_key`` writes it, is the row of names."""

    @abstractmethod
    def understood(self, table: ReadTable, lines: list[str], at: int) -> ReadTable:
        """Return the table with what its columns mean, from the first lines, of which ``at`` is the row of names."""

    def prepared(self, text: Text) -> Text:
        """Return the text as it can be parsed."""
        return text

    def _header(self, lines: list[str]) -> int | None:
        named = (frozenset(map(bare_key, cells_of(line, self.separator))) for line in lines)
        return next((at for at, names in enumerate(named) if self.is_header(lines[at], names)), None)

    @judge_lines
    def match(self, lines: list[str]) -> Match:
        """Judge by the names of the columns."""
        found = self._header(lines)
        if found is None:
            return Match(0.0, f"no header row {self.sought}")
        return Match(0.95, f"line {found + 1} is the header row of {self.whose}")

    def read(self, source: SourceFile, hints: Hints) -> ReadTable:
        """Parse the file; ``ReaderError`` with file and line where it is broken."""
        text = self.prepared(decode(source, hints.encoding))
        lines = sample_lines(text)
        at = self._header(lines)
        if at is None:
            raise ReaderError(
                f"{source.name}: found no header row {self.sought}; expected the header row of {self.whose}; specify "
                "another reader in run.toml"
            )
        return self.understood(read_below(text, lines, at, self.separator, hints.decimal), lines, at)
