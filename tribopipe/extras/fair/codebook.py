"""The codebook of a crate: every column of its tables and every number of its results in one table."""

import re
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from tribopipe.extras.fair.terms import UNITS
from tribopipe.views.csv_files import csv_lines

_HEAD = ("name", "unit", "UCUM", "QUDT", "meaning", "TriboDataFAIR")
_STANDARD_UNCERTAINTY = re.compile(r"\.standard_uncertainty$")


def codebook(described: Iterable[Mapping[str, Any]]) -> Iterator[bytes]:
    """Return as CSV what the quantities of a crate mean; each name stands there once."""
    rows: dict[tuple[str, str], list[str]] = {}
    for one in described:
        name, unit = str(one["propertyID"]), str(one.get("unitText", ""))
        if not _STANDARD_UNCERTAINTY.search(name):
            rows.setdefault((name, unit), [name, unit, *_beside(one, unit)])
    yield csv_lines([_HEAD, *(rows[key] for key in sorted(rows))])


def _beside(one: Mapping[str, Any], unit: str) -> Iterator[str]:
    known = UNITS.get(unit)
    yield (known and known.ucum) or ""
    yield str(one.get("unitCode", ""))
    yield " ".join(str(one.get("description", "")).split())
    yield str(one.get("identifier", ""))
