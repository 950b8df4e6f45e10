"""What is stated once of a run that goes on, because somebody should look."""

from typing import Literal

from tribopipe.documents.quantity import Quantity
from tribopipe.documents.record import Record

AlarmKind = Literal["law", "sensor", "load", "friction", "stalled", "replaced"]


class Alarm(Record):
    """Something amiss with a run that goes on."""

    kind: AlarmKind
    """What it is about; of each kind the first one is given."""
    sliding_distance: Quantity | None = None
    """Where it was noticed."""
    message: str
    """One sentence on what was found, and what to look at."""

    def __str__(self) -> str:
        return self.message


def alarm_at(kind: AlarmKind, distance: float, message: str) -> Alarm:
    """Return an alarm at a sliding distance, m."""
    return Alarm(kind=kind, sliding_distance=Quantity(value=distance, unit="m"), message=message)
