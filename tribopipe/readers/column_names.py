"""Names and units as headers of columns write them."""

import re
from collections.abc import Iterable

from tribopipe.base.units import is_unit

INTEGER = re.compile(r"[+-]?\d+", re.ASCII)
_COUNT = re.compile(r"\d{1,18}", re.ASCII)
_UNIT_IN_WORD = re.compile(r"(?P<bare>[^\s/]+)/(?P<unit>\S+)")
_UNITS_IN_NAMES = (
    re.compile(r"(?P<bare>.+)\[(?P<unit>[^\[\]]*)\]"),
    re.compile(r"(?P<bare>.+)\((?P<unit>(?:[^()]|\([^()]*\))*)\)"),
    re.compile(r"(?P<bare>.+)\s/\s+(?P<unit>\S+)"),
    _UNIT_IN_WORD,
)
_LONGEST_NAME = 1000
_WIDE_BRACKETS = str.maketrans("（）［］【】", "()[][]")
"""As Chinese and Japanese programs write them."""
_UNIT_ROW_LABELS = ("unit", "units", "einheit", "einheiten", "単位", "单位")


def split_name(name: str) -> tuple[str, str | None]:
    """Split a column's name as a header writes it into name and unit; what is longer than any name has none."""
    if len(name) > _LONGEST_NAME:
        return name, None
    name = name.translate(_WIDE_BRACKETS)
    for pattern in _UNITS_IN_NAMES:
        matched = pattern.fullmatch(name)
        if matched is None:
            continue
        bare, unit = matched["bare"].rstrip().rstrip(" /"), matched["unit"].strip()
        # "m/s" and "rev/min" alone are units, not names with one.
        if bare and is_unit(unit) and not (pattern is _UNIT_IN_WORD and is_unit(bare)):
            return bare, unit or None
    return name, None


def count_in(text: str) -> int | None:
    """Read a number of samples or steps; none where the text is no such number, or of more digits than a count has."""
    return int(text) if _COUNT.fullmatch(text) else None


def bare_name(name: str) -> str:
    """Strip the unit off a column's name: "Depth [um]" is "Depth"."""
    return split_name(name)[0]


def without_brackets(cell: str) -> str:
    """Strip brackets off a unit: "[um]" is "um"."""
    return cell[1:-1].strip() if cell[:1] + cell[-1:] in ("[]", "()") else cell


def is_unit_row(cells: Iterable[str]) -> bool:
    """Return whether every filled field of a row is a unit."""
    units = [without_brackets(cell) for cell in cells if cell]
    if units and units[0].lower() in _UNIT_ROW_LABELS:
        del units[0]
    return not all(map(INTEGER.fullmatch, units)) and all(map(is_unit, units))
