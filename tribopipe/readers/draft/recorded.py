"""What a recording shows of the conditions: proposed where nobody states them, compared with what is stated."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.base.units import is_rotational, is_unit_of, to_si
from tribopipe.readers.column_aliases import plain_name
from tribopipe.readers.draft.known_values import LOAD, Known, alike
from tribopipe.readers.export_files import Export
from tribopipe.readers.reader import ReadColumn

_SIGNALS = {
    "normal_force": (LOAD, "force"),
    "sliding_speed": ("conditions.sliding_speed", "speed"),
}
"""Key of run.toml and kind of quantity, by the signal; a temperature need not be that of the room."""
_NAMES = {
    "frequency": ("conditions.frequency", "frequency"),
    "stroke": ("conditions.stroke", "length"),
    "radius": ("conditions.track_radius", "length"),
    "trackradius": ("conditions.track_radius", "length"),
}
"""The same, by the name of a column that is no signal."""
_FEW_DIGITS = ".4g"
_STEADY, _MOST_ROWS_OFF = 0.1, 0.2
_CONTRADICTS = 0.2
"""From which difference on, relative to what is stated, a recording contradicts it."""


class Recorded(NamedTuple):
    """What a column shows of one condition."""

    key: str
    kind: str
    column: ReadColumn
    values: Column
    """Finite ones, in the column's unit."""
    where: str

    @property
    def value(self) -> str:
        """The median, as run.toml would hold it; weights are forces."""
        unit = self.column.unit or "1"
        median = float(np.median(np.abs(self.values)))
        if self.kind == "force" and is_unit_of(unit, "mass"):
            return f"{float(to_si(median, f'({unit})*g_0', 'force')):{_FEW_DIGITS}} N"
        return f"{median:{_FEW_DIGITS}} {unit}"

    @property
    def is_steady(self) -> bool:
        """Whether most values lie close to the median."""
        sizes = np.abs(self.values)
        off = np.abs(sizes - np.median(sizes)) > _STEADY * np.median(sizes)
        return float(np.mean(off)) <= _MOST_ROWS_OFF


def recorded(exports: Sequence[Export], step: tuple[str, int] | None = None) -> Iterator[Recorded]:
    """Give what was recorded of the conditions, in all rows or in those of a step: its column, and its number."""
    for export in exports if step is None else exports[:1]:
        numbers = next((one.values for one in export.table.columns if step and one.name == step[0]), None)
        rows = slice(None) if numbers is None or step is None else np.asarray(numbers, dtype=float) == step[1]
        for key, kind, column in _columns(export):
            values = np.asarray(column.values[rows], dtype=float)
            values = values[np.isfinite(values)]
            if len(values) and np.any(values):
                yield Recorded(key, kind, column, values, "" if step is None else f" in step {step[1]}")


def _columns(export: Export) -> Iterator[tuple[str, str, ReadColumn]]:
    turning = rotational_speeds(export)
    for column in export.table.columns:
        meaning = export.meanings.get(column.name)
        known = _SIGNALS.get(meaning.signal) if meaning and not meaning.lacks else _NAMES.get(plain_name(column))
        if column.first_bad is not None or column.unit is None or column.values.dtype.kind != "f":
            continue
        if turning == [column]:
            yield "conditions.rotational_speed", "rotational speed", column
        elif known and (is_unit_of(column.unit, known[1]) or (known[1] == "force" and is_unit_of(column.unit, "mass"))):
            yield *known, column


def rotational_speeds(export: Export) -> list[ReadColumn]:
    """Return the columns of a rotational speed, such as "Rotary.Velocity (rpm)"."""
    return [
        column
        for column in export.table.columns
        if column.first_bad is None and column.unit is not None and is_rotational(column.unit)
    ]


def propose_recorded(known: Known, exports: Sequence[Export], step: tuple[str, int] | None = None) -> None:
    """Offer what was recorded of the conditions, where nobody has stated them, and note what it contradicts.

    What a header states against the recording is not taken any more; the word of a person or a template stays.
    """
    for one in recorded(exports, step):
        source = f"median of {one.column.name!r}{one.where}"
        stated = known.given.get(one.key)
        if stated is not None and one.is_steady and not alike(one.key, one.value, stated.value, _CONTRADICTS):
            known.object(one.key, f"a {source} of {one.value}")
            if one.key in known.of_headers:
                known.doubt(one.key, stated.value, f"{stated.origin}, which the recording contradicts")
                del known.given[one.key]
        if one.key in known.given or not known.fits(one.key, one.value):
            continue
        if one.is_steady:
            known.offer(one.key, one.value, source)
        else:
            known.doubt(one.key, one.value, f"{source}, which is not steady")
