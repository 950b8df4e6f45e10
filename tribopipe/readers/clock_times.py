"""Times of day, such as 21:48:30 or 2025-11-03 21:48:30, as seconds since the first row."""

import re
from dataclasses import replace
from datetime import date

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.base.units import is_unit_of
from tribopipe.readers.reader import ReadColumn, ReadTable

_OF_DAY = r"(?P<h>\d{1,3}):(?P<min>[0-5]\d):(?P<s>[0-5]\d(?:[.,]\d+)?)"
OF_DAY = re.compile(_OF_DAY, re.ASCII)
"""Time of day without a date."""
_CLOCK = re.compile(rf"(?:(?P<date>\d{{4}}-\d\d-\d\d|\d\d?\.\d\d?\.\d{{4}})[ T])?{_OF_DAY}", re.ASCII)
_DAY = 86_400.0


def with_clock_times(table: ReadTable) -> ReadTable:
    """Turn columns of times of day into seconds since the first row, where no column has a unit of time."""
    if any(column.unit is not None and is_unit_of(column.unit, "time") for column in table.columns):
        return table
    read = {column.name: found for column in table.columns if (found := _seconds(column)) is not None}
    columns = tuple(
        replace(column, values=read[column.name], unit="s", first_bad=None) if column.name in read else column
        for column in table.columns
    )
    notes = [f"column {name!r}: times of day, read as seconds since the first row" for name in read]
    return replace(table, columns=columns, notes=(*table.notes, *notes))


def is_clock_time(text: str) -> bool:
    """Return whether a text is a time of day, with or without a date."""
    return _CLOCK.fullmatch(text.strip()) is not None


def _seconds(column: ReadColumn) -> Column | None:
    """Return the times of a column, s; none where a field is no time of day, or only some have a date."""
    # One look at the first field spares long columns of other texts.
    if column.values.dtype != object or column.unit or not is_clock_time(str(column.values[0])):
        return None
    found = [_CLOCK.fullmatch(str(field).strip()) for field in column.values]
    days = [_day(one["date"]) if one and one["date"] else None for one in found]
    times = np.array([of_day(one) if one else np.nan for one in found])
    if len({day is None for day in days}) > 1:
        return None
    if days[0] is None:
        times = past_midnight(times)
    else:
        times += _DAY * np.array(days, dtype=float)
    return None if np.any(np.isnan(times)) else np.asarray(times - times[0])


def past_midnight(times: Column) -> Column:
    """Let times of day, s, go on after midnight, where they fall by nearly a day."""
    return times + _DAY * np.concatenate([[0], np.cumsum(np.diff(times) < -_DAY / 2)])


def of_day(found: re.Match[str]) -> float:
    """Return a time of day, s."""
    return 3600 * int(found["h"]) + 60 * int(found["min"]) + float(found["s"].replace(",", "."))


def _day(written: str) -> float:
    """Return the number of a day; NaN of one that is not in the calendar."""
    parts = [int(part) for part in re.split(r"[-.]", written)]
    year, month, day = parts if "-" in written else reversed(parts)
    try:
        return float(date(year, month, day).toordinal())
    except ValueError:
        return float("nan")
