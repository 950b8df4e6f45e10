"""Times of day in a time column, as loggers write them."""

import numpy as np
import pytest

from tribopipe.readers.delimited import DelimitedReader
from tribopipe.readers.headed_tables import moment
from tribopipe.readers.reader import Hints
from tribopipe.results.run import SourceFile


def columns(text: str):
    table = DelimitedReader().read(SourceFile("log.csv", text.encode()), Hints())
    return {column.name: column for column in table.columns}, table.notes


@pytest.mark.parametrize(
    ("times", "seconds"),
    [
        (("21:48:30", "21:48:31", "21:48:33"), (0, 1, 3)),
        (("23:59:58", "23:59:59,5", "0:00:01"), (0, 1.5, 3)),
        (("0:00:00.0", "0:00:00.5", "100:00:00.0"), (0, 0.5, 360_000)),
        (("2025-02-28 23:59:59", "2025-03-01 00:00:00", "2025-03-02T00:00:00"), (0, 1, 86_401)),
        (("28.02.2024 23:59:59", "29.02.2024 00:00:00", "1.3.2024 00:00:00"), (0, 1, 86_401)),
        (("11:59:58 AM", "12:00:00 PM", "1:00:00 PM"), (0, 2, 3602)),
        (("11:59:58 p.m.", "12:00:00 a.m.", "12:00:01 a.m."), (0, 2, 3)),
        (("2025/03/04 23:59:59", "2025/03/05 00:00:00"), (0, 1)),
        (("03/31/2025 11:59:59 PM", "04/01/2025 12:00:00 AM"), (0, 1)),
        (("31/03/2025 23:59:59", "01/04/2025 00:00:00"), (0, 1)),
        (("03/04/2025 9:00:00", "03/04/2025 9:00:01"), (0, 1)),
        (("2025-03-04T23:59:59.500Z", "2025-03-05T00:00:00.250Z"), (0, 0.75)),
        (("2025-10-26T02:59:59+02:00", "2025-10-26T02:00:00+01:00"), (0, 1)),
        (("10:00:00:000", "10:00:00:250", "10:00:01:000"), (0, 0.25, 1)),
    ],
)
def test_times_of_day_are_seconds_since_the_first_row(times, seconds):
    found, notes = columns("Uhrzeit;Reibwert\n" + "".join(f"{time};0.5\n" for time in times))
    np.testing.assert_allclose(found["Uhrzeit"].values, seconds)
    assert found["Uhrzeit"].unit == "s"
    assert notes == ("column 'Uhrzeit': times of day, read as seconds since the first row",)


@pytest.mark.parametrize(
    "times",
    [
        ("21:48:30", "off", "21:48:32"),
        ("21:48:30", "2025-03-01 21:48:31", "21:48:32"),
        ("30.02.2024 1:00:00",) * 3,
        ("03/04/2025 23:59:59", "03/05/2025 0:00:00"),  # the next day, or the next month
        ("11:59:58 AM", "12:00:00"),
        ("13:00:00 AM",) * 2,
        ("21:48", "21:49"),  # hours and minutes, or minutes and seconds
    ],
)
def test_other_texts_stay_texts(times):
    found, _ = columns("Time;mu\n" + "".join(f"{time};0.5\n" for time in times))
    assert found["Time"].values.tolist() == list(times)
    assert found["Time"].unit is None


def test_a_name_tells_minutes_and_seconds_from_hours_and_minutes():
    found, _ = columns("Time (mm:ss);mu\n59:59.5;0.5\n60:00;0.5\n121:30;0.5\n")
    np.testing.assert_allclose(found["Time (mm:ss)"].values, (0, 0.5, 3690.5))
    found, _ = columns("Time (hh:mm:ss);mu\n59:59;0.5\n60:00;0.5\n")
    assert found["Time (hh:mm:ss)"].unit is None


def test_a_column_with_a_unit_of_time_is_the_time():
    found, _ = columns("Clock;Time [s];mu\n21:48:30;0;0.5\n21:48:31;1;0.5\n")
    assert found["Clock"].unit is None


@pytest.mark.parametrize(
    ("written", "told"),
    [
        ("2024-02-29 9:05:07", "2024-02-29T09:05:07"),
        ("0999-01-01 10:00", None),
        ("2024-02-30 10:00", None),
        ("2023-02-29 10:00", None),
        ("2024-04-31 10:00", None),
        ("2024-04-30 24:00", None),
    ],
)
def test_a_start_is_a_day_of_the_calendar(written, told):
    assert moment(written) == told
