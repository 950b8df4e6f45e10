"""Tables of what was measured in many tests: one row per run, one column per key of run.toml.

`new --ends` reads them for runs that were recorded, and `new --each-row` for tests of which the row is all there is.

    run;normal load [N];pin_scar_diameter [um];u(pin_scar_diameter) [um]
    test_01;5;412;3

A column is named by a key of run.toml, or as header lines name it; its unit stands behind the name or in each cell.
"""

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from tribopipe.base.errors import ManifestError, UnitError, did_you_mean
from tribopipe.base.units import has_decimal_comma, is_maybe_thousands, with_point
from tribopipe.documents.manifest import EndValues
from tribopipe.readers.column_meanings import plain
from tribopipe.readers.draft.known_values import Given, sections, shared_key
from tribopipe.readers.export_files import open_export
from tribopipe.readers.formats.workbook import WorkbookReader
from tribopipe.readers.header_facts import key_of
from tribopipe.readers.reader import is_sure
from tribopipe.readers.tables import split_name
from tribopipe.readers.text import Row, decode, sampled_rows

_RUN_NAMES = (
    "run, run id, id, file, test, test id, specimen, specimen id, sample, sample id, Versuch, Lauf, Datei, Probe, "
    "Probekörper, essai, échantillon, ensayo, muestra, próba, próbka, 试验, 試験"
)
_RUN = frozenset(map(plain, _RUN_NAMES.split(", ")))
_SCARS = {
    "end_values.pin_scar_diameter": (
        "scar diameter, wear scar diameter, ball scar diameter, Kalottendurchmesser, diamètre d'usure, "
        "diámetro de huella, średnica skazy, 磨斑直径, 摩耗痕径"
    ),
    "end_values.disc_track_width": (
        "track width, wear track width, Spurbreite, largeur de piste, ancho de huella, 磨痕宽度"
    ),
    "end_values.disc_track_area": (
        "track area, wear track area, cross-section area, cross-sectional area, Spurquerschnitt"
    ),
    "end_values.pin_wear_volume": "ball wear volume, Kugelvolumen",
    "end_values.pin_mass_loss": "ball mass loss",
    "end_values.disc_wear_depth": "track depth, wear track depth, Spurtiefe",
}
_SYNONYMS = {plain(name): key for key, names in _SCARS.items() for name in names.split(", ")}
_OF_TWO = ("wearvolume", "volume", "massloss", "verschleissvolumen", "masseverlust")
_BALL_SIZES = ("contact.pin.diameter", "contact.pin.radius")
_UNCERTAINTY = re.compile(r"(?:u\s*\((?P<inner>.+)\)|[u±][ _](?P<behind>.+))", re.DOTALL)
_NUMBER = re.compile(r"[+-]?\d+(?:[.,]\d+)?(?:[eE][+-]?\d+)?", re.ASCII)
_WITH_POINT = re.compile(r"(?<![\d.,])\d+\.\d+(?![\d.,])", re.ASCII)
_WHOLE = re.compile(r"(^|\t)([+-]?\d+)\.0(?=\t|$)", re.ASCII | re.MULTILINE)
_SEPARATORS = "\t;|,"


class EndsRow(NamedTuple):
    """Row of a table for one run."""

    run: str
    """Its id, or the name of its file."""
    line: int
    values: Mapping[str, Given]
    """Values by key of run.toml, each with its source."""
    other: Mapping[str, str]
    """Fields of columns that are no key of run.toml, by the names of these columns."""
    is_ball: bool
    """Whether the row states the size of a ball, so that the pin is spherical."""


class _Column(NamedTuple):
    """Content of one column: a key of run.toml, or its standard uncertainty."""

    place: int
    name: str
    key: str
    unit: str | None
    is_uncertainty: bool
    is_ball: bool


class EndsTable(NamedTuple):
    """A table of many runs."""

    name: str
    rows: tuple[EndsRow, ...]
    unused: tuple[str, ...]
    """Columns that are no key of run.toml."""

    def row_of(self, *names: str) -> EndsRow | None:
        """Return the row of a run by any of its names."""
        wanted = {name.casefold() for name in names}
        return next((row for row in self.rows if row.run.casefold() in wanted), None)

    def refuse_unknown(self, names: Sequence[str]) -> None:
        """Raise ``ManifestError`` where a row is of none of the runs."""
        known = {name.casefold() for name in names}
        for row in self.rows:
            if row.run.casefold() not in known:
                raise ManifestError(
                    f"{self.name}, line {row.line}: found the run {row.run!r}, for which no file is specified; "
                    f"expected a run with a specified file; {did_you_mean(row.run, list(names))}"
                )


def read_ends(path: Path) -> EndsTable:
    """Read a table of many runs, .csv or .xlsx.

    Raises ``ManifestError`` with file, line and column where a run stands in it twice or a column may mean two things;
    ``ReaderError`` where the file cannot be read.
    """
    separator, (head, *rows) = _rows(path)
    columns, unused = _columns(path.name, head)
    commas = any(has_decimal_comma(cell) for row in rows for cell in row.cells[1:])
    # Where a comma separates no columns it may be the decimal sign, so that a point has to be shown to be it.
    commas = commas or (separator == ";" and not any(_shows_point(row, columns, unused) for row in rows))
    found: dict[str, EndsRow] = {}
    for row in rows:
        run = row.cells[0].strip() if row.cells else ""
        if not run:
            raise ManifestError(
                f"{path.name}, line {row.line}: found a row without a run ID or file name; expected one of the two; "
                "enter it, or delete the row"
            )
        before = found.get(run.casefold())
        if before is not None:
            raise ManifestError(
                f"{path.name}, line {row.line}: found the run {run!r} twice, first in line {before.line}; "
                "expected one row per run; delete one of the rows"
            )
        found[run.casefold()] = _row(path.name, run, row, columns, unused, commas=commas)
    return EndsTable(path.name, tuple(found.values()), tuple(unused.values()))


def is_of_tests(names: Sequence[str]) -> bool:
    """Return whether columns are those of a table of tests, by their names: runs first, then a specimen or its wear."""
    if not names or plain(names[0]) not in _RUN:
        return False
    keys = [_key(_bare(split_name(name)[0])[0]) for name in names[1:]]
    return any(key is not None and key.startswith(("end_values.", "contact.")) for key in keys)


def _rows(path: Path) -> tuple[str, list[Row]]:
    """Return the sign between columns, and the rows of a table, that of names the first."""
    source = open_export(path)
    if is_sure(WorkbookReader().match(source)):
        # All numbers of a workbook are floats, so that specimen 17 would be called 17.0.
        cells = _WHOLE.sub(r"\1\2", WorkbookReader().first_sheet(source))
        lines, separator = cells.splitlines(keepends=True), "\t"
    else:
        lines = decode(source).content.decode().lstrip("\ufeff").splitlines(keepends=True)
        head = next((line for line in lines if line.strip()), "")
        separator = max(_SEPARATORS, key=head.count)
    rows = [row for row in sampled_rows(lines, separator) if any(row.cells)]
    if len(rows) < 2:
        raise ManifestError(
            f"{path.name}: found {len(rows)} rows; expected a header row and one row per run; complete the table"
        )
    return separator, rows


def _shows_point(row: Row, columns: Sequence[_Column], unused: Mapping[int, str]) -> bool:
    """Return whether a point in a row can only be a decimal one, as in 12.5 but not in the steel 1.3505."""
    places = {column.place for column in columns if not _is_text(column.key)}
    places |= {place for place, name in unused.items() if split_name(name)[1] is not None}
    cells = (row.cells[place] for place in places if place < len(row.cells))
    return any(not is_maybe_thousands(found[0]) for cell in cells for found in _WITH_POINT.finditer(cell))


def _is_text(key: str) -> bool:
    """Return whether a key of run.toml holds a text, such as the name of a material."""
    table, _, name = key.rpartition(".")
    field = next((one for called, one in sections()[table].model_fields.items() if name in (called, one.alias)), None)
    return field is not None and field.annotation in (str, str | None)


def _row(
    file: str, run: str, row: Row, columns: Sequence[_Column], unused: Mapping[int, str], *, commas: bool
) -> EndsRow:
    cells = {place: cell for place, cell in enumerate(row.cells) if cell}
    nameless = cells.keys() - {0, *unused, *(column.place for column in columns)}
    if nameless:
        raise ManifestError(
            f"{file}, line {row.line}: found {cells[min(nameless)]!r} in a column without a name; expected a name "
            "for each column; add the name, or put quotes around a field that contains the column separator"
        )
    other = {name: cells[place] for place, name in unused.items() if place in cells}
    is_ball = any(column.is_ball and column.place in cells for column in columns)
    return EndsRow(run, row.line, _values(file, row, columns, commas=commas), other, is_ball)


def _columns(file: str, head: Row) -> tuple[list[_Column], dict[int, str]]:
    """Report what the columns behind the first are. Raises ``ManifestError`` where that is unclear."""
    if plain(head.cells[0]) not in _RUN:
        raise ManifestError(
            f"{file}, line {head.line}: found the first column {head.cells[0]!r}; expected the column 'run', with the "
            f"ID or the file name of each run; rename the column, or put the column 'run' first"
        )
    columns: list[_Column] = []
    unused: dict[int, str] = {}
    for place, written in enumerate(head.cells[1:], 1):
        name, unit = split_name(written)
        bare, is_uncertainty = _bare(name)
        if plain(bare) in _OF_TWO:
            raise ManifestError(
                f"{file}, line {head.line}: found the column {written!r}, which may refer to the pin or the disc; "
                "expected an unambiguous name; rename it pin_wear_volume, disc_wear_volume, pin_mass_loss or "
                "disc_mass_loss"
            )
        key = _key(bare)
        if key is None:
            unused |= {place: written} if written else {}
        elif any((one.key, one.is_uncertainty) == (key, is_uncertainty) for one in columns):
            raise ManifestError(
                f"{file}, line {head.line}: found a second column for {key}, {written!r}; expected one column; "
                "delete one of them"
            )
        else:
            columns.append(_Column(place, written, key, unit, is_uncertainty, key_of(bare) in _BALL_SIZES))
    return columns, unused


def _bare(name: str) -> tuple[str, bool]:
    """Return what a column is about, and whether it holds the standard uncertainty of that."""
    uncertain = _UNCERTAINTY.fullmatch(name)
    return (uncertain["inner"] or uncertain["behind"], True) if uncertain else (name, False)


def _key(name: str) -> str | None:
    """Return the key of run.toml that a column is named after."""
    tables = sections()
    table, _, last = "_".join(name.casefold().split()).rpartition(".")
    for where in (table,) if table else ("", "conditions", "end_values"):
        if where in tables and last in {rules.alias or one for one, rules in tables[where].model_fields.items()}:
            key = f"{where}.{last}" if where else last
            return None if key in tables or key in ("id", "schema", "signals", "interruptions") else key
    if not table and shared_key(f"end_values.{last}").removeprefix("end_values.") in EndValues.model_fields:
        return f"end_values.{last}"
    return _SYNONYMS.get(plain(name)) or key_of(name)


def _values(file: str, row: Row, columns: Sequence[_Column], *, commas: bool) -> dict[str, Given]:
    cells = {column: row.cells[column.place] if column.place < len(row.cells) else "" for column in columns}
    where = f"{file}, line {row.line}"
    written = {column: _written(where, column, cell, commas=commas) for column, cell in cells.items() if cell}
    values: dict[str, Given] = {}
    for column, value in written.items():
        if not column.is_uncertainty:
            values[column.key] = Given(value, f"from {file}, line {row.line}")
    for column, value in written.items():
        if column.is_uncertainty and column.key not in values:
            raise ManifestError(
                f"{file}, line {row.line}, column {column.name!r}: found an uncertainty without a value of "
                f"{column.key}; expected both; enter the value, or clear the field"
            )
        if column.is_uncertainty:
            both: dict[str, Any] = {"value": values[column.key].value, "standard_uncertainty": value}
            values[column.key] = values[column.key]._replace(value=both)
    return values


def _written(where: str, column: _Column, cell: str, *, commas: bool) -> str:
    """Return a cell as run.toml would hold it, which refuses a number without a unit when it takes it.

    Raises ``ManifestError`` where a comma, or a point if ``commas`` may be the decimal signs, may stand between
    thousands.
    """
    try:
        text = with_point(cell, commas=commas)
    except UnitError as error:
        raise ManifestError(f"{where}, column {column.name!r}: {error}") from None
    return f"{text} {column.unit}" if column.unit is not None and _NUMBER.fullmatch(text) else text
