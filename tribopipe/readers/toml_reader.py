"""Readers that a lab describes in TOML (``tribopipe.documents.reader_profile``) for its own export.

The regular expressions of such a description are searched for in bounded time: some take a time that grows with two to
the length of the text. One with at most a single sign of repetition or choice cannot, where texts are short; any other
is searched for by a process of its own, which costs 30 ms.
"""

import json
import re
from collections.abc import Sequence
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from typing import NamedTuple

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.base.errors import ReaderError
from tribopipe.documents.reader_profile import Calibration, DescribedColumn, Fact, ReaderProfile
from tribopipe.documents.record import load_toml
from tribopipe.readers.column_mapping import contradiction, find_column, read_source
from tribopipe.readers.delimited import read_table
from tribopipe.readers.headed_tables import cells_of, head_lines, layout_below, without_cut_row
from tribopipe.readers.layout import Decimal, Layout, find_layout
from tribopipe.readers.reader import Hints, Match, ReadColumn, ReadTable, refused
from tribopipe.readers.subprocess_readers import answer_of
from tribopipe.readers.subprocess_readers.regex_search import first_hit
from tribopipe.readers.tables import is_number
from tribopipe.readers.text import Text, decode, sample_lines, trimmed
from tribopipe.results.run import SourceFile

_CHOICES = re.compile(r"[*+?{|]")
_MUCH = 2e7
"""Square of the length of a text, in all: one repetition may begin at each sign, and go on to the end."""


def search(pattern: str, texts: Sequence[str], file: str) -> tuple[int, str] | None:
    """Return the index of the first text in which a pattern is found, and what its first group, or it, matched.

    ^ and $ stand for the ends of lines. Raises ``ReaderError`` where the search takes too long.
    """
    if len(_CHOICES.findall(pattern)) < 2 and sum(len(text) ** 2 for text in texts) < _MUCH:
        return first_hit(pattern, texts)
    asked = SourceFile(file, json.dumps([pattern, texts]).encode("ascii"))
    try:
        found = json.loads(answer_of("regex_search.py", asked, remedy=""))
    except ReaderError:
        raise ReaderError(
            f"{file}: found the pattern {pattern!r}, which takes too long to match; expected a pattern that matches "
            "or fails "
            "immediately; simplify the pattern and avoid nested repetition"
        ) from None
    return None if found is None else (found[0], found[1])


def described_reader(path: Path) -> "DescribedReader":
    """Make the reader that a file describes. Raises ``ManifestError`` with file and key if it is invalid."""
    return DescribedReader(load_toml(path, ReaderProfile))


def reader_in(folder: Path, named: str, sources: list[SourceFile], key: str) -> "DescribedReader":
    """Make the reader that a file of a run folder describes, and make that file a source of the run, once.

    Raises ``ReaderError`` or ``ManifestError`` where there is no such file, or it describes none.
    """
    if all(source.name != named for source in sources):
        sources.append(read_source(folder, named, key, "description of a reader"))
    return described_reader(folder / named)


class DescribedReader:
    """A format as a lab describes it."""

    def __init__(self, profile: ReaderProfile) -> None:
        self.profile = profile
        self.name = profile.name
        self.title = profile.title
        self.holds = profile.holds

    def match(self, source: SourceFile) -> Match:
        """Judge by the profile's pattern."""
        wanted = self.profile.detect
        if wanted is None:
            return Match(0.0, "the profile has no pattern 'detect' to recognize its files")
        try:
            lines = head_lines(source, self.profile.encoding)
            found = search(wanted, list(map(_bare_line, lines)), source.name)
        except ReaderError as error:
            return refused(source, error)
        if found is None:
            return Match(0.0, f"no line among the first {len(lines)} matches {wanted!r}")
        return Match(0.95, f"line {found[0] + 1} matches {wanted!r}")

    def read(self, source: SourceFile, hints: Hints) -> ReadTable:
        """Parse the file; ``ReaderError`` with file and line where it is not as described."""
        text = decode(source, self.profile.encoding or hints.encoding)
        decimal = self.profile.decimal or hints.decimal
        if self.profile.tells_place:
            layout = _told_layout(self.profile, text, decimal)
            text = without_cut_row(text, layout.separator)
        else:
            separator = self.profile.separator or hints.separator
            layout = find_layout(text, Hints(separator=separator, decimal=decimal))
        table = _with_meanings(self.profile, read_table(text, layout), source.name)
        return replace(table, facts=_facts(self.profile, layout, source.name))


def _bare_line(line: str) -> str:
    return line.rstrip("\r\n")


def _told_layout(profile: ReaderProfile, text: Text, decimal: Decimal | None) -> Layout:
    """Lay out the table whose place the profile gives."""
    lines, separator = sample_lines(text), profile.separator or ""
    top = _first_line(profile, text, lines)
    if profile.names:
        return layout_below(text, lines, top, profile.names, separator, decimal)
    names = tuple(trimmed(cells_of(lines[top], separator)))
    body = top + (2 if profile.units_row == "below" else 1)
    layout = layout_below(text, lines, body, names, separator, decimal)
    return replace(layout, units=_units(profile, text, lines, top))


def _units(profile: ReaderProfile, text: Text, lines: list[str], top: int) -> tuple[str, ...]:
    """Give the row of units with the row of names. Raises ``ReaderError`` where numbers stand there."""
    at = top + {"above": -1, "below": 1}.get(profile.units_row or "", 0)
    if at == top or not 0 <= at < len(lines):
        return ()
    units = cells_of(lines[at], profile.separator or "")
    number = next((cell for cell in units if is_number(cell, ".,") and cell != "1"), None)
    if number is not None:
        raise ReaderError(
            f"{text.name}, line {at + 1}: found the number {number!r}; expected the row of units, as specified in the "
            f"profile {profile.name!r}; correct units_row, or the position of the table"
        )
    return units


def _first_line(profile: ReaderProfile, text: Text, lines: list[str]) -> int:
    """Find the index of the table's first line. Raises ``ReaderError`` where the file has none there."""
    if profile.starts_at is None:
        top = profile.header_lines or 0
        if top < len(lines):
            return top
        raise ReaderError(
            f"{text.name}: found {len(lines)} lines; expected a table below the first {top}, as specified in the "
            f"profile {profile.name!r}; correct header_lines, or export the file again with its data"
        )
    found = search(profile.starts_at, list(map(_bare_line, lines)), text.name)
    if found is not None:
        return found[0]
    raise ReaderError(
        f"{text.name}: found no line that matches {profile.starts_at!r} among the first {len(lines)}; expected the "
        f"table to begin there, as specified in the profile {profile.name!r}; correct starts_at, or specify another "
        "reader"
    )


def _with_meanings(profile: ReaderProfile, table: ReadTable, file: str) -> ReadTable:
    told = _told_columns(profile, table, file)
    columns: list[ReadColumn] = []
    notes = list(table.notes)
    for column in table.columns:
        made = _made_of(profile, column, told.get(column.name), file)
        columns += made.columns
        notes += made.notes
    names = [column.name for column in columns]
    if len(set(names)) < len(names):
        raise ReaderError(
            f"{file}: found the column {max(names, key=names.count)!r} in the file, although the profile "
            f"{profile.name!r} derives a column of this name; expected different names; rename the derived column"
        )
    return replace(table, columns=tuple(columns), notes=tuple(notes))


def _told_columns(profile: ReaderProfile, table: ReadTable, file: str) -> dict[str, DescribedColumn]:
    """Find the columns that the profile describes. Raises ``ReaderError`` where one is missing, or described twice."""
    told: dict[str, DescribedColumn] = {}
    for name, column in profile.columns.items():
        found = find_column(table, name, column.signal or f"the profile {profile.name!r}", file).name
        if told.setdefault(found, column) is not column:
            raise ReaderError(
                f"{file}: found {found!r} twice in the profile {profile.name!r}, with and without its unit; expected "
                "each column once; remove one"
            )
    return told


class _Made(NamedTuple):
    """Transformation of one column of the file."""

    columns: tuple[ReadColumn, ...]
    notes: tuple[str, ...] = ()


def _made_of(profile: ReaderProfile, column: ReadColumn, told: DescribedColumn | None, file: str) -> _Made:
    """Give a column its meaning; one that is scaled or calibrated is kept as it was next to it."""
    if told is None:
        return _Made((column,))
    scaled = (told.scale, told.offset) != (1.0, 0.0)
    # Another scale may be the conversion from the file's unit; between units of two kinds, a stated 1 may be one, too.
    unit, is_scaled = told.unit if abs(told.scale) == 1 else None, "scale" in told.model_fields_set
    dissent = contradiction(column, unit, f"the profile {profile.name!r}", scaled=is_scaled)
    notes = [dissent] if dissent else []
    if told.calibration is None and not scaled:
        made = replace(column, unit=told.unit or column.unit, signal=told.signal, axis=told.axis)
        return _Made((made,), tuple(notes))
    derived = _scaled(column, told, file)
    notes += [f"{derived.name!r} is {column.name!r}{_formula(told)}"] if scaled else []
    if told.calibration is not None:
        calibration = profile.calibrations[told.calibration]
        derived, note = _calibrated(derived, told.calibration, calibration, file)
        notes.append(note)
        column = column if scaled else replace(column, unit=calibration.reading)
    return _Made((column, derived), tuple(notes))


def _formula(told: DescribedColumn) -> str:
    """Write what is done to a column: " × -1 + 3"."""
    factor = "" if told.scale == 1.0 else f" × {told.scale:g}"
    return factor + ("" if told.offset == 0.0 else f" {'+-'[told.offset < 0]} {abs(told.offset):g}")


def _scaled(column: ReadColumn, told: DescribedColumn, file: str) -> ReadColumn:
    """Apply scale and offset. Raises ``ReaderError`` where not all of a column are numbers."""
    if column.first_bad is not None:
        line, found = column.first_bad
        raise ReaderError(
            f"{file}, line {line}, column {column.name!r}: found {found!r}; expected a number; correct that line"
        )
    with np.errstate(over="ignore"):
        values = column.values * told.scale + told.offset
    return ReadColumn(f"{column.name}, calibrated", values, told.unit or column.unit, told.signal, told.axis)


def _calibrated(column: ReadColumn, name: str, calibration: Calibration, file: str) -> tuple[ReadColumn, str]:
    """Turn readings into what they stand for, and report it."""
    if column.unit not in (None, calibration.reading):
        raise ReaderError(
            f"{file}: found readings of {column.name!r} in {column.unit}; expected {calibration.reading}, the unit "
            f"of calibration {name!r}; scale the column, or specify its unit in the profile"
        )
    values = np.asarray(column.values, dtype=np.float64)
    lowest, highest = _range(calibration)
    outside = (values < lowest) | (values > highest)
    count = int(np.count_nonzero(outside))
    where = f"outside the range of the calibration {name!r}, {lowest:g} to {highest:g} {calibration.reading}"
    if count and calibration.outside == "error":
        row = int(np.flatnonzero(outside)[0])
        raise ReaderError(
            f"{file}: found {values[row]:g} {calibration.reading} in row {row + 1} of the table, {where} ({count} "
            "such readings in total); expected only readings within the calibrated range; extend the calibration, "
            'or set outside = "missing" in the profile'
        )
    note = f"{column.name!r} is in {calibration.unit} with the calibration {name!r}"
    note += f"; {count} readings {where} are missing" if count else ""
    found = np.where(outside, np.nan, _value(calibration, np.clip(values, lowest, highest)))
    return replace(column, values=found, unit=calibration.unit), note


def _range(calibration: Calibration) -> tuple[float, float]:
    readings = calibration.range or [reading for reading, _ in calibration.points]
    return min(readings), max(readings)


def _value(calibration: Calibration, readings: Column) -> Column:
    if calibration.polynomial:
        with np.errstate(over="ignore", invalid="ignore"):
            return np.asarray(np.polynomial.polynomial.polyval(readings, calibration.polynomial), dtype=np.float64)
    known, values = np.array(sorted(calibration.points)).T
    return np.asarray(np.interp(readings, known, values), dtype=np.float64)


def _facts(profile: ReaderProfile, layout: Layout, file: str) -> dict[str, str]:
    """Give what the lines above the table state about the run; what they do not state is left out."""
    found = {key: _fact(fact, layout, f"{file}: {key}") for key, fact in profile.facts.items()}
    return {key: value for key, value in found.items() if value is not None}


def _fact(fact: Fact, layout: Layout, where: str) -> str | None:
    header = layout.header.replace("\r\n", "\n").replace("\r", "\n")
    found = search(fact.pattern, [header], where)
    value = found[1].strip() if found else ""
    if not value:
        return None
    if fact.date is not None:
        return _date(value, fact.date, where)
    if fact.unit is None:
        return value
    return f"{value.replace(',', '.') if layout.decimal == ',' else value} {fact.unit}"


def _date(value: str, written: str, where: str) -> str:
    try:
        return datetime.strptime(value, written).isoformat()  # noqa: DTZ007 - a rig's clock knows no time zone
    except (ValueError, re.error):
        raise ReaderError(
            f"{where}: found {value!r}; expected a date in the form {written!r}; correct date or pattern"
        ) from None
