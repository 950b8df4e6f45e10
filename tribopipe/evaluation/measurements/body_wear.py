"""What each body has lost, by each way of measuring it, whatever the contact; of several ways the surest is taken."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Literal, NamedTuple, Protocol

from tribopipe.documents.quantity import Quantity
from tribopipe.evaluation.measurements.readings import VOLUMES, EndValueUsed
from tribopipe.evaluation.measurements.worn_tip import WornTip
from tribopipe.physics.pin_on_track import WornContact
from tribopipe.results.input_quantities import Source


class Pair(Protocol):
    """A reading on each of two bodies, which give the wear of both together."""

    @property
    def pin(self) -> EndValueUsed:
        """The reading on the body that stays in contact."""

    @property
    def disc(self) -> EndValueUsed:
        """The reading on the counterbody."""

    @property
    def tip(self) -> WornTip:
        """Tip of the body that stays in contact."""

    @property
    def tip_height(self) -> float:
        """Depth, m, at which all of the tip is worn away."""

    @property
    def beyond_tip(self) -> bool:
        """Whether both bodies would be worn by all of the tip or more, so that no contact has these readings."""

    def contact(self) -> WornContact:
        """Return the shape of both bodies by the readings as they are."""


@dataclass(frozen=True)
class BodyWear:
    """Depth and volume that one body has lost, by one way of measuring; None if it cannot be found so."""

    name: str
    source: Source
    depth: Quantity | None = None
    volume: Quantity | None = None
    assumed: frozenset[Literal["depth", "volume"]] = frozenset()
    """What of it follows from the shape of pin and groove, not from what was measured on the body alone."""
    pair: Pair | None = None
    """The readings that it follows from."""
    unseen_groove: float = 0.0
    """Relative standard uncertainty of the volume from a groove of the counterbody that nobody measured."""

    @property
    def hides_groove(self) -> bool:
        """Whether a disc has lost a volume along a track of unknown length, so that its groove has any depth."""
        lost = self.volume
        if self.name not in VOLUMES or self.depth is not None or lost is None or lost.value < 0:
            return False
        return bool(lost.value or lost.standard_uncertainty)


class WornBodies(NamedTuple):
    """Everything that was measured on the bodies at one time, as depth and volume."""

    bodies: Mapping[str, tuple[BodyWear, ...]]
    """Wear of each body, with its role as key."""
    notes: tuple[str, ...] = ()
    """What prevents it of a volume, and what is taken for granted."""


def surest(ways: Iterable[BodyWear], what: Literal["depth", "volume"]) -> BodyWear | None:
    """Return the way that gives a depth or volume with the least relative uncertainty, one that measures it first."""

    def rank(way: BodyWear) -> tuple[bool, float]:
        found = getattr(way, what)
        spread = found.u_or_zero
        return what in way.assumed, spread / abs(found.value) if found.value else math.inf

    return min((way for way in ways if getattr(way, what) is not None), key=rank, default=None)


def names_used(ways: Iterable[BodyWear]) -> list[str]:
    """Return the names of the measurements that depth and volume follow from: one, or two."""
    ways = tuple(ways)
    return list(dict.fromkeys(way.name for what in ("depth", "volume") if (way := surest(ways, what)) is not None))


class Contradiction(NamedTuple):
    """Two post-test measurements that give different wear of one body."""

    body: str
    what: Literal["depth", "volume"]
    one: BodyWear
    other: BodyWear
    deviation: float
    """Difference over its standard uncertainty."""


MeasuredQuantity = Literal["wear_volume", "wear_depth", "track_width"]


@dataclass(frozen=True)
class BodyMeasurement:
    """One thing measured on one body at one place of the test."""

    body: str
    """Role of the body."""
    what: MeasuredQuantity
    place: float
    """Progress along the test."""
    quantity: Quantity
    source: Source
    interruption: int | None = None
    """Number of the interruption it was measured in; None for the end."""
    by: str = ""
    """What a wear volume was calculated from, such as "mass_loss"; empty if it was measured itself."""

    @property
    def name(self) -> str:
        """Name of this input."""
        behind = "" if self.interruption is None else f"_at_interruption_{self.interruption + 1}"
        return f"{self.body}_{self.what}{behind}"
