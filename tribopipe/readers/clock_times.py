"""Times of day, such as 21:48:30, 9:48:30 PM or 2025-11-03T21:48:30+01:00, as seconds since the first row."""

import re
from collections.abc import Sequence
from dataclasses import replace
from datetime import date

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.base.units import is_unit_of
from tribopipe.readers.reader import ReadColumn, ReadTable
from tribopipe.readers.tables import is_named_in_minutes

_OF_DAY = r"(?P<h>\d{1,3}):(?P<min>[0-5]\d):(?P<s>[0-5]\d(?:[.,]\d+|:\d{3})?)"
OF_DAY = re.compile(_OF_DAY, re.ASCII)
"""Time of day without a date; three digits after a third colon are milliseconds."""
_CLOCK = re.compile(
    r"(?:(?P<date>\d{4}(?P<sign>[-/.])\d\d?(?P=sign)\d\d?|\d\d?([./-])\d\d?\3\d{4})(?:[ T]|, ))?"
    rf"{_OF_DAY}(?: ?(?P<half>[AaPp])\.?[Mm]\.?)?(?P<zone>Z|[+-]\d\d:?\d\d)?",
    re.ASCII,
)
_MINUTES = re.compile(r"(?P<min>\d{1,4}):(?P<s>[0-5]\d(?:[.,]\d+)?)", re.ASCII)
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
    if column.values.dtype != object or column.unit:
        return None
    # One look at the first field spares long columns of other texts.
    if not is_clock_time(str(column.values[0])):
        return _minutes(column) if is_named_in_minutes(column.name) else None
    found = [_CLOCK.fullmatch(str(field).strip()) for field in column.values]
    whole = [one for one in found if one is not None]
    # A date in some rows alone, or a clock of 12 hours in some, is of no one form.
    if len(whole) < len(found) or len({(one["date"] is None, one["half"] is None) for one in whole}) > 1:
        return None
    times = np.array([of_day(one) - _ahead(one["zone"]) for one in whole])
    if whole[0]["date"] is None:
        times = past_midnight(times)
    else:
        days = _days([one["date"] for one in whole])
        if days is None:
            return None
        times += _DAY * days
    return None if np.any(np.isnan(times)) else np.asarray(times - times[0])


def _minutes(column: ReadColumn) -> Column | None:
    """Return times written in minutes and seconds, s; none where a field is no such time."""
    found = [_MINUTES.fullmatch(str(field).strip()) for field in column.values]
    times = np.array([60 * int(one["min"]) + _number(one["s"]) if one else np.nan for one in found])
    return None if np.any(np.isnan(times)) else np.asarray(times - times[0])


def past_midnight(times: Column) -> Column:
    """Let times of day, s, go on after midnight, where they fall by nearly a day."""
    return times + _DAY * np.concatenate([[0], np.cumsum(np.diff(times) < -_DAY / 2)])


def of_day(found: re.Match[str]) -> float:
    """Return a time of day, s; NaN where a clock of 12 hours shows another hour."""
    hours, half = int(found["h"]), found.groupdict().get("half")
    if half and not 1 <= hours <= 12:
        return float("nan")
    hours = hours % 12 + (12 if half in "Pp" else 0) if half else hours
    return 3600 * hours + 60 * int(found["min"]) + _number(found["s"])


def _number(seconds: str) -> float:
    return float(seconds.replace(",", ".").replace(":", "."))


def _ahead(zone: str | None) -> float:
    """Return how far the clock of a zone is ahead of UTC, s, so that summer time ends without a step."""
    if zone in (None, "Z", "z"):
        return 0.0
    hours, minutes = int(zone[1:3]), int(zone[-2:])
    return (3600 * hours + 60 * minutes) * (-1 if zone[0] == "-" else 1)


def _days(written: Sequence[str]) -> Column | None:
    """Return the numbers of days; NaN of one that is not in the calendar, none where day and month may be either.

    Between points the day comes first. Between slashes, a number above 12 has to show the order, unless all dates are
    the same one.
    """
    parts = [[int(part) for part in re.split(r"[-./]", day)] for day in written]
    if re.match(r"\d{4}", written[0]):
        orders: list[tuple[int, int, int]] = [(0, 1, 2)]
    else:
        orders = [(2, 1, 0)] if "." in written[0] else [(2, 1, 0), (2, 0, 1)]
    read = [np.array([_day(*(part[place] for place in order)) for part in parts]) for order in orders]
    read = [days for days in read if not np.any(np.isnan(days))]
    agree = all(np.array_equal(days - days[0], read[0] - read[0][0]) for days in read)
    return read[0] if read and agree else None


def _day(year: int, month: int, day: int) -> float:
    """Return the number of a day; NaN of one that is not in the calendar."""
    try:
        return float(date(year, month, day).toordinal())
    except ValueError:
        return float("nan")
