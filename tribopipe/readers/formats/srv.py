"""Optimol SRV: what the columns of its numeric sheet mean; the workbook itself is read as any other.

    Tick | Time | Temperature 1 | … | Frequency | … | Stroke sliding speed average value current | … | Load | … | Stroke
         | [s]  | [°C]          | … | [Hz]      | … | [m/s]                                      | … | [N]  | … | [mm]

* Names stand in row 1, units in brackets in row 2, one row of numbers per second below.
* Friction stands there in several definitions (effective value, integral, peak): none is taken by itself.
* The sliding speed is the mean over a stroke, 2·stroke·frequency.
"""

from dataclasses import replace

from tribopipe.base.units import is_unit_of
from tribopipe.documents.signals import SignalName
from tribopipe.readers.headed_tables import bare_key
from tribopipe.readers.reader import ReadTable

_MARKS = frozenset({"oelpumptemperature", "strokeslidingspeedaveragevaluecurrent", "frictionabsoluteintegral"})
_SIGNALS: dict[str, tuple[SignalName, str]] = {
    "time": ("time", "time"),
    "temperature1": ("temperature", "temperature"),
    "load": ("normal_force", "force"),
    "strokeslidingspeedaveragevaluecurrent": ("sliding_speed", "speed"),
}
"""By name: the signal, and the kind of unit that it must have."""


def with_srv_meanings(table: ReadTable) -> ReadTable:
    """Report what the columns of an SRV mean; any other table stays as it is."""
    if len(_MARKS & {bare_key(column.name) for column in table.columns}) < 2:
        return table
    columns = []
    for column in table.columns:
        signal, kind = _SIGNALS.get(bare_key(column.name), (None, ""))
        fits = signal is not None and column.unit is not None and is_unit_of(column.unit, kind)
        columns.append(replace(column, signal=signal) if fits else column)
    note = "the columns are those of an Optimol SRV; its sliding speed is the mean over a stroke"
    return replace(table, columns=tuple(columns), notes=(*table.notes, note))
