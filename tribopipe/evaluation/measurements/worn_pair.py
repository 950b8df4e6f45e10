"""What each body has lost, by each way of measuring it; pin and track as one worn pair.

A reading on the pin and one on the track give the wear of both. Of several ways the surest is taken; those that
contradict each other are found with what they have in common counted once.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from itertools import combinations
from typing import Literal, NamedTuple

import numpy as np

from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import DefaultUncertainty
from tribopipe.evaluation.measurements.body_wear import BodyWear, Contradiction, WornBodies
from tribopipe.evaluation.measurements.readings import (
    APPROACHES,
    AREA,
    BY_SIGNAL,
    VOLUMES,
    WIDTHS,
    EndValueUsed,
    combined,
)
from tribopipe.evaluation.measurements.sliding_distance import path_length
from tribopipe.evaluation.measurements.worn_tip import WornTip
from tribopipe.physics.geometry import circle_volume
from tribopipe.physics.pin_on_track import SHAPE_LEAST, SHAPE_MOST, OnTrack, WornContact, power_root
from tribopipe.physics.stroke_ends import EXTENSION_UNCERTAINTY, Stroke
from tribopipe.results.run import RawRun

UNKNOWN_SHARE = EndValueUsed(
    "pin_share", Quantity(value=0.5, unit="1", standard_uncertainty=1 / math.sqrt(12)), "default"
)
"""Share of the pin in the wear depth of both where it is unknown: anything from 0 to 1."""
_UNWORN_PIN = EndValueUsed("pin_wear_depth", Quantity(value=0.0, unit="m", standard_uncertainty=0.0), "default")
_SHAPE = (SHAPE_MOST - SHAPE_LEAST) / math.sqrt(3) / (SHAPE_MOST + SHAPE_LEAST)
"""Relative standard uncertainty of a real groove's shape: known no better than those of rigid bodies differ."""
UNKNOWN_ENDS = Quantity(value=0.0, unit="1", standard_uncertainty=EXTENSION_UNCERTAINTY)
"""By how much more a stroke is extended than it should be, in half widths of the groove."""
_EDGE = 1e-6
"""Share of a tip that is left at the most: where all is gone, its flank is vertical."""
_SHORTEST = 0.5
"""Least length of a groove over its stroke."""
_TURNS = 8
_WORN_TIP = 0.5
"""Share of the depth of half a sphere by which a tip may be worn where it is unknown."""
Wear = Literal["pin_depth", "disc_depth", "pin_volume", "disc_volume"]


@dataclass(frozen=True)
class SlidingPath:
    """Path of a pin on its disc."""

    length: Quantity
    """Radius of the circle, or the stroke, m."""
    stiffness: float | None = None
    """Reduced modulus over normal load, 1/m², of a pin that slides there and back."""

    @classmethod
    def of(cls, run: RawRun, defaults: DefaultUncertainty) -> "SlidingPath | None":
        """Return the path that run.toml describes; None if it does not."""
        conditions = run.manifest.conditions
        length = path_length(run.manifest, defaults)
        if length is None or conditions.stroke is None:
            return None if length is None else cls(length)
        return cls(length, float(run.manifest.described.reduced_modulus()) / conditions.normal_load.value)

    @property
    def there_and_back(self) -> bool:
        """Whether the length is a stroke."""
        return self.stiffness is not None

    def volume(self, worn: WornContact, length: float, ends: float = 0.0) -> float:
        """Return the volume of a track, m³; ends of a stroke that wear otherwise are in half widths of the groove."""
        area = float(worn.groove_area)
        if self.stiffness is None:
            return float(circle_volume(area=area, track_radius=length))
        extended = Stroke(np.asarray(length), np.asarray(self.stiffness)).extended(worn)
        # A groove wider than a stroke is long is uncertain by more than the stroke, but no shorter than nothing.
        return area * float(np.maximum(extended + ends * worn.half_width, _SHORTEST * length))


@dataclass(frozen=True)
class WornPair:
    """A reading on the pin and one on the track, or two on one of them."""

    tip: WornTip
    radius: Quantity
    """Radius of the tip, m."""
    path: SlidingPath | None
    pin: EndValueUsed
    disc: EndValueUsed

    def find(self, what: Wear) -> Quantity:
        """Return a depth, m, or volume, m³, uncertain by both readings, the tip's radius, the path and the shape."""
        return _with_shape(_combined(partial(self._value, what), self._inputs(what), what), what, self)

    def contact(self) -> WornContact:
        """Return the shape of both bodies by the readings as they are."""
        return _solved(self, tuple(_best(self, "disc_volume").items())).contact

    @property
    def beyond_tip(self) -> bool:
        """Whether both bodies would be worn by all of the tip or more, so that no contact has these readings.

        Where the share of the pin is unknown, it may be zero.
        """
        pair = replace(self, pin=_UNWORN_PIN) if self.pin is UNKNOWN_SHARE else self
        return float(pair.contact().approach) >= (1 - 2 * _EDGE) * self.tip_height

    @property
    def tip_height(self) -> float:
        """Depth, m, at which all of the tip is worn away."""
        return float(self.tip.on_track(self.radius.value).most)

    def _inputs(self, what: Wear) -> dict[str, Quantity]:
        found = {self.pin.name: self.pin.quantity, self.disc.name: self.disc.quantity, "radius": self.radius}
        if self.path is not None and (what == "disc_volume" or self.disc.name in VOLUMES):
            found |= {"path": self.path.length} | ({"ends": UNKNOWN_ENDS} if self.path.there_and_back else {})
        return found

    def _value(self, what: Wear, given: dict[str, float]) -> float:
        """Return a depth, or volume; below zero where the depth is, as a draw of a reading may be."""
        worn = _solved(self, tuple(given.items()))
        h_p, h_d = worn.depths
        return {
            "pin_depth": h_p,
            "disc_depth": h_d,
            "pin_volume": math.copysign(worn.pin_volume, h_p),
            "disc_volume": math.copysign(worn.disc_volume, h_d),
        }[what]


class _Worn(NamedTuple):
    """Wear of both bodies."""

    depths: tuple[float, float]
    """Those of pin and track in the middle, m; below zero for a gain."""
    contact: WornContact
    """A pin that has gained counts as not worn."""
    pin_volume: float
    disc_volume: float
    """m³ without sign; that of the disc is NaN without a path."""


@lru_cache(maxsize=1024)
def _solved(pair: WornPair, given: tuple[tuple[str, float], ...]) -> _Worn:
    values = dict(given)
    contact = pair.tip.on_track(values["radius"])
    solver = _Solver(pair, contact, values)
    h_p, h_d = solver.depths()
    worn = solver.within_tip(max(h_p, 0.0), abs(h_d))
    # What a flat pin has gained is no wear that the groove shapes.
    alone = pair.tip.constant_area and h_p < 0
    lost = pair.tip.volume(-h_p, values["radius"]) if alone else solver.within_tip(abs(h_p), abs(h_d)).pin_volume
    return _Worn((h_p, h_d), worn, float(lost), solver.volume(worn) if "path" in values else math.nan)


def difference(one: WornPair, other: WornPair, what: Wear) -> Quantity:
    """Return how much more of a depth, m, or volume, m³, one pair of readings gives; inputs of both count once."""

    def gap(given: dict[str, float]) -> float:
        return one._value(what, given) - other._value(what, given)  # noqa: SLF001 - of this module

    inputs = one._inputs(what) | other._inputs(what)  # noqa: SLF001
    return _with_shape(_combined(gap, inputs, what), what, one, other)


def _combined(function: Callable[[dict[str, float]], float], inputs: dict[str, Quantity], what: Wear) -> Quantity:
    return combined(
        lambda *values: function(dict(zip(inputs, values, strict=True))),
        tuple(inputs.values()),
        "m^3" if what.endswith("volume") else "m",
    )


def _with_shape(found: Quantity, what: Wear, *pairs: WornPair) -> Quantity:
    """Return a volume of the track as uncertain as its shape makes it as well, if it follows from depth or width."""
    if what != "disc_volume":
        return found
    shaped = [_SHAPE * pair._value(what, _best(pair, what)) for pair in pairs if pair.disc.name not in (AREA, *VOLUMES)]  # noqa: SLF001
    spread = math.hypot(found.u_or_zero, *shaped)
    return found.model_copy(update={"standard_uncertainty": spread})


def _best(pair: WornPair, what: Wear) -> dict[str, float]:
    return {name: one.value for name, one in pair._inputs(what).items()}  # noqa: SLF001


@dataclass(frozen=True)
class _Solver:
    """A pair with its contact, and what its readings and other inputs are taken to be."""

    pair: WornPair
    contact: OnTrack
    given: dict[str, float]

    @property
    def disc(self) -> float:
        """Reading of the track."""
        return self.given[self.pair.disc.name]

    @property
    def _pin_volume(self) -> float:
        """Volume that the pin has lost, m³, by its reading and the radius of its tip."""
        return float(self.pair.tip.volume_read(self.pair.pin, self.given[self.pair.pin.name], self.given["radius"]))

    def volume(self, worn: WornContact) -> float:
        """Return the volume of the track, m³."""
        if self.pair.path is None:
            return math.nan
        return self.pair.path.volume(worn, self.given["path"], self.given.get("ends", 0.0))

    @property
    def most(self) -> float:
        """Deepest approach, m, at which shapes are calculated: just less than all of the tip."""
        return (1 - _EDGE) * float(self.contact.most)

    def within_tip(self, pin_depth: float, disc_depth: float) -> WornContact:
        """Return the contact at these depths, m, or where they are more than the tip, the one that has all of it."""
        most = self.most
        pin_depth = min(pin_depth, most)
        return self.contact.at_depths(pin_depth, min(disc_depth, most - pin_depth))

    def depths(self) -> tuple[float, float]:
        """Return the depths of pin and track in the middle, m."""
        if self.pair.disc.name not in (AREA, *VOLUMES):
            pin_depth = self._pin_depth(self._disc_depth)
            return pin_depth, self._disc_depth(pin_depth)
        if self.pair.pin.name in VOLUMES:
            return self._by_volumes()
        lost, most = abs(self.disc), _WORN_TIP * self.most

        def pin_depth_beside(depth: float) -> float:
            return min(self._pin_depth(lambda _: depth), most)

        def track(depth: float) -> float:
            return self._size(self.within_tip(max(pin_depth_beside(depth), 0.0), depth))

        disc_depth = self._rising(track, lost)
        return pin_depth_beside(disc_depth), math.copysign(disc_depth, self.disc)

    def _by_volumes(self) -> tuple[float, float]:
        """Return the depths by both volumes; those of the ends of a stroke are found in turns with its section."""
        pin, lost, ends = self._pin_volume, abs(self.disc), 0.0
        per_length = self._size(replace(self.contact.at_depths(0.0, 0.0), groove_area=np.ones(())))
        for _ in range(_TURNS if self.pair.path is not None and self.pair.path.there_and_back else 1):
            worn = self._of_volumes(max(pin, 0.0), max(lost - ends, 0.0) / per_length)
            ends = self._size(worn) - per_length * float(worn.groove_area)
        disc_depth = float(worn.groove_depth)
        pin_depth = float(worn.pin_depth) if pin >= 0 else self._pin_depth(lambda _: disc_depth)
        return pin_depth, math.copysign(disc_depth, self.disc)

    def _of_volumes(self, pin_volume: float, section: float) -> WornContact:
        """Return the contact of a pin's volume, m³, and a cross-section, m², or one that has all of the tip."""
        most = self.most
        pin_alone, groove_alone = self.within_tip(most, 0.0), self.within_tip(0.0, most)
        if pin_volume < pin_alone.pin_volume and section < groove_alone.groove_area:
            worn = self.contact.worn(pin_volume, section)
            if worn.approach < most:
                return worn
        pin_depth = self.pair.tip.depth_of_volume(np.asarray(pin_volume), np.asarray(self.given["radius"]))
        return self.within_tip(min(float(pin_depth), _WORN_TIP * most), most)

    def _size(self, worn: WornContact) -> float:
        """Return what was measured of the track: its cross-section, m², or its volume, m³."""
        return float(worn.groove_area) if self.pair.disc.name == AREA else self.volume(worn)

    def _disc_depth(self, pin_depth: float) -> float:
        """Return the depth of a track, m, by its depth or width or that of both, under a pin worn by a depth, m."""
        name = self.pair.disc.name
        if name in APPROACHES:
            # A width shows no material that the pin has gained.
            return self._approach(name, self.disc) - (max(pin_depth, 0.0) if name in WIDTHS else pin_depth)
        return self.disc

    def _pin_depth(self, disc_depth: Callable[[float], float]) -> float:
        """Return the wear depth of the pin, m, with a track whose depth, m, may depend on it."""
        name, reading = self.pair.pin.name, self.given[self.pair.pin.name]
        if name == "pin_share":
            return self._of_share(reading, disc_depth)
        if name in VOLUMES:
            lost = self._pin_volume
            return math.copysign(self._rising(lambda h: self._lost(h, abs(disc_depth(h))), abs(lost)), lost)
        if name in WIDTHS:
            return self._approach(name, reading) - disc_depth(0.0)
        if name == "pin_scar_diameter":
            size = abs(reading)
            return math.copysign(self._between(lambda h: self._diameter(h, h + disc_depth(h)) - size), reading)
        return float(self.pair.tip.depth(self.pair.pin, reading, self.given["radius"]))

    def _of_share(self, share: float, disc_depth: Callable[[float], float]) -> float:
        if self.pair.disc.name in APPROACHES:
            return share * self._approach(self.pair.disc.name, self.disc)
        most = _WORN_TIP * self.most
        return min(share / (1 - share) * abs(disc_depth(0.0)), most) if share < 1 else most

    def _approach(self, name: str, reading: float) -> float:
        """Return the wear depth of both bodies together, m."""
        return reading if name == BY_SIGNAL else float(self.contact.approach_at(reading / 2))

    def _lost(self, pin_depth: float, disc_depth: float) -> float:
        return float(self.within_tip(pin_depth, disc_depth).pin_volume)

    def _diameter(self, pin_depth: float, approach: float) -> float:
        """Return the mean of length and width of the scar, m."""
        approach = min(approach, self.most)
        return float(self.contact.half_width_at(pin_depth) + self.contact.half_width_at(approach))

    def _rising(self, function: Callable[[float], float], target: float) -> float:
        """Return where a function that rises from zero meets its target, m, at most all of the tip."""
        most = self.most
        if function(most) <= target:
            return most
        return float(power_root(np.vectorize(function, otypes=[float]), target, 1e-3 * most, most))

    def _between(self, excess: Callable[[float], float]) -> float:
        """Return where a function is zero, m, from no wear of the pin to all of its tip."""
        from scipy.optimize import brentq

        most = self.most
        if excess(0.0) >= 0:
            return 0.0
        return most if excess(most) <= 0 else float(brentq(excess, 0.0, most, xtol=1e-15 * most, rtol=1e-13))


_TOO_FAR = 3.0
"""Standard uncertainties."""
_WEAR: dict[tuple[str, Literal["depth", "volume"]], Wear] = {
    ("pin", "depth"): "pin_depth",
    ("pin", "volume"): "pin_volume",
    ("disc", "depth"): "disc_depth",
    ("disc", "volume"): "disc_volume",
}
_ROUNDING = 1e-6
"""Share of a depth or volume that readings stated as exact may differ by."""


def contradictions(worn: WornBodies) -> Iterator[Contradiction]:
    """Yield each two ways whose depths, or volumes, differ by more than three standard uncertainties of the difference.

    What both depend on, such as the radius of the tip, counts once. Volumes of a pin follow from its depth, and are
    compared only where one of them is a gain, which has no depth.
    """
    for (body, what), wear in _WEAR.items():
        ways = (way for way in worn.bodies[body] if getattr(way, what) is not None)
        for one, other in combinations(ways, 2):
            if wear == "pin_volume" and None not in (one.depth, other.depth):
                continue
            gap = _gap(one, other, what, wear)
            spread = gap.u_or_zero
            least = _ROUNDING * abs(getattr(one, what).value)
            if abs(gap.value) > max(_TOO_FAR * spread, least):
                yield Contradiction(body, what, one, other, abs(gap.value) / spread if spread else math.inf)


def _gap(one: BodyWear, other: BodyWear, what: Literal["depth", "volume"], wear: Wear) -> Quantity:
    if isinstance(one.pair, WornPair) and isinstance(other.pair, WornPair):
        return difference(one.pair, other.pair, wear)
    first, second = getattr(one, what), getattr(other, what)
    spread = math.hypot(first.u_or_zero, second.u_or_zero)
    return Quantity(value=first.value - second.value, unit=first.unit, standard_uncertainty=spread)
