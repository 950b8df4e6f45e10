"""The list of runs for other programs: CSV, spreadsheets, LaTeX, Markdown, Parquet.

Headers are names and units; a Parquet file has numbers in SI and names alone. Standard uncertainties are in separate
columns of machine-readable tables, and in the cell of the number in LaTeX and Markdown. Forces are in N if one of them
is 1 N or more, otherwise in mN.
"""

import csv
import io
import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from datetime import datetime
from typing import Any, NamedTuple

from tribopipe.archive.catalog.listing import COLUMNS, ListedColumn, ListedRun, shown_number, usual_columns
from tribopipe.base.optional_packages import required
from tribopipe.base.units import KINDS, force_unit, superscript
from tribopipe.views.csv_files import csv_field, head_of

Runs = Sequence[ListedRun]
_LEAST, _MOST = 1e-3, 1e5
"""Range of the largest number in a column in which no power of ten is used."""


def _with_units(runs: Runs, columns: Sequence[ListedColumn] | None) -> list[ListedColumn]:
    """Return the selected columns, by default all, with the display unit of forces in these runs."""
    return [_in_readable_unit(runs, column) for column in (COLUMNS.values() if columns is None else columns)]


def _in_readable_unit(runs: Runs, column: ListedColumn) -> ListedColumn:
    if column.measures != "force":
        return column
    known = [abs(value) for run in runs if (value := run.value(column.name)) is not None]
    return replace(column, unit=force_unit(max(known, default=0.0)))


def _table(runs: Runs, columns: Sequence[ListedColumn] | None) -> tuple[list[str], Iterator[list[float | str]]]:
    """Return column headers and rows in machine-readable form; unknown numbers are NaN."""
    chosen = _with_units(runs, columns)
    heads = [head for column in chosen for head in _heads(column)]
    return heads, ([field for column in chosen for field in _fields(run, column)] for run in runs)


def _heads(column: ListedColumn) -> Iterator[str]:
    uncertain = column.kind == "number" and not column.exact
    names = [column.name, f"{column.name} uncertainty"] if uncertain else [column.name]
    yield from (head_of(name, column.unit) if column.unit else name for name in names)


def _fields(run: ListedRun, column: ListedColumn) -> Iterator[float | str]:
    if column.kind == "number":
        numbers = _numbers(run, column)[: 1 if column.exact else 2]
        yield from (math.nan if number is None else number for number in numbers)
    else:
        yield run.text(column.name)


def _numbers(run: ListedRun, column: ListedColumn) -> tuple[float | None, float | None]:
    """Return a number and its standard uncertainty in the unit of the column."""
    value, spread = run.value(column.name), run.uncertainty(column.name)
    return shown_number(column)(value), shown_number(column, spread=True)(spread)


def runs_csv(runs: Runs, columns: Sequence[ListedColumn] | None = None, *, decimal_comma: bool = False) -> bytes:
    """Return a list of runs as CSV, in UTF-8.

    Separators are commas, with decimal points (RFC 4180), or semicolons, with decimal commas and a UTF-8 mark at the
    start, as spreadsheets expect in most European languages. Headers are names and units, "load [mN]"; each number is
    followed by its standard uncertainty, "load uncertainty [mN]". Unknown values are empty fields.
    """
    heads, rows = _table(runs, columns)
    written = io.StringIO(newline="")
    writer = csv.writer(written, delimiter=";" if decimal_comma else ",")
    writer.writerow(map(csv_field, heads))
    for row in rows:
        writer.writerow([_with_comma(value) if decimal_comma else csv_field(value) for value in row])
    return written.getvalue().encode("utf-8-sig" if decimal_comma else "utf-8", "backslashreplace")


def _with_comma(value: float | str) -> str:
    return csv_field(value) if isinstance(value, str) else csv_field(value).replace(".", ",")


def runs_workbook(runs: Runs, columns: Sequence[ListedColumn] | None = None) -> bytes:
    """Return a list of runs as an .xlsx workbook: the columns of the CSV file, numbers as numbers, dates as dates.

    Raises ``NotInstalledError`` if openpyxl is not installed.
    """
    book = required("openpyxl", "excel", "writing workbooks").Workbook(write_only=True)
    sheet = book.create_sheet("runs")
    heads, rows = _table(runs, columns)
    sheet.freeze_panes = "B2"
    for place, head in enumerate(heads, start=1):
        sheet.column_dimensions[_letters(place)].width = max(10, len(head) + 2)
    sheet.append([_cell(sheet, head) for head in heads])
    for row in rows:
        sheet.append([_cell(sheet, value) for value in row])
    written = io.BytesIO()
    book.save(written)
    return written.getvalue()


def _letters(place: int) -> str:
    from openpyxl.utils import get_column_letter

    return str(get_column_letter(place))


def _cell(sheet: Any, value: float | str) -> Any:
    """Return a cell; texts remain texts, whatever they begin with, without characters that XML cannot represent."""
    from openpyxl.cell import WriteOnlyCell
    from openpyxl.cell.cell import ILLEGAL_CHARACTERS_RE

    if not isinstance(value, str):
        return WriteOnlyCell(sheet, None if math.isnan(value) else value)
    if re.fullmatch(r"\d{4}-\d\d-\d\d \d\d:\d\d", value):
        return WriteOnlyCell(sheet, datetime.fromisoformat(value))
    cell = WriteOnlyCell(sheet, ILLEGAL_CHARACTERS_RE.sub("�", value.encode("utf-8", "backslashreplace").decode()))
    cell.data_type = "s"
    return cell


class SiColumns(NamedTuple):
    """Columns of a list of runs, numbers in SI."""

    values: dict[str, list[Any]]
    """By name; "u_" with it is the standard uncertainty. None where nothing is known."""
    units: dict[str, str]
    """SI unit of each column of numbers; "1" where there is none."""


def si_columns(runs: Runs, columns: Sequence[ListedColumn] | None = None) -> SiColumns:
    """Return columns of a list of runs, by default all, for programs that compute with them."""
    found = SiColumns({}, {})
    for one in COLUMNS.values() if columns is None else columns:
        if one.kind == "number":
            found.values[one.name] = [run.value(one.name) for run in runs]
            found.units[one.name] = KINDS[one.measures].si
            if not one.exact:
                found.values[f"u_{one.name}"] = [run.uncertainty(one.name) for run in runs]
                found.units[f"u_{one.name}"] = KINDS[one.measures].si
        else:
            found.values[one.name] = [run.text(one.name) or None for run in runs]
    return found


def runs_parquet(runs: Runs, columns: Sequence[ListedColumn] | None = None) -> bytes:
    """Return a list of runs as a Parquet file for pandas, Polars, DuckDB or R, numbers in SI.

    Each column of numbers states its unit in its metadata, under "unit".

    Raises ``NotInstalledError`` if pyarrow is not installed.
    """
    pa = required("pyarrow", "parquet", "writing Parquet files")
    from pyarrow import parquet

    found = si_columns(runs, columns)
    numbers = {name: pa.field(name, pa.float64(), metadata={"unit": unit}) for name, unit in found.units.items()}
    fields = [numbers.get(name) or pa.field(name, pa.string()) for name in found.values]
    written = io.BytesIO()
    parquet.write_table(pa.table(found.values, schema=pa.schema(fields)), written)
    return written.getvalue()


class _Column(NamedTuple):
    """A displayed column: one unit and one power of ten for all its numbers."""

    column: ListedColumn
    power: int
    cells: list[tuple[str, str] | str | None]
    """A number with its uncertainty in units of its last digit, empty if it has none; or a text; or None."""


def _columns(runs: Runs, columns: Sequence[ListedColumn] | None) -> list[_Column]:
    return [_column(runs, one) for one in _with_units(runs, usual_columns(runs) if columns is None else columns)]


def _column(runs: Runs, column: ListedColumn) -> _Column:
    if column.kind != "number":
        return _Column(column, 0, [run.text(column.name) or None for run in runs])
    numbers = [_numbers(run, column) for run in runs]
    largest = max((abs(value) for value, _ in numbers if value is not None), default=0.0)
    power = 0 if not largest or _LEAST <= largest < _MOST else math.floor(math.log10(largest))
    return _Column(column, power, [_rounded(value, spread, power) for value, spread in numbers])


def _rounded(value: float | None, spread: float | None, power: int) -> tuple[str, str] | None:
    """Round a number to two digits of its uncertainty, or to four digits without one."""
    if value is None:
        return None
    number = value / 10.0**power
    if not spread:
        four = float(f"{number:.4g}")
        return f"{four:.{max(0, 3 - _exponent(four))}f}".rstrip("0").rstrip(".") if four % 1 else f"{four:.0f}", ""
    scaled = spread / 10.0**power
    digits = max(0, 1 - _exponent(scaled))
    return f"{number:.{digits}f}", f"{scaled * 10.0**digits:.0f}"


def _exponent(number: float) -> int:
    return int(f"{number:.1e}".partition("e")[2])


def runs_markdown(runs: Runs, columns: Sequence[ListedColumn] | None = None) -> bytes:
    """Return a list of runs as a Markdown table; ± is one standard uncertainty, and – an unknown value."""
    chosen = _columns(runs, columns)
    heads = [_plain_head(one) for one in chosen]
    marks = ["---:" if one.column.kind == "number" else "---" for one in chosen]
    rows = [[_plain_cell(one.cells[place]) for one in chosen] for place in range(len(runs))]
    lines = (f"| {' | '.join(map(_markdown, row))} |" for row in (heads, marks, *rows))
    return "".join(f"{line}\n" for line in lines).encode("utf-8", "backslashreplace")


def _plain_head(one: _Column) -> str:
    power = f"10{superscript(one.power)}" if one.power else ""
    unit = " ".join(filter(None, (power, one.column.unit)))
    return f"{one.column.label} / {unit}" if unit else one.column.label


def _plain_cell(cell: tuple[str, str] | str | None) -> str:
    if cell is None or isinstance(cell, str):
        return cell or "–"
    number, last_digits = cell
    if not last_digits:
        return number
    decimals = len(number.partition(".")[2])
    return f"{number} ± {int(last_digits) / 10**decimals:.{decimals}f}"


def _markdown(text: str) -> str:
    return re.sub(r"([\\|`*_<])", r"\\\1", re.sub(r"\s+", " ", text))


def runs_latex(runs: Runs, columns: Sequence[ListedColumn] | None = None, *, decimal_comma: bool = False) -> bytes:
    """Return a list of runs as a LaTeX table for booktabs and siunitx, version 3, the uncertainty in parentheses."""
    chosen = _columns(runs, columns)
    lines = [
        "% \\usepackage{booktabs, siunitx}",
        "% In parentheses: standard uncertainty of the last digits.",
        *(["\\sisetup{output-decimal-marker = {,}}"] if decimal_comma else []),
        f"\\begin{{tabular}}{{{' '.join(map(_alignment, chosen))}}}",
        "  \\toprule",
        _latex_row(_latex_head(one) for one in chosen),
        "  \\midrule",
        *(_latex_row(_latex_cell(one.cells[place]) for one in chosen) for place in range(len(runs))),
        "  \\bottomrule",
        "\\end{tabular}",
    ]
    return "".join(f"{line}\n" for line in lines).encode("utf-8", "backslashreplace")


def _latex_row(cells: Iterator[str]) -> str:
    return f"  {' & '.join(cells)} \\\\"


def _alignment(one: _Column) -> str:
    """Return the alignment of a column: numbers at the decimal separator, with room for the longest of each part."""
    if one.column.kind != "number":
        return "l"
    numbers = [cell for cell in one.cells if isinstance(cell, tuple)]
    whole = max((len(number.partition(".")[0].removeprefix("-")) for number, _ in numbers), default=1)
    decimals = max((len(number.partition(".")[2]) for number, _ in numbers), default=0)
    spread = max((len(last) for _, last in numbers), default=0)
    sign = "-" if any(number.startswith("-") for number, _ in numbers) else ""
    form = f"{sign}{whole}{f'.{decimals}' if decimals else ''}{f'({spread})' if spread else ''}"
    return f"S[table-format = {form}]"


def _latex_head(one: _Column) -> str:
    power = f"$10^{{{one.power}}}$" if one.power else ""
    unit = f"\\unit{{{_siunitx(one.column.unit)}}}" if one.column.unit else ""
    label = _latex_text(one.column.label)
    shown = "\\,".join(filter(None, (power, unit)))
    return f"{{{label} / {shown}}}" if shown else f"{{{label}}}"


def _latex_cell(cell: tuple[str, str] | str | None) -> str:
    if cell is None:
        return "{--}"
    if isinstance(cell, str):
        return _latex_text(cell)
    number, last_digits = cell
    return f"{number}({last_digits})" if last_digits else number


_UNITS = {
    **{
        f"{sign}{unit}": f"{prefix}{name}"
        for sign, prefix in (("", ""), ("m", "\\milli"), ("µ", "\\micro"), ("n", "\\nano"))
        for unit, name in (("m", "\\metre"), ("N", "\\newton"), ("s", "\\second"))
    },
    "min": "\\minute",
    "%": "\\percent",
    "°C": "\\degreeCelsius",
}
_POWERS = {"²": "\\squared", "³": "\\cubed", "": ""}


def _siunitx(unit: str) -> str:
    """Write a unit with the macros of siunitx: mm³/(N·mm) as milli metre cubed per newton per milli metre."""
    above, _, below = unit.partition("/")
    return "".join(
        f"{per}{_UNITS[part.rstrip('²³')]}{_POWERS[part[len(part.rstrip('²³')) :]]}"
        for per, parts in (("", above), ("\\per", below.strip("()")))
        for part in parts.split("·")
        if part
    )


_LATEX: Mapping[str, str] = {
    **{sign: f"\\{sign}" for sign in "&%$#_{}"},
    **{sign: f"\\textsubscript{{{digit}}}" for digit, sign in enumerate("₀₁₂₃₄₅₆₇₈₉")},
    **{sign: f"\\textsuperscript{{{digit}}}" for digit, sign in enumerate("⁰¹²³⁴⁵⁶⁷⁸⁹")},
    "\\": "\\textbackslash{}",
    "~": "\\textasciitilde{}",
    "^": "\\textasciicircum{}",
    "<": "\\textless{}",
    ">": "\\textgreater{}",
    "μ": "$\\mu$",
    "µ": "$\\mu$",
    "−": "$-$",
    "×": "$\\times$",
    "±": "$\\pm$",
}


def _latex_text(text: str) -> str:
    """Escape a text for LaTeX."""
    if text.startswith("k_D"):
        return "$k_\\mathrm{D}$" + _latex_text(text.removeprefix("k_D"))
    return "".join(_LATEX.get(sign, sign) for sign in re.sub(r"\s+", " ", text))


FORMS: Mapping[str, Callable[..., bytes]] = {
    ".csv": runs_csv,
    ".xlsx": runs_workbook,
    ".tex": runs_latex,
    ".md": runs_markdown,
    ".parquet": runs_parquet,
}
"""Functions that write a list of runs, by the suffix of the file."""
WITH_COMMAS = (".csv", ".tex")
"""Formats that may have decimal commas; in a workbook, the program that opens it decides."""
