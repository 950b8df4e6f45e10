"""The table in the head of a text: separator, row of names, row of units, where the numbers begin.

With what a single field may be: a number, a name with its unit, or one of the placeholders that instruments,
spreadsheets and printf write where they have no number: OVL, ---, #N/A, 1.#INF.
"""

import re
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

from tribopipe.base.errors import ReaderError
from tribopipe.base.ordinary_units import ORDINARY
from tribopipe.base.units import is_unit, is_unit_of
from tribopipe.readers.reader import Hints
from tribopipe.readers.text import BLANKS, MOST_COLUMNS, SAMPLE_LINES, Row, Text, sample_lines, sampled_rows, trimmed

MISSING = ("", "NaN", "nan", "NA")
"""How a missing sample is written plainly."""
_WORDS = (
    "ovl|ovf|ovld|o\\.?l\\.?|over(?:flow|load|range|run)?|under(?:flow|load|range|run)?|out of range|"
    "err(?:or)?\\.?|fault|inval(?:id)?|missing|void|none|null|nil|empty|"
    "n\\.?a\\.?|n/a|nv|n/v|n/d|n\\.d\\.|nan[qs]?|inf(?:inity)?"
)
PLACEHOLDER = (
    "(?:"
    "(?:[-.:*#?_]|–|—|−|…)+"
    "|[+-]?\\d+[.,]#[a-z]+\\d*"
    f"|[+-]?(?:{_WORDS})(?:\\([a-z]*\\))?"
    "|#(?:n/a|nv|err(?:or)?|value!|wert!|div/0!|num!|zahl!|ref!|bezug!|name\\?|null!|calc!)!?"
    ")"
)
"""Regular expression for one, in small or capital letters, without blanks around it, matched in one way only."""
_ALONE = re.compile(PLACEHOLDER, re.IGNORECASE)


def is_placeholder(cell: str) -> bool:
    """Return whether a field states that there is no number."""
    return _ALONE.fullmatch(cell) is not None


def is_gap(cell: str) -> bool:
    """Return whether a field is a missing sample: empty, not a number (NaN), or a placeholder."""
    return cell in MISSING or is_placeholder(cell)


GROUPED = re.compile(r"[+-]?\d{1,3}(?:[.,' \u00a0\u202f]\d{3})+(?:[.,]\d*)?", re.ASCII)
"""Number whose thousands are separated."""
INTEGER = re.compile(r"[+-]?\d+", re.ASCII)
_COUNT = re.compile(r"\d{1,18}", re.ASCII)
_UNIT_BEHIND_SLASH = re.compile(r"(?P<bare>[^/]*[^\s/])/(?P<unit>\S+)")
_UNITS_IN_NAMES = (
    re.compile(r"(?P<bare>.+)\[(?P<unit>[^\[\]]*)\]"),
    re.compile(r"(?P<bare>.+)\((?P<unit>(?:[^()]|\([^()]*\))*)\)"),
    re.compile(r"(?P<bare>.+)[{<](?P<unit>[^{}<>]*)[}>]"),
    re.compile(r"(?P<bare>.+)\s/\s+(?P<unit>\S+)"),
    _UNIT_BEHIND_SLASH,
)
_UNITS_WITHOUT_BRACKETS = (
    re.compile(r"(?P<bare>.+),\s(?P<unit>\S+)"),
    re.compile(r"(?P<bare>.+)\sin\s(?P<unit>\S+)"),
    re.compile(r"(?P<bare>.*[^\W_])_(?P<unit>[^\s_]+)"),
)
_FEWEST_LETTERS = (
    dict.fromkeys(ORDINARY, 1)
    | dict.fromkeys(("µm", "μm", "mm3", "µs", "us", "sec", "gf", "kgf", "lb", "lbf", "mil", "mps", "Nm", "Nmm"), 1)
    | {"N": 2, "s": 3, "m": 3, "g": 3, "h": 3, "K": 3}
)
"""Units without brackets, with the fewest letters of a name before each: F_N is the normal force, v_m a mean speed."""
_IN_RPM = re.compile(r"(?:.*[\s_])?(?P<unit>rpm)", re.IGNORECASE)
_OF_TIME = re.compile(r"t|(?i:.*(?:time|stamp|elapsed|zeit|dauer|temps|tiempo|tempo))")
_SYMBOLS = {"t": "time", "T": "temperature", "s": "length", "h": "length", "F": "force"}
"""Kind of quantity by symbols that are units as well: "t/s" is a time in s, and no tonnes per second."""
_CLOCK_FORM = re.compile(r"[\[(]\s*(?:h{1,2}:)?m{1,2}:s{1,2}(?:[.,]\w+)?\s*[\])]$", re.IGNORECASE | re.ASCII)
"""How times of day are written, behind a name: "Time (hh:mm:ss)"."""
_LONE_PREFIXES = ("µ", "μ", "u")
_LONGEST_NAME = 1000
_WIDE_BRACKETS = str.maketrans("（）［］【】", "()[][]")
"""Full-width brackets, as Chinese and Japanese programs write them."""
_UNIT_ROW_LABELS = ("unit", "units", "einheit", "einheiten", "単位", "单位")


def split_name(name: str) -> tuple[str, str | None]:
    """Split a column's name as a header writes it into name and unit; what is longer than any name has none."""
    if len(name) > _LONGEST_NAME:
        return name, None
    return _split_at_brackets(name) or _split_without_brackets(name)


def unit_in_brackets(name: str) -> str | None:
    """Return the unit that a name has in brackets or behind a slash."""
    split = _split_at_brackets(name) if len(name) <= _LONGEST_NAME else None
    return split and split[1]


def _split_at_brackets(name: str) -> tuple[str, str | None] | None:
    name = name.translate(_WIDE_BRACKETS)
    for pattern in _UNITS_IN_NAMES:
        matched = pattern.fullmatch(name)
        if matched is None:
            continue
        bare, unit = matched["bare"].rstrip().rstrip(" /"), matched["unit"].strip()
        if bare and is_unit(unit) and not (pattern is _UNIT_BEHIND_SLASH and _ends_in_unit(name)):
            return bare, meant_unit(unit)
    return None


def _ends_in_unit(name: str) -> bool:
    """Return whether the slash in a name is that of a unit: "m/s", "rev/min", "Speed m/s"."""
    last = name.split()[-1]
    return is_unit(last.partition("/")[0]) and not _is_symbol_with_unit(last)


def _split_without_brackets(name: str) -> tuple[str, str | None]:
    """Split "Load, N", "Load in N" or "load_N" into name and unit."""
    for pattern in _UNITS_WITHOUT_BRACKETS:
        matched = pattern.fullmatch(name)
        if matched is not None and _is_measured_in(matched["bare"], matched["unit"]):
            return matched["bare"].rstrip(), matched["unit"]
    turning = _IN_RPM.fullmatch(name)
    return name, turning and turning["unit"]


def _is_measured_in(bare: str, unit: str) -> bool:
    """Return whether a word behind a name is a unit: "min" one of times alone, "C" one of temperatures."""
    if unit in ("C", "F"):
        return "temp" in bare.casefold()
    if unit not in _FEWEST_LETTERS:
        return False
    return _OF_TIME.fullmatch(bare) is not None if is_unit_of(unit, "time") else len(bare) >= _FEWEST_LETTERS[unit]


def _is_symbol_with_unit(name: str) -> bool:
    symbol, _, unit = name.partition("/")
    kind = _SYMBOLS.get(symbol.strip())
    return kind is not None and is_unit_of(unit.strip(), kind)


def meant_unit(written: str) -> str | None:
    """Return a unit; none of nothing, and of a lone µ: a symbol of friction or a micrometer, but no atomic mass."""
    return None if written in ("", *_LONE_PREFIXES) else written


def count_in(text: str) -> int | None:
    """Read a number of samples or steps; none where the text is no such number, or of more digits than a count has."""
    return int(text) if _COUNT.fullmatch(text) else None


def bare_name(name: str) -> str:
    """Strip the unit off a column's name, or the form of a clock: "Depth [um]" is "Depth"."""
    bare = split_name(name)[0]
    return _CLOCK_FORM.sub("", bare.translate(_WIDE_BRACKETS)).rstrip() or bare


def is_named_in_minutes(name: str) -> bool:
    """Return whether a name states that times are in minutes and seconds: "Time (mm:ss)"."""
    form = _CLOCK_FORM.search(name.translate(_WIDE_BRACKETS))
    return form is not None and "h" not in form[0].casefold()


def without_brackets(cell: str) -> str:
    """Strip brackets off a unit: "[um]" is "um"."""
    return cell[1:-1].strip() if cell[:1] + cell[-1:] in ("[]", "()") else cell


def is_unit_row(cells: Iterable[str]) -> bool:
    """Return whether every filled field of a row is a unit."""
    units = [without_brackets(cell) for cell in cells if cell]
    if units and units[0].lower() in _UNIT_ROW_LABELS:
        del units[0]
    if any(map(_is_symbol_with_unit, units)):
        return False
    return not all(map(INTEGER.fullmatch, units)) and all(map(is_unit, units))


_STRONG_SEPARATORS = ("\t", ";", "|")
_SEPARATORS = (*_STRONG_SEPARATORS, ",", BLANKS)
_NUMBER = {
    signs: re.compile(rf"[+-]?(?:{digits})(?:[eE][+-]?\d+)?", re.ASCII)
    for signs, digits in {
        ".": r"\d+(?:\.\d*)?|\.\d+",
        ",": r"\d+(?:,\d*)?",
        ".,": r"\d+(?:[.,]\d*)?|\.\d+",
    }.items()
}
_QUOTED_COMMA = re.compile(r'"\s*[+-]?\d+,\d+(?:[eE][+-]?\d+)?\s*"', re.ASCII)
_NAME_AMONG_BLANKS = re.compile(r"\S+(?:[ \t]*(?:\[[^\[\]]*\]|\([^()]*\))|[ \t]+/[ \t]+\S+)?")


@dataclass(frozen=True)
class Table:
    """Table that results from splitting the sample at one separator."""

    separator: str
    signs: str
    """Decimal separators that numbers may have."""
    rows: list[Row]
    body: int
    """Index of the first row below the header."""
    width: int
    numeric: frozenset[int]
    """Columns of numbers."""
    textual: frozenset[int]
    """Columns of something else; those in neither set are empty."""
    top: int = -1
    """Index of the row of names, -1 where there is none."""
    names: tuple[str, ...] = ()
    units: tuple[str, ...] = ()
    fits: bool = False
    """Whether there are as many names as columns."""

    @cached_property
    def numbers(self) -> list[tuple[int, int, str]]:
        """Line, column and text of each number in the columns of numbers."""
        return [
            (row.line, column, cell)
            for row in self.rows[self.body :]
            for column, cell in enumerate(row.cells)
            if column in self.numeric and is_number(cell, self.signs)
        ]

    def has_sample(self, row: Row) -> bool:
        """Return whether a row has numbers, and something else only in columns of something else."""
        if len(row.cells) != self.width or not count_numbers(row, self.signs):
            return False
        cells = [cell for column, cell in enumerate(row.cells) if column not in self.textual]
        return all(is_gap(cell) or is_number(cell, self.signs) for cell in cells)

    @property
    def coverage(self) -> float:
        """Share of the body's characters that stand in numbers."""
        cells = [cell for row in self.rows[self.body :] for cell in row.cells if not is_gap(cell)]
        return sum(len(cell) for cell in cells if is_number(cell, self.signs)) / max(1, sum(map(len, cells)))

    @property
    def regularity(self) -> float:
        """Share of the body's rows that have as many fields as the header."""
        body = self.rows[self.body :]
        return sum(len(trimmed(self.names)) <= len(row.cells) <= self.width for row in body) / len(body)


@lru_cache(maxsize=1 << 12)  # a sample's fields are asked about again and again
def is_number(cell: str, signs: str) -> bool:
    """Return whether a field is a plain number with one of the decimal separators."""
    return _NUMBER[signs].fullmatch(cell) is not None


def count_numbers(row: Row, signs: str) -> int:
    """Count the fields of a row that are numbers."""
    return sum(is_number(cell, signs) for cell in row.cells)


def _looks_like_names(row: Row) -> bool:
    cells = [cell for cell in row.cells if cell]
    lettered = sum(any(map(str.isalpha, cell)) for cell in cells if not is_gap(cell))
    return len(row.cells) > 1 and 2 * lettered >= max(1, len(cells))


def find_table(text: Text, hints: Hints) -> tuple[Table, list[str]]:
    """Find the table in the head of a text, and the lines looked at; ``ReaderError`` where there is none."""
    lines = sample_lines(text)
    quoted = has_quoted_commas(lines)
    wanted = _wanted(text, hints, quoted=quoted)
    written = [separator for separator in wanted if any(sign in line for line in lines for sign in _written(separator))]
    tables = [
        table
        for separator in written or wanted
        if (table := _table(lines, separator, decimal_signs(separator, hints, quoted=quoted)))
    ]
    table = _chosen([table for table in tables if table.top >= 0 and max(table.width, len(table.names)) > 1])
    if table is None:
        raise ReaderError(_why_none(text, hints, lines, tables))
    if max(len(table.names), table.width) > MOST_COLUMNS:
        found = max(len(row.cells) for row in sampled_rows(lines, table.separator))
        raise ReaderError(
            f"{text.name}, line {table.rows[table.top].line}: found {found} columns; expected at most {MOST_COLUMNS}; "
            "check that the file is a table with one row per sample"
        )
    return table, lines


def has_quoted_commas(lines: list[str]) -> bool:
    """Return whether numbers with a comma stand in quotation marks, so that commas may separate as well."""
    return any(map(_QUOTED_COMMA.search, lines))


def _wanted(text: Text, hints: Hints, *, quoted: bool) -> tuple[str, ...]:
    """Name the separators to try."""
    separator = hints.separator
    if separator is None:
        return tuple(each for each in _SEPARATORS if each != "," or hints.decimal != "," or quoted)
    if len(separator) != 1 or not separator.isascii() or separator.isalnum() or separator in '"+-.\r\n\0':
        raise ReaderError(
            f"{text.name}: found the separator {separator!r} in run.toml; expected one character such as "
            '";" or "\\t", or " " for whitespace; correct the separator'
        )
    if separator == hints.decimal and not quoted:
        raise ReaderError(
            f"{text.name}: found {separator!r} as column and as decimal separator in run.toml, and no number in "
            "quotation marks; expected two different characters; correct one of them"
        )
    return (separator,)


def _written(separator: str) -> str:
    """Return the characters of which any may stand for a separator."""
    return " \t" if separator == BLANKS else separator


def decimal_signs(separator: str, hints: Hints, *, quoted: bool) -> str:
    """Return the decimal separators that numbers may have."""
    return hints.decimal or ("." if separator == "," and not quoted else ".,")


def _table(lines: list[str], separator: str, signs: str) -> Table | None:
    """Find the table that a separator makes of the sample, where it makes one."""
    rows = [Row(row.line, row.cells[: MOST_COLUMNS + 1]) for row in sampled_rows(lines, separator)]
    counts = [count_numbers(row, signs) for row in rows]
    last = max((index for index, count in enumerate(counts) if count), default=-1)
    named = [index for index in range(last) if not counts[index] and _looks_like_names(rows[index])]
    # Below the last row that could be names, rows with numbers are samples for certain.
    below = range(max(named, default=-1) + 1, last + 1)
    certain = [rows[index] for index in below if counts[index]]
    if certain and is_unit_row(certain[0].cells):  # the unit 1 looks like a number
        del certain[0]
    if not certain:
        return None
    width = _usual_width(certain, signs)
    certain = [row for row in certain if len(row.cells) == width]
    columns = [[row.cells[column] for row in certain] for column in range(width)]
    numeric = frozenset(column for column, cells in enumerate(columns) if _is_numeric(cells, signs))
    filled = frozenset(column for column, cells in enumerate(columns) if not all(map(is_gap, cells)))
    table = Table(separator, signs, rows, rows.index(certain[0]), width, numeric, filled - numeric)
    table = replace(table, body=next((i for i, row in enumerate(rows) if table.has_sample(row)), table.body))
    return _with_header(table, lines, [index for index in named if index < table.body][-20:])


def _usual_width(rows: list[Row], signs: str) -> int:
    weights: Counter[int] = Counter()
    for row in rows:
        weights[len(row.cells)] += count_numbers(row, signs)
    return max(weights, key=lambda width: (weights[width], width))


def _is_numeric(cells: list[str], signs: str) -> bool:
    numbers = sum(is_number(cell, signs) for cell in cells)
    return 2 * numbers > sum(not is_gap(cell) for cell in cells)


def _with_header(table: Table, lines: list[str], named: list[int]) -> Table:
    """Add names and units from the rows above the numbers; ``named`` are those that could be names."""
    filled = 1 + max(table.numeric | table.textual)
    split = {index: _header_cells(table, lines, index) for index in named}
    enough = [i for i in named if filled <= len(split[i]) and filled <= 2 * sum(map(bool, split[i]))]
    if not named:
        return _with_numbered_names(table)
    top = max(enough or named)
    units, body = _below_names(table, top)
    if not units and top - 1 in enough and is_unit_row(split[top]):
        units, top = split[top], top - 1
    elif not units and top > 0 and filled <= len(table.rows[top - 1].cells):
        above = table.rows[top - 1].cells
        units = above if is_unit_row(above) else []
    names = trimmed(split[top])
    padded = [len(row.cells) for row in table.rows[body:] if not any(row.cells[len(names) :])]
    return replace(
        table,
        top=top,
        body=body,
        names=tuple(split[top]),
        units=tuple(units),
        width=max(table.width, len(names), *padded, 0),
        fits=top in enough and len(names) <= table.width,
    )


def _below_names(table: Table, top: int) -> tuple[list[str], int]:
    """Find a row of units and the first sample between the names and what is a sample for certain."""
    units: list[str] = []
    for index in range(top + 1, table.body):
        row = table.rows[index]
        if not units and is_unit_row(row.cells):
            units = row.cells
        elif count_numbers(row, table.signs) or (len(row.cells) > 1 and all(map(is_gap, row.cells))):
            return units, index
    return units, table.body


def _with_numbered_names(table: Table) -> Table:
    """Take the row above the numbers as names although it holds numbers, unless it holds nothing else."""
    above = table.rows[table.body - 1].cells if table.body else []
    if len(above) != table.width or all(is_gap(cell) or is_number(cell, table.signs) for cell in above):
        return table
    return replace(table, names=tuple(above), top=table.body - 1, fits=True)


def _header_cells(table: Table, lines: list[str], index: int) -> list[str]:
    """Split a header row; between blanks, a unit belongs to the name before it."""
    row = table.rows[index]
    if table.separator != BLANKS:
        cells = [" ".join(filter(None, map(str.strip, re.split(r"[\r\n]+", cell)))) for cell in row.cells]
        return [cells[0].removeprefix("#").strip() or cells[0], *cells[1:]]
    line = lines[row.line - 1].strip(" \t\r\n")
    for text in (line, line.removeprefix("#").strip(" \t")):
        for cells in (text.split(), _NAME_AMONG_BLANKS.findall(text), re.split(r" {2,}|\t+", text)):
            if len(cells) == table.width:
                return cells
    return row.cells


def _chosen(tables: list[Table]) -> Table | None:
    """Choose among separators: the stronger ones first, then by how much stands in numbers."""

    def rank(table: Table) -> tuple[bool, bool, bool, float]:
        return table.fits, table.regularity >= 0.5, table.separator in _STRONG_SEPARATORS, table.coverage

    return max(tables, key=rank, default=None)


def _why_none(text: Text, hints: Hints, lines: list[str], tables: list[Table]) -> str:
    """Report what is missing in a file without a table."""
    number, line = next(((n, line.strip()) for n, line in enumerate(lines, 1) if not line.isspace()), (1, ""))
    where = f"{text.name}, line {number}"
    if not tables and (not hints.separator or any(hints.separator in line for line in lines)):
        found = line if len(line) <= 40 else f"{line[:39]}…"
        below = "below" if len(lines) < SAMPLE_LINES else f"in the first {SAMPLE_LINES} lines"
        return (
            f"{where}: found {found!r}, but no data row {below}; expected a header row and data rows; "
            "export the file again with its data"
        )
    if any(table.width > 1 for table in tables):
        table = max(tables, key=lambda table: (table.width > 1, table.coverage))
        where = f"{text.name}, line {table.rows[table.body].line}"
        return (
            f"{where}: found data rows without a header row; expected column names such as 'Time [s]', 'Depth [um]' "
            "with the same separators; add a header row to a copy of the file, or list the column names in a reader "
            "description (`tribopipe help readers`)"
        )
    under = f"with the separator {hints.separator!r}" if hints.separator else "with any known separator"
    return (
        f"{where}: found a single column {under}; expected at least two columns, one of them time or sliding distance; "
        "specify separator and decimal in run.toml"
    )
