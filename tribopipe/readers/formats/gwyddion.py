r"""Gwyddion's text export of a map (.txt): a matrix of heights below a header of comments.

    # Channel: Topography
    # Width: 12.34 µm
    # Height: 5678.9 nm
    # Value units: m
    1.00e-09  1.50e-09  3.00e-09
    -2.0e-09  -3.0e-09  -6.0e-09

* The words of the header are those of the user's language ("# Kanal:", "# Breite:", "# Höhe:"), its order is not: a
  title, the extent along the rows, the extent across them, the unit of the values.
* One line of the matrix is one scan line; values are separated by tabs or blanks, with a decimal point or comma.
* Values are those of pixels, whose middles lie half a pixel inside the extents. The first row is y = 0 here.
* Without its header a matrix does not give its size, and is not read. The header does not state how many rows
there
  are: where pixels are not square, a note states that some may have been lost.

The matrix is given as a list of points: columns x and y in the units of the extents, z in that of the values.
"""

import math
import re
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from tribopipe.base.errors import ReaderError
from tribopipe.base.units import is_unit, is_unit_of, to_si
from tribopipe.readers.delimited import read_table
from tribopipe.readers.layout import Layout
from tribopipe.readers.number_fields import together
from tribopipe.readers.reader import Hints, Holds, Match, ReadColumn, ReadTable, refused
from tribopipe.readers.tables import is_gap, is_number
from tribopipe.readers.text import BLANKS, Text, decode, sample_lines
from tribopipe.results.run import SourceFile

_HEAD_BYTES = 1 << 18
_SQUARE = 1e-3
"""Relative difference of a pixel's sides that may be rounding in the header."""
_COMMENT = re.compile(r"#[^:]+:\s*(?P<said>.*)")
_EXTENT = re.compile(r"(?P<number>\d+(?:[.,]\d+)?(?:[eE][+-]?\d+)?)\s*(?P<unit>\D\S*)", re.ASCII)


class GwyddionReader:
    """Maps that Gwyddion wrote as text."""

    name = "gwyddion-text"
    title = "Gwyddion text export of a map (.txt)"
    holds: Holds = "profile"
    suffixes = (".txt",)

    def match(self, source: SourceFile) -> Match:
        """Judge by the header of comments, whatever its language, and the row of numbers below it."""
        head = SourceFile(source.name, source.content[:_HEAD_BYTES])
        try:
            text = decode(head, partial=len(source.content) > _HEAD_BYTES)
            extents = _find_extents(text)
        except ReaderError as error:
            return refused(source, error)
        wide, high = extents.wide, extents.high
        return Match(0.95, f"comments above a matrix state its size, {wide[0]:g} {wide[1]} by {high[0]:g} {high[1]}")

    def read(self, source: SourceFile, hints: Hints) -> ReadTable:
        """Parse the file; ``ReaderError`` with file and line where a row is cut or is not of numbers."""
        text = decode(source, hints.encoding)
        extents = _find_extents(text)
        table = read_table(text, _layout(text, extents, hints))
        for column in table.columns:
            if column.first_bad is not None:
                line, found = column.first_bad
                raise ReaderError(
                    f"{text.name}, line {line}: found {found!r} in the matrix; expected only numbers; correct "
                    "that line, or export the map again"
                )
        heights = np.column_stack([column.values for column in table.columns])
        rows, columns = heights.shape
        if rows < 2:
            raise ReaderError(
                f"{text.name}: found a matrix of a single row; expected several rows; copy the file again, or "
                "export a profile as columns x z"
            )
        x = np.tile((np.arange(columns) + 0.5) * extents.wide[0] / columns, rows)
        y = np.repeat((np.arange(rows) + 0.5) * extents.high[0] / rows, columns)
        points = (
            ReadColumn("x", x, extents.wide[1], axis="x"),
            ReadColumn("y", y, extents.high[1], axis="y"),
            ReadColumn("z", heights.ravel(), extents.value_unit, axis="z", placeholders=together(table.columns)),
        )
        return ReadTable(points, table.header, (*table.notes, *_oblong(extents, rows, columns)))


class _Extents(NamedTuple):
    """Contents of the header."""

    wide: tuple[float, str]
    """Along the rows, with its unit."""
    high: tuple[float, str]
    """Across the rows, with its unit."""
    value_unit: str
    lines: list[str]
    """The header's lines."""
    first: str
    """The first row of the matrix."""


def _find_extents(text: Text) -> _Extents:
    """Read the header. Raises ``ReaderError`` where it is none of Gwyddion's, or no row of numbers follows."""
    lines = sample_lines(text)
    header = lines[: next((at for at, line in enumerate(lines) if not _is_comment(line)), len(lines))]
    said = [found["said"].strip() for line in header if (found := _COMMENT.match(line))]
    extents = [(_number(found["number"]), found["unit"]) for each in said if (found := _EXTENT.fullmatch(each))]
    unit = said[-1] if said else ""
    first = next((line for line in lines[len(header) :] if not line.isspace()), "")
    lengths = [of for _, of in extents if is_unit_of(of, "length")]
    if len(extents) != 2 or len(lengths) != 2 or not is_unit(unit) or not first:
        raise ReaderError(
            f"{text.name}: found no comment lines with two extents and the unit of the values above a matrix; expected "
            "'# Width: 12 µm', '# Height: 8 µm', '# Value units: m' in any language; export the map from Gwyddion with "
            "its informational header"
        )
    if not all(extent > 0 for extent, _ in extents):
        raise ReaderError(
            f"{text.name}: found a map of {extents[0][0]:g} {extents[0][1]} by {extents[1][0]:g} {extents[1][1]}; "
            "expected positive extents; export the map again"
        )
    if not all(is_number(cell, ".,") or is_gap(cell) for cell in first.split()):
        raise ReaderError(
            f"{text.name}, line {len(header) + 1}: found {first.strip()[:40]!r} below the comments; expected a row of "
            "numbers; export the map from Gwyddion as a matrix"
        )
    return _Extents(extents[0], extents[1], unit, header, first)


def _is_comment(line: str) -> bool:
    """Return whether a line belongs to the header; "#ERR 1.5e-09" is a row."""
    first, *_ = line.split() or [""]
    return line.startswith("#") and (first == "#" or not is_gap(first))


def _oblong(extents: _Extents, rows: int, columns: int) -> Iterator[str]:
    """Report where pixels are not square: the header does not give the number of rows, some of which may be lost."""
    wide, high = extents.wide[0] / columns, extents.high[0] / rows
    across = to_si(high, extents.high[1], "length") / to_si(wide, extents.wide[1], "length")
    if not math.isclose(across, 1.0, rel_tol=_SQUARE):
        yield (
            f"pixels are {wide:.4g} {extents.wide[1]} by {high:.4g} {extents.high[1]}, not square: the y positions "
            "are wrong if rows are missing"
        )


def _number(text: str) -> float:
    return float(text.replace(",", "."))


def _layout(text: Text, extents: _Extents, hints: Hints) -> Layout:
    cells = extents.first.split()
    signs = "".join(sign for sign in ".," if any(sign in cell for cell in cells))
    width, header, line = len(cells), "".join(extents.lines), len(extents.lines) + 1
    both = f"{text.name}, line {line}: found both . and , in one row; expected one decimal separator; correct that line"
    return Layout(
        hints.separator or BLANKS,
        hints.decimal or ("," if signs == "," else "."),
        names=tuple(f"column {number}" for number in range(1, width + 1)),
        line=line,
        header=header,
        width=width,
        least=width,
        doubt=both if signs == ".," else None,
    )
