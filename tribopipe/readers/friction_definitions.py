"""Several definitions of the friction coefficient in one file: an effective value, an integral, a peak."""

import re
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from tribopipe.readers.reader import ReadColumn

_NAMES = re.compile(r"\bcof\b|friction|\bmu\b|\bµ\b|reibwert|reibzahl", re.IGNORECASE)
_UNITS = (None, "1", "-", "", "%", "1/µm", "1/um")
_LEAST, _LARGEST = 1e-3, 3.0
"""Between which the median of a friction coefficient lies."""


class Definition(NamedTuple):
    """A column that may be the friction coefficient."""

    column: str
    median: float


def friction_definitions(columns: Sequence[ReadColumn]) -> list[Definition]:
    """Return the columns that may be the friction coefficient by name, unit and size, where there are several."""
    found = []
    for column in columns:
        if column.first_bad is None and column.unit in _UNITS and _NAMES.search(column.name):
            known = column.values[np.isfinite(column.values)]
            median = float(np.median(np.abs(known))) if len(known) else 0.0
            if _LEAST <= median <= _LARGEST:
                found.append(Definition(column.name, median))
    return found if len(found) > 1 else []


def definitions_note(columns: Sequence[ReadColumn], taken: str | None) -> str | None:
    """Report which columns define friction differently, and which is taken; nothing where there is one at most."""
    found = friction_definitions(columns)
    if not found:
        return None
    names = [f"{one.column!r} (median {one.median:.3g})" for one in found]
    listed = f"{', '.join(names[:-1])} and {names[-1]}"
    choice = "none is used" if taken is None else f"{taken!r} is used"
    return (
        f"{len(found)} definitions of friction, {listed}; {choice}: map the one that you report to "
        "friction_coefficient under [signals.columns]"
    )
