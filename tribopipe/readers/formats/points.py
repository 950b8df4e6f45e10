r"""Profiles and maps as bare columns of numbers, without names: what nearly every profilometer can export.

    0⟨TAB⟩-13.726517            µm µm                              0.0000,0.0000,478.6135
    0.001166⟨TAB⟩-13.879324     23                                 0.0050,0.0000,478.3340
    0.002331⟨TAB⟩-13.726956        1.3381669e+01,   1.7854970e+01  0.0100,0.0000,478.5390

* Two columns: position and height, here called x and z. Three: a map as a list of points x, y, z, one scan line after
  the other; one of x and y stays the same along a line.
* Columns are separated by tabs, semicolons, commas or runs of blanks; numbers have a decimal point, or a comma where
  no comma separates. Lines may end in CR alone.
* Above the numbers may stand a line of units of length, and a line with the number of points.
* Without a line of units the file does not state in what its numbers are: run.toml has to, for each axis by itself,
since
  positions in mm with heights in µm are common: position = { column = "x", unit = "mm" }.

Any two bare columns look like a profile, so that detection is never surer than 0.6 without a line of units.
"""

import re
from dataclasses import dataclass, replace

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.base.errors import ReaderError, UnitError
from tribopipe.base.units import to_si
from tribopipe.readers.delimited import read_table
from tribopipe.readers.layout import Decimal, Layout, find_doubt
from tribopipe.readers.reader import Axis, Hints, Holds, Match, ReadColumn, ReadTable, refused
from tribopipe.readers.tables import (
    INTEGER,
    Table,
    count_in,
    count_numbers,
    decimal_signs,
    has_quoted_commas,
    is_gap,
    is_number,
    without_brackets,
)
from tribopipe.readers.text import BLANKS, SAMPLE_BYTES, Row, Text, decode, sample_lines, sampled_rows, trimmed
from tribopipe.results.run import SourceFile

_SEPARATORS = ("\t", ";", ",", BLANKS)
_AXES: dict[int, tuple[Axis, ...]] = {2: ("x", "z"), 3: ("x", "y", "z")}
_FEWEST_ROWS = 3


class PointsReader:
    """Bare columns of positions and heights."""

    name = "points"
    title = "Profile or map as unnamed columns: x z, or x y z"
    holds: Holds = "profile"

    def match(self, source: SourceFile) -> Match:
        """Judge by the number of columns, the order of the positions, and a line of units where there is one."""
        head = SourceFile(source.name, source.content[:SAMPLE_BYTES])
        try:
            text = decode(head, partial=len(source.content) > SAMPLE_BYTES)
            found = _find_points(text, Hints())
        except ReaderError as error:
            return refused(source, error)
        if len(found.table.rows) - found.table.body < _FEWEST_ROWS:
            return Match(0.2, f"fewer than {_FEWEST_ROWS} data rows")
        if found.units:
            return Match(0.9, f"{found.width} numeric columns below the units {' '.join(found.units)}")
        return _by_positions(found, text)

    def read(self, source: SourceFile, hints: Hints) -> ReadTable:
        """Parse the file; ``ReaderError`` with file and line where it holds anything but two or three columns."""
        text = decode(source, hints.encoding)
        found = _find_points(text, hints)
        table = read_table(text, found.layout(text, hints))
        axes = _AXES[found.width]
        units: list[str | None] = [*found.units] or [None] * found.width
        columns = tuple(
            replace(column, unit=unit, axis=axis) for column, unit, axis in zip(table.columns, units, axes, strict=True)
        )
        return replace(table, columns=columns, notes=(*table.notes, *_count_note(found, columns)))


@dataclass(frozen=True)
class _Points:
    """Position of the data in the sample, and the lines above them."""

    table: Table
    lines: list[str]
    units: list[str]
    count: int | None
    """Number of points by the file's own word."""

    @property
    def width(self) -> int:
        return self.table.width

    def layout(self, text: Text, hints: Hints) -> Layout:
        """Report how to read the numbers, and what may be read in two ways."""
        first = self.table.rows[self.table.body].line
        return Layout(
            self.table.separator,
            hints.decimal or self.decimal,
            self.table.names,
            line=first,
            header="".join(self.lines[: first - 1]),
            width=max(len(row.cells) for row in self.table.rows[self.table.body :]),
            least=self.width,
            doubt=_integers_between_commas(text, self.table, hints) or find_doubt(text, hints, self.table),
        )

    @property
    def decimal(self) -> Decimal:
        """The decimal separator."""
        return "," if any("," in number for _, _, number in self.table.numbers) else "."


def _find_points(text: Text, hints: Hints) -> _Points:
    """Find two or three bare columns. Raises ``ReaderError`` where there is something else."""
    lines = sample_lines(text)
    quoted = has_quoted_commas(lines)
    for separator in [hints.separator] if hints.separator else _SEPARATORS:
        signs = decimal_signs(separator, hints, quoted=quoted)
        rows = sampled_rows(lines, separator)
        body = next((at for at, row in enumerate(rows) if _is_point(row, signs)), len(rows))
        if body < len(rows) and _are_points(rows[body:], len(trimmed(rows[body].cells)), signs, text):
            return _with_header(text, lines, rows, body, separator, signs)
    number, line = next(((n, line.strip()) for n, line in enumerate(lines, 1) if not line.isspace()), (1, ""))
    raise ReaderError(
        f"{text.name}, line {number}: found {line[:40]!r}; expected two or three numeric columns, x z or x y z; "
        "export the profile as a list of points, or specify the columns in run.toml"
    )


def _is_point(row: Row, signs: str) -> bool:
    cells = trimmed(row.cells)
    return len(cells) in _AXES and count_numbers(row, signs) == len(cells)


def _are_points(rows: list[Row], width: int, signs: str, text: Text) -> bool:
    """Return whether all rows are of numbers, as many in each; the last one may be cut."""
    whole = rows[:-1] if text.unterminated and len(rows) > 1 else rows
    return all(
        len(trimmed(row.cells)) <= width <= len(row.cells)
        and bool(row.cells[0])
        and all(is_gap(cell) or is_number(cell, signs) for cell in row.cells)
        for row in whole
    )


def _with_header(text: Text, lines: list[str], rows: list[Row], body: int, separator: str, signs: str) -> _Points:
    """Read the lines above the numbers. Raises ``ReaderError`` where they are neither units nor a number of points."""
    width = len(trimmed(rows[body].cells))
    units: list[str] = []
    count: int | None = None
    for row in rows[:body]:
        cells = [without_brackets(cell) for cell in " ".join(trimmed(row.cells)).split()]
        if not units and len(cells) == width and all(map(_is_length, cells)):
            units = cells
        elif count is None and len(cells) == 1 and (claimed := count_in(cells[0])) is not None:
            count = claimed
        else:
            raise ReaderError(
                f"{text.name}, line {row.line}: found {' '.join(cells)[:40]!r} above columns without names; expected "
                f"no line above them except one with length units or the number of points; specify the columns in "
                "run.toml"
            )
    table = Table(
        separator,
        signs,
        rows,
        body,
        width,
        numeric=frozenset(range(width)),
        textual=frozenset(),
        top=body,
        names=_AXES[width],
    )
    return _Points(table, lines, units, count)


def _is_length(unit: str) -> bool:
    try:
        to_si(1.0, unit, "length")
    except UnitError:
        return False
    return True


def _integers_between_commas(text: Text, table: Table, hints: Hints) -> str | None:
    """Doubt commas where every number is an integer: they may be decimal separators as well."""
    if hints.separator or table.separator != "," or any(not INTEGER.fullmatch(cell) for _, _, cell in table.numbers):
        return None
    row = table.rows[table.body]
    return (
        f"{text.name}, line {row.line}: found {','.join(row.cells)!r}, where the comma may be a column separator or "
        "a decimal comma; expected an unambiguous separator; export the profile with a different one"
    )


def _by_positions(found: _Points, text: Text) -> Match:
    """Judge bare columns by whether their positions go along one line, or along one scan line after the other."""
    if _integers_between_commas(text, found.table, Hints()):
        return Match(0.2, "integers between commas, which may be decimal separators")
    positions = _positions(found.table, text)
    if found.width == 2:
        if _goes_one_way(positions[0]):
            return Match(0.6, "two unnamed columns, apparently positions and heights")
        return Match(0.2, "two unnamed columns, the first of which is not monotonic and so not a position")
    for along, across in (positions, positions[::-1]):
        lines = np.split(along, np.flatnonzero(np.diff(across) != 0) + 1)
        if 1 < len(lines) <= len(along) // 2 and all(map(_goes_one_way, lines[:-1])):
            return Match(
                0.6, f"three unnamed columns, apparently a map with {len(lines[0])} points in the first scan line"
            )
    return Match(0.2, "three unnamed columns and no scan-line break in the first rows")


def _positions(table: Table, text: Text) -> list[Column]:
    """Return the columns of positions in the whole head of a file: a scan line may be longer than a sample."""
    first = table.rows[table.body].line - 1
    lines = re.split(r"(?<=\n)|(?<=\r)(?!\n)", text.content[text.start :].decode(errors="ignore"))[first:-1]
    rows = [row.cells for row in sampled_rows(lines, table.separator) if len(row.cells) >= table.width]
    return [np.array([_value(cells[axis]) for cells in rows]) for axis in range(table.width - 1)]


def _value(cell: str) -> float:
    return float(cell.replace(",", ".")) if is_number(cell, ".,") else np.nan


def _goes_one_way(positions: Column) -> bool:
    steps = np.diff(positions[np.isfinite(positions)])
    return bool(len(steps) and (np.all(steps >= 0) or np.all(steps <= 0)) and np.any(steps))


def _count_note(found: _Points, columns: tuple[ReadColumn, ...]) -> list[str]:
    rows = len(columns[0].values)
    if found.count is None or found.count == rows:
        return []
    return [f"the header states {found.count} points; the file contains {rows}"]
