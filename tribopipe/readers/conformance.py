"""Conformance tests for readers, as one call in the tests of a reader's author.

    from tribopipe.readers.conformance import Example, check_reader

    def test_reader():
        check_reader(MyReader(), [Example("run.abc", CONTENT, rows=3, columns={"t": "s", "Ft": "N"})])

An example is a small file and what is in it. From it the kit makes the files a reader will meet one day: cut at any
byte, in another encoding, with other line ends, without its header, of another vendor, or of no format at all. A
reader may refuse any of them, and may read what is whole; it must never give another number, raise anything but
``ReaderError``, or take its time.
"""

import random
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from time import process_time
from typing import Any, get_args

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from tribopipe.base.errors import ReaderError, UnitError
from tribopipe.base.units import is_unit, to_si
from tribopipe.documents.contact_kinds import ASSUMED, kind_of
from tribopipe.documents.manifest import MANIFEST_SCHEMA, RunManifest
from tribopipe.documents.signals import SIGNALS, SignalName
from tribopipe.readers.reader import Axis, Hints, Holds, Match, ReadColumn, Reader, ReadTable
from tribopipe.results.run import SourceFile

SURE = 0.9
"""A reader is at least this sure of its own files."""
CLAIMED = 0.5
"""Least confidence with which a reader claims a file."""
LAST_RESORT = 0.75
"""A reader of last resort stays below this, so that those who know better come first."""
MATCH_SECONDS = 1.0
READ_SECONDS = 10.0
_LONG_LINE = 100_000_000
_CUTS = 500
_QUICK_LINE = 1_000_000
_QUICK_CUTS = 12
_NAME = re.compile(r"[a-z0-9]+(?:-[a-z0-9]+)*")
_ENCODINGS = ("utf-8", "utf-8-sig", "utf-16", "utf-16-be", "cp1252", "shift_jis")
_LINE_ENDS = {"LF": ["\n"], "CRLF": ["\r\n"], "CR": ["\r"], "mixed": ["\n", "\r\n", "\r"]}


class ConformanceError(AssertionError):
    """Violations of the rules by a reader, all in one message."""


@dataclass(frozen=True)
class Example:
    """A small file of a format, and what is in it."""

    name: str
    content: bytes = field(repr=False)
    rows: int
    columns: Mapping[str, str | None]
    """Unit of each column by its name, in the order of the file."""
    signals: Mapping[str, SignalName] = field(default_factory=dict)
    """Columns whose meaning the format itself states."""
    values: Mapping[str, Sequence[float]] = field(default_factory=dict)
    """All values of some columns, by column name."""
    facts: Mapping[str, str] = field(default_factory=dict)
    """Some of what the header states about the run."""
    encoding: str | None = "utf-8"
    """Encoding of a text file; None for a binary file."""
    permuted: bytes | None = field(default=None, repr=False)
    """The same file with its columns in another order, where the format allows for that."""

    @property
    def source(self) -> SourceFile:
        """The file as a reader gets it."""
        return SourceFile(self.name, self.content)


def check_reader(
    reader: Reader,
    examples: Sequence[Example],
    *,
    others: Iterable[Example] = (),
    generic: bool = False,
    quick: bool = False,
) -> None:
    """Try a reader on its own files, on what may become of them, and on the files of others.

    ``generic`` is for a reader of last resort, which may claim other files with a confidence below 0.75; ``quick``
    tries fewer cuts and a shorter endless line. Raises ``ConformanceError``.
    """
    inquiry = _Inquiry(reader, generic=generic, quick=quick)
    inquiry.require(bool(examples), "no examples given; expected at least one file of the format", "examples")
    if inquiry.is_reader():
        for example in examples:
            inquiry.own(example)
        inquiry.foreign(others)
    if inquiry.broken:
        listed = "\n".join(f"- {problem} ({_cases(cases)})" for problem, cases in inquiry.broken.items())
        raise ConformanceError(f"{getattr(reader, 'name', reader)}: {len(inquiry.broken)} rules broken:\n{listed}")


def _cases(cases: list[str]) -> str:
    return cases[0] + (f", and {len(cases) - 1} more" if len(cases) > 1 else "")


class _Inquiry:
    """One reader on trial, and all that it breaks."""

    def __init__(self, reader: object, *, generic: bool, quick: bool) -> None:
        self.reader: Any = reader
        self.generic = generic
        self.cuts = _QUICK_CUTS if quick else _CUTS
        self.long_line = _QUICK_LINE if quick else _LONG_LINE
        self.broken: dict[str, list[str]] = {}

    def report(self, problem: str, case: str) -> None:
        """Keep a problem and the case that shows it."""
        self.broken.setdefault(problem, []).append(case)

    def require(self, kept: bool, problem: str, case: str) -> None:
        """Report a problem unless the rule is kept."""
        if not kept:
            self.report(problem, case)

    def is_reader(self) -> bool:
        """Check the shape of the class."""
        if not isinstance(self.reader, Reader):
            self.report("found no reader; expected name, title, holds, match and read", "protocol")
            return False
        name, title = str(self.reader.name), str(self.reader.title)
        self.require(
            bool(_NAME.fullmatch(name)),
            f"name {name!r} contains characters other than a-z, 0-9 and single hyphens",
            "name",
        )
        one_line = title.strip() == title != "" and "\n" not in title
        self.require(one_line, f"title {title!r} is not one line", "title")
        self.require(self.reader.holds in get_args(Holds), f"holds {self.reader.holds!r} is unknown", "holds")
        return True

    # --- a reader at work ---

    def match(self, source: SourceFile, case: str) -> float:
        """Ask how sure the reader is; it must answer, in time."""
        started = process_time()
        try:
            match = self.reader.match(source)
        except Exception as error:  # noqa: BLE001 - this is what is being looked for
            self.report(f"match raised {type(error).__name__}", case)
            return 0.0
        self.require(process_time() - started < MATCH_SECONDS, f"match took more than {MATCH_SECONDS:g} s", case)
        if not isinstance(match, Match) or not 0 <= match.confidence <= 1:
            self.report("match gave no Match with a confidence from 0 to 1", case)
            return 0.0
        self.require(bool(match.why.strip()) and "\n" not in match.why, "match gave no reason in one line", case)
        return match.confidence

    def read(self, source: SourceFile, case: str, hints: Hints | None = None) -> ReadTable | None:
        """Have a file read; it must be refused in one sentence or give a table, in time."""
        started = process_time()
        try:
            table: Any = self.reader.read(source, hints or Hints())
        except ReaderError as error:
            said = str(error)
            self.require(said.startswith(source.name) and "\n" not in said, "an error does not name the file", case)
            return None
        except Exception as error:  # noqa: BLE001 - this is what is being looked for
            self.report(f"read raised {type(error).__name__} instead of ReaderError", case)
            return None
        self.require(process_time() - started < READ_SECONDS, f"read took more than {READ_SECONDS:g} s", case)
        return table if self.is_table(table, case) else None

    def is_table(self, table: Any, case: str) -> bool:
        """Check that a table is one, whatever it holds."""
        if not isinstance(table, ReadTable) or not table.columns:
            self.report("read gave no ReadTable with columns", case)
            return False
        names = [column.name for column in table.columns]
        self.require(all(name and name == name.strip() for name in names), "a column's name is empty or padded", case)
        self.require(len(set(names)) == len(names), "two columns have the same name", case)
        self.require(len({len(column.values) for column in table.columns}) == 1, "columns differ in length", case)
        for column in table.columns:
            for problem in _column_problems(column):
                self.report(f"column {column.name!r}: {problem}", case)
        for problem in _fact_problems(table.facts):
            self.report(problem, case)
        texts = [table.header, *table.notes]
        self.require(all(isinstance(text, str) for text in texts), "header and notes are not strings", case)
        return True

    # --- files of the format ---

    def own(self, example: Example) -> None:
        """Try a file of the format, and what may become of it."""
        for name in (example.name, "run", "run.csv"):
            confidence = self.match(SourceFile(name, example.content), f"{example.name} as {name!r}")
            low = SURE if not self.generic else CLAIMED
            self.require(confidence >= low, f"confidence below {low:g} in a file of the format", f"as {name!r}")
        whole = self.read(example.source, example.name)
        if whole is None:
            self.report("a file of the format is rejected", example.name)
            return
        self.content(example, whole)
        again = self.read(example.source, example.name)
        self.require(again is not None and _same(whole, again), "reading twice gives different results", example.name)
        self.cut(example, whole)
        self.disguised(example, whole)
        self.permuted(example, whole)

    def content(self, example: Example, whole: ReadTable) -> None:
        """Compare a table with what is in the file."""
        case = example.name
        units = {column.name: column.unit for column in whole.columns}
        self.require(list(units) == list(example.columns), f"columns are {list(units)}", case)
        wrong = {name: unit for name, unit in units.items() if example.columns.get(name, unit) != unit}
        self.require(not wrong, f"units are {wrong}", case)
        rows = len(whole.columns[0].values)
        self.require(rows == example.rows, f"{rows} rows instead of {example.rows}", case)
        columns = {column.name: column for column in whole.columns}
        for name, signal in example.signals.items():
            self.require(name in columns and columns[name].signal == signal, f"{name!r} is not the {signal}", case)
        for name, values in example.values.items():
            kept = name in columns and _equal(columns[name].values, np.asarray(values, dtype=np.float64))
            self.require(kept, f"the numbers of {name!r} differ from those in the file", case)
        for key, fact in example.facts.items():
            self.require(whole.facts.get(key) == fact, f"the fact {key} is {whole.facts.get(key)!r}", case)
        is_profile = any(column.axis == "z" for column in whole.columns)
        self.require(
            is_profile == (self.reader.holds == "profile"),
            "a profile has no axis z, or a file of signals has one",
            case,
        )
        self.require(_verbatim(whole.header, example), "the header is not a verbatim part of the file", case)

    def cut(self, example: Example, whole: ReadTable) -> None:
        """Cut the file: what is read must be the beginning of the whole; a last row that differs must be noted."""
        for size in _sizes(len(example.content), self.cuts):
            case = f"{example.name} cut after {size} bytes"
            self.match(SourceFile(example.name, example.content[:size]), case)
            table = self.read(SourceFile(example.name, example.content[:size]), case)
            if table is not None:
                noted = not set(table.notes) <= set(whole.notes)
                begins = _begins(table, whole) or (noted and _begins(table, whole, but=1))
                self.require(begins, "a truncated file gives numbers that differ from those of the complete file", case)

    def disguised(self, example: Example, whole: ReadTable) -> None:
        """Write a text differently: it must be refused, or give the same numbers; missing ones must be noted."""
        for how, content, hints in _disguises(example, whole):
            case = f"{example.name} {how}"
            self.match(SourceFile(example.name, content), case)
            table = self.read(SourceFile(example.name, content), case, hints)
            if table is not None:
                noted = not set(table.notes) <= set(whole.notes)
                kept = _subset(table, whole, missing=noted)
                self.require(kept, "a file written differently gives different numbers", case)

    def permuted(self, example: Example, whole: ReadTable) -> None:
        """Change the order of columns: everything must go with its column."""
        if example.permuted is None:
            return
        case = f"{example.name} permuted"
        table = self.read(SourceFile(example.name, example.permuted), case)
        if table is None:
            self.report("a file with permuted columns is rejected", case)
            return
        kept = {column.name: column for column in table.columns}
        same = set(kept) == {column.name for column in whole.columns} and all(
            _same_column(kept[column.name], column) for column in whole.columns
        )
        self.require(same, "permuted columns change numbers, units or meanings", case)

    # --- files of others ---

    def foreign(self, others: Iterable[Example]) -> None:
        """Try files of other formats, and of none."""
        for other in others:
            confidence = self.match(other.source, other.name)
            most = LAST_RESORT if self.generic else CLAIMED
            self.require(
                confidence < most, f"confidence of {most:g} or more in a file of a different format", other.name
            )
            self.read(other.source, other.name)
        for case, content in _hostile(self.long_line):
            confidence = self.match(SourceFile("hostile", content), case)
            self.require(confidence < CLAIMED, "confidence of 0.5 or more in a file of no known format", case)
            table = self.read(SourceFile("hostile", content), case)
            self.require(table is None, "a file of no known format is read", case)


def _column_problems(column: ReadColumn) -> Iterator[str]:
    values = column.values
    is_text = values.dtype.kind == "O"
    if not is_text and values.dtype != np.float64:
        yield f"values are {values.dtype}, neither float64 nor strings"
    if is_text and not all(isinstance(value, str) for value in values):
        yield "values are objects other than strings"
    if is_text != (column.first_bad is not None):
        yield "first_bad does not indicate whether the values contain a string"
    if column.unit is not None and not is_unit(column.unit):
        yield f"unit {column.unit!r} is unknown"
    if column.axis not in (None, *get_args(Axis)):
        yield f"axis {column.axis!r} is unknown"
    if column.signal is not None:
        yield from _signal_problems(column)


def _signal_problems(column: ReadColumn) -> Iterator[str]:
    if column.signal not in SIGNALS:
        yield f"signal {column.signal!r} is unknown"
    elif column.unit is not None and is_unit(column.unit):
        try:
            to_si(np.zeros(1), column.unit, SIGNALS[column.signal].kind)
        except UnitError:
            yield f"unit {column.unit!r} is not a unit of {column.signal}"


def _fact_problems(facts: Mapping[str, Any]) -> Iterator[str]:
    """Ask the schema of run.toml what it thinks of the facts; what they leave out may be missing."""
    document: dict[str, Any] = {"schema": MANIFEST_SCHEMA, "id": "run", "signals": [{"file": "run"}], "conditions": {}}
    for key, fact in facts.items():
        if not isinstance(fact, str):
            yield f"fact {key} is not a string"
            return
        place = document
        *path, last = key.split(".")
        for step in path:
            place = place.setdefault(step, {})
        place[last] = fact
    if "contact" in document:
        document["contact"].setdefault("kind", kind_of(ASSUMED))
    try:
        RunManifest.model_validate(document)
    except ValidationError as error:
        for problem in error.errors(include_url=False):
            if problem["type"] != "missing":
                yield f"facts: {'.'.join(map(str, problem['loc']))}: {problem['msg']}"


def _verbatim(header: str, example: Example) -> bool:
    if example.encoding is None:
        return True
    text = example.content.decode(example.encoding).removeprefix("\ufeff")
    return all(line in text for line in header.splitlines(keepends=True))


def _sizes(length: int, most: int) -> list[int]:
    """Choose where to cut: everywhere, or at places drawn with a fixed seed."""
    return list(range(length)) if length <= most else sorted(random.Random(length).sample(range(length), most))  # noqa: S311 - no secret


def _disguises(example: Example, whole: ReadTable) -> Iterator[tuple[str, bytes, Hints]]:
    """Write a text in other encodings, under wrong names of encodings, with other line ends, without its header."""
    if example.encoding is None:
        return
    text = example.content.decode(example.encoding).removeprefix("\ufeff")
    for encoding in _ENCODINGS:
        yield f"in {encoding}", text.encode(encoding, errors="replace"), Hints()
        yield f"read as {encoding}", example.content, Hints(encoding=encoding)
    middle = len(example.content) // 2
    yield "with a foreign byte", example.content[:middle] + b"\x81" + example.content[middle:], Hints()
    yield "read as nonsense", example.content, Hints(encoding="no-such-encoding")
    for name, ends in _LINE_ENDS.items():
        lines = re.split(r"\r\n|\r|\n", text)
        ended = "".join(line + ends[number % len(ends)] for number, line in enumerate(lines[:-1])) + lines[-1]
        yield f"with {name} line ends", ended.encode(example.encoding), Hints()
    body = text.removeprefix(whole.header)
    if body != text:
        yield "without its header", body.encode(example.encoding), Hints()


def _hostile(long_line: int) -> Iterator[tuple[str, bytes]]:
    draw = random.Random(5)  # noqa: S311 - no secret
    yield "an empty file", b""
    yield "blank lines", b"\n" * 1000
    yield "zeros", bytes(4096)
    yield "random bytes", draw.randbytes(4096)
    yield "random letters", bytes(draw.choices(b"abcdefgh \n", k=4096))
    yield "prose", b"Dear colleague,\n\nplease find enclosed the results of last week.\n\nYours\n" * 20
    yield "one endless line", b"1234;" * (long_line // 5)
    yield "a number that never ends", b"9" * min(long_line // 1000, 20_000) + b"x\n"


def _equal(one: NDArray[Any], other: NDArray[Any]) -> bool:
    if one.dtype.kind != other.dtype.kind:
        return False
    return bool(np.array_equal(one, other, equal_nan=one.dtype.kind == "f"))


def _same_column(one: ReadColumn, other: ReadColumn) -> bool:
    same = (one.unit, one.signal, one.axis) == (other.unit, other.signal, other.axis)
    return same and _equal(one.values, other.values)


def _same(one: ReadTable, other: ReadTable) -> bool:
    said = [
        (table.header, table.notes, dict(table.facts), [column.name for column in table.columns])
        for table in (one, other)
    ]
    return said[0] == said[1] and all(map(_same_column, one.columns, other.columns))


def _agree(part: ReadTable, whole: ReadTable, fits: Callable[[NDArray[Any], NDArray[Any]], bool]) -> bool:
    """Compare columns of numbers with those of the same name, or in the same place where names are lost."""
    named = {column.name: column for column in whole.columns}
    if len(part.columns) > len(whole.columns):
        return False
    for number, column in enumerate(part.columns):
        full = named.get(column.name, whole.columns[number]).values
        if column.values.dtype.kind == full.dtype.kind == "f" and not fits(column.values, full):
            return False
    return True


def _begins(part: ReadTable, whole: ReadTable, *, but: int = 0) -> bool:
    """Return whether a table is the beginning of another one, except for some rows at its end."""

    def fits(values: NDArray[Any], full: NDArray[Any]) -> bool:
        count = max(0, len(values) - but)
        return len(values) <= len(full) and _equal(values[:count], full[:count])

    return _agree(part, whole, fits)


def _subset(part: ReadTable, whole: ReadTable, *, missing: bool) -> bool:
    """Return whether a table is the beginning or the end of another one, perhaps with numbers missing."""

    def within(values: NDArray[Any], full: NDArray[Any]) -> bool:
        return _equal(np.where(np.isnan(values), full, values) if missing else values, full)

    def begins(values: NDArray[Any], full: NDArray[Any]) -> bool:
        return len(values) <= len(full) and within(values, full[: len(values)])

    def ends(values: NDArray[Any], full: NDArray[Any]) -> bool:
        return len(values) <= len(full) and within(values, full[len(full) - len(values) :])

    return _agree(part, whole, begins) or _agree(part, whole, ends)
