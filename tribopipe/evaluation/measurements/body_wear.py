"""What one body has lost, by each way of measuring; which is taken, and which contradict each other."""

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import combinations
from typing import Literal, NamedTuple

from tribopipe.contacts.inputs import Source
from tribopipe.documents.quantity import Quantity
from tribopipe.evaluation.measurements.worn_pair import Wear, WornPair, difference

_TOO_FAR = 3.0
"""Standard uncertainties."""
_WEAR: dict[tuple[str, str], Wear] = {
    ("pin", "depth"): "pin_depth",
    ("disc", "depth"): "disc_depth",
    ("disc", "volume"): "disc_volume",
}
_ROUNDING = 1e-6
"""Share of a depth or volume that readings stated as exact may differ by."""


@dataclass(frozen=True)
class BodyWear:
    """Depth and volume that one body has lost, by one way of measuring; none where it cannot be found so."""

    name: str
    source: Source
    depth: Quantity | None = None
    volume: Quantity | None = None
    assumed: frozenset[Literal["depth", "volume"]] = frozenset()
    """What of it follows from the shape of pin and groove, not from what was measured on the body alone."""
    pair: WornPair | None = None
    """The readings that it follows from."""


class WornBodies(NamedTuple):
    """Everything that was measured on the bodies at one time, as depth and volume."""

    bodies: Mapping[str, tuple[BodyWear, ...]]
    """By the role of the body."""
    notes: tuple[str, ...] = ()
    """What prevents it of a volume, and what is taken for granted."""


def surest(ways: Iterable[BodyWear], what: Literal["depth", "volume"]) -> BodyWear | None:
    """Return the way that gives a depth or volume with the least relative uncertainty, one that measures it first."""

    def rank(way: BodyWear) -> tuple[bool, float]:
        found = getattr(way, what)
        spread = found.standard_uncertainty or 0.0
        return what in way.assumed, spread / abs(found.value) if found.value else math.inf

    return min((way for way in ways if getattr(way, what) is not None), key=rank, default=None)


class Contradiction(NamedTuple):
    """Two post-test measurements that give different wear of one body."""

    what: Literal["depth", "volume"]
    one: BodyWear
    other: BodyWear
    deviation: float
    """Difference over its standard uncertainty."""


def contradictions(
    body: Literal["pin", "disc"], ways: Iterable[BodyWear], what: Literal["depth", "volume"]
) -> Iterator[Contradiction]:
    """Yield each two ways whose depths, or volumes, differ by more than three standard uncertainties of the difference.

    What both depend on, such as the radius of the tip, counts once.
    """
    for one, other in combinations((way for way in ways if getattr(way, what) is not None), 2):
        gap = _gap(body, one, other, what)
        spread = gap.standard_uncertainty or 0.0
        least = _ROUNDING * abs(getattr(one, what).value)
        if abs(gap.value) > max(_TOO_FAR * spread, least):
            yield Contradiction(what, one, other, abs(gap.value) / spread if spread else math.inf)


def _gap(body: Literal["pin", "disc"], one: BodyWear, other: BodyWear, what: Literal["depth", "volume"]) -> Quantity:
    if one.pair is not None and other.pair is not None:
        return difference(one.pair, other.pair, _WEAR[body, what])
    first, second = getattr(one, what), getattr(other, what)
    spread = math.hypot(first.standard_uncertainty or 0.0, second.standard_uncertainty or 0.0)
    return Quantity(value=first.value - second.value, unit=first.unit, standard_uncertainty=spread)
