"""Wear of pin and disc from measurements at the end of a run or at interruptions."""

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace

from tribopipe.documents.manifest import EndValues
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import DefaultUncertainty
from tribopipe.evaluation.measurements.body_wear import BodyWear, WornBodies, surest
from tribopipe.evaluation.measurements.disc_track import disc_notes, disc_readings, disc_wear
from tribopipe.evaluation.measurements.end_wear import EndWear, with_uncertainty
from tribopipe.evaluation.measurements.pin_tip import pin_notes, pin_values
from tribopipe.evaluation.measurements.readings import (
    APPROACHES,
    BY_SIGNAL,
    VOLUMES,
    WIDTHS,
    EndValueUsed,
    SignalDepths,
    combined,
)
from tribopipe.evaluation.measurements.worn_pair import UNKNOWN_SHARE, SlidingPath, WornPair
from tribopipe.evaluation.measurements.worn_tip import WornTip, tip_radius
from tribopipe.results.run import RawRun

_CLEARLY = 3.0
"""Standard uncertainties from which on two widths show a groove."""


def end_wear(
    run: RawRun, defaults: DefaultUncertainty, interruption: int | None = None, approach: Quantity | None = None
) -> EndWear | None:
    """Return the wear measured at the end of a run or in between; None if nothing was measured on the pin.

    Of several things measured on the pin the one is used that gives its depth most certainly; of the disc the most
    certain depth, a measured one before one that follows from the shape of the groove. ``approach`` is the wear depth
    of both bodies, m, by a depth signal that shows a groove nobody measured.

    Raises ``FitError`` for a mass without density, and for profiles of which nothing can be taken.
    """
    found = _Found.of(run, *measured_at(run, interruption), defaults, SignalDepths(both=approach))
    pins = [EndWear(found.on_unworn_track(pin), None, found.pair.tip) for pin in found.pins]
    best = min(pins, key=lambda wear: wear.pin_depth.u_or_zero, default=None)
    return None if best is None else replace(best, disc=found.groove)


def groove_alone(run: RawRun, defaults: DefaultUncertainty) -> EndValueUsed | None:
    """Return the depth of the groove, m, at the end of a run whose pin was not measured; None where it was.

    Raises ``FitError`` for profiles of which nothing can be taken.
    """
    found = _Found.of(run, *measured_at(run), defaults)
    return None if found.pins else found.groove


def beside_unseen_groove(end: EndWear, share: float, by_sensor: bool) -> float:
    """Return the volume of a pin with a groove that was not measured, over that on a disc that does not wear.

    Parameters
    ----------
    end
        What gives the depth of the pin; where its volume or the disc was measured, or its
        contact is a line, the answer is 1.
    share
        Depth of the groove over that of the pin.
    by_sensor
        Whether the depth is what a displacement sensor has seen, the groove included, rather than that of the pin.
    """
    depth, tip = end.pin_depth.value, end.tip
    known = end.disc is not None or (end.by_volume and not by_sensor)
    if known or tip.line or not depth > 0:
        return 1.0
    contact = tip.on_track(tip.radius)
    if by_sensor:
        beside = contact.at_depths(depth / (1 + share), share * depth / (1 + share))
    else:
        groove = EndValueUsed("disc_wear_depth", Quantity(value=share * depth, unit="m"), "default")
        beside = WornPair(tip, Quantity(value=tip.radius, unit="m"), None, end.pin, groove).contact()
    return float(beside.pin_volume) / float(contact.at_depths(depth, 0.0).pin_volume)


def measured_at(run: RawRun, interruption: int | None = None) -> tuple[str, EndValues]:
    """Return the key of the post-test measurements of a run, or of an interruption, and what was measured."""
    if interruption is None:
        return "end_values", run.manifest.end_values
    return f"interruptions[{interruption}]", run.manifest.interruptions[interruption]


def pin_on_disc_wear(
    run: RawRun,
    defaults: DefaultUncertainty,
    interruption: int | None = None,
    signal: SignalDepths | None = None,
) -> WornBodies:
    """Return depth and volume of both bodies by each post-test measurement, or by what was measured at an interruption.

    ``signal`` is what only the depth signal shows of their depths; that of the pin is no measurement of it.

    Raises ``FitError`` for a mass without density, and for profiles of which nothing can be taken.
    """
    where, end = measured_at(run, interruption)
    signal = signal or SignalDepths()
    found = _Found.of(run, where, end, defaults, signal)
    pins = tuple(found.wear_of(pin) for pin in found.pins if pin.quantity is not signal.pin)
    notes = (*pin_notes(run, where), *disc_notes(run, end, found.disc, signal.pin))
    return WornBodies({"pin": pins, "disc": found.disc}, notes)


_NO_TRACK = EndValueUsed("disc_wear_depth", Quantity(value=0.0, unit="m"), "default")
"""Disc without a measurement: the wear of the pin is that on a track that does not wear."""


@dataclass(frozen=True)
class _Found:
    """All readings of pin and disc at one time, each to be taken with the best of the other one."""

    pair: WornPair
    """The best reading of either body."""
    pins: tuple[EndValueUsed, ...]
    disc: tuple[BodyWear, ...]
    unseen_groove: float
    """Depth of a groove that nobody measured, over that of the pin."""

    @classmethod
    def of(
        cls,
        run: RawRun,
        where: str,
        end: EndValues,
        defaults: DefaultUncertainty,
        signal: SignalDepths | None = None,
    ) -> "_Found":
        signal = signal or SignalDepths()
        tip, path = WornTip.of(run.manifest.described.equivalent_pin), SlidingPath.of(run, defaults)
        pins = tuple(pin_values(run, where, end, defaults))
        readings = [*disc_readings(run, where, end, defaults), *(pin for pin in pins if pin.name == "pin_scar_width")]
        if tip.widens and all(pin.name in WIDTHS and pin.quantity.value for pin in pins):
            pins = ()  # the scar is as wide as the groove, whichever of both bodies has worn
        if not pins and signal.pin is not None:
            pins = (EndValueUsed("pin_wear_depth", signal.pin, "manifest"),)
        if signal.both is not None:
            readings.append(EndValueUsed(BY_SIGNAL, signal.both, "manifest"))
        best = min(pins, key=lambda pin: _rank(pin, tip), default=UNKNOWN_SHARE)
        pair = WornPair(tip, tip_radius(run, defaults), path, best, _NO_TRACK)
        unseen = defaults.unseen_groove
        found = cls(pair, pins, tuple(map(_if_shown, disc_wear(run, where, readings, pair))), unseen).with_best_track(
            readings
        )
        if not any(pin.name == "pin_scar_diameter" for pin in pins) or found.pair.disc is _NO_TRACK:
            return found
        pins = tuple(found.in_any_direction(pin) for pin in pins)
        best = next((pin for pin in pins if pin.name == best.name), UNKNOWN_SHARE)
        pair = replace(found.pair, pin=best)
        return cls(pair, pins, tuple(map(_if_shown, disc_wear(run, where, readings, pair))), unseen)

    @property
    def groove(self) -> EndValueUsed | None:
        """The most certain depth of the disc, m."""
        disc = surest(self.disc, "depth")
        return None if disc is None or disc.depth is None else EndValueUsed(disc.name, disc.depth, disc.source)

    def with_best_track(self, readings: Iterable[EndValueUsed]) -> "_Found":
        """Return a copy with the track measurement that gives the smallest uncertainty of the depth."""
        way = surest(self.disc, "depth")
        name = None if way is None else way.name
        disc = next((one for one in readings if one.name == name), _NO_TRACK)
        return replace(self, pair=replace(self.pair, disc=disc))

    def in_any_direction(self, pin: EndValueUsed) -> EndValueUsed:
        """Return a diameter of a scar, the mean of length and width (ASTM G99, G133).

        Neither counts for less than a quarter of it, and most likely both count alike: a triangular distribution.
        """
        if pin.name != "pin_scar_diameter":
            return pin
        shape = self.taken_with_track(pin).contact()
        along = float(shape.half_width - shape.half_length) / math.sqrt(24)
        return with_uncertainty(pin, math.hypot(pin.quantity.u_or_zero, along))

    def taken_with_track(self, pin: EndValueUsed) -> WornPair:
        """Return a reading of the pin with the best one of the track."""
        if pin.name in WIDTHS and self.pair.disc.name in APPROACHES:
            return self.pair
        return replace(self.pair, pin=pin)

    def wear_of(self, pin: EndValueUsed) -> BodyWear:
        """Return depth and volume that the pin has lost by one reading."""
        if pin.name in VOLUMES and pin.quantity.value < 0:
            return BodyWear(pin.name, pin.source, volume=pin.quantity)
        if self.pair.disc is _NO_TRACK:
            seen = pin.name in VOLUMES or self._tells_of_the_groove(pin)
            return _on_unworn_track(self.pair, pin, 0.0 if seen else self.unseen_groove)
        pair = self.taken_with_track(pin)
        return BodyWear(pin.name, pin.source, pair.find("pin_depth"), pair.find("pin_volume"), pair=pair)

    def _tells_of_the_groove(self, pin: EndValueUsed) -> bool:
        """Return whether what was measured on the disc gives its groove, or that there is none.

        A track is as wide as a scar of unknown direction in any groove, and a volume is of any depth on a track of
        unknown length.
        """
        in_any_direction = pin.name == "pin_scar_diameter"
        return any(not (way.hides_groove or (in_any_direction and way.name in WIDTHS)) for way in self.disc)

    def on_unworn_track(self, pin: EndValueUsed) -> EndValueUsed:
        """Return a reading with what the wear of the track makes of it, and as uncertain as both readings make it."""
        if self.pair.disc is _NO_TRACK:
            return pin
        pair, tip = self.taken_with_track(pin), self.pair.tip
        known = replace(pair, radius=pair.radius.model_copy(update={"standard_uncertainty": 0.0}))
        depth = known.find("pin_depth")
        if depth.value <= 0 or pin.quantity.value <= 0:
            return pin
        pin = replace(pin, on_unworn_track=tip.value(pin, depth.value) / pin.quantity.value)
        alone = EndWear(pin, None, tip).pin_depth.u_or_zero
        if not alone:
            return pin
        wider = max(1.0, depth.u_or_zero / alone)
        return with_uncertainty(pin, wider * pin.quantity.u_or_zero)


def _if_shown(way: BodyWear) -> BodyWear:
    """Return the wear of a disc without the depth and volume of a groove that two widths leave open.

    A track is as wide as a scar of unknown direction in any groove, and a little wider by the errors of both.
    """
    open_ = (
        way.name in APPROACHES
        and way.pair is not None
        and way.pair.pin.name == "pin_scar_diameter"
        and way.depth is not None
        and way.depth.value < _CLEARLY * way.depth.u_or_zero
    )
    return replace(way, depth=None, volume=None) if open_ else way


def _on_unworn_track(pair: WornPair, pin: EndValueUsed, unseen_groove: float) -> BodyWear:
    """Return depth and volume of a pin whose track has not worn, as uncertain as an unseen groove makes the volume."""
    tip, given = pair.tip, (pin.quantity, pair.radius)

    def depth(value: float, radius: float) -> float:
        return float(tip.depth(pin, value, radius))

    def volume(value: float, radius: float) -> float:
        deep = depth(value, radius)
        return math.copysign(float(tip.volume(abs(deep), radius)), deep)

    lost = combined(volume, given, "m^3")
    end = EndWear(pin, None, tip)
    beside = abs(beside_unseen_groove(end, unseen_groove, by_sensor=False) - 1) if unseen_groove else 0.0
    spread = math.hypot(lost.u_or_zero, beside * lost.value)
    return BodyWear(
        pin.name,
        pin.source,
        combined(depth, given, "m"),
        lost.model_copy(update={"standard_uncertainty": spread}) if beside else lost,
        pair=replace(pair, pin=pin),
        unseen_groove=beside,
    )


def _rank(pin: EndValueUsed, tip: WornTip) -> tuple[bool, float]:
    """Return what a reading of the pin is chosen by: the uncertainty of its depth, a width of the scar last."""
    return pin.name in WIDTHS, EndWear(pin, None, tip).pin_depth.u_or_zero
