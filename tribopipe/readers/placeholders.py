"""Placeholders: what instruments, spreadsheets and printf write where they have no number: OVL, ---, #N/A, 1.#INF."""

import re

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
