"""What was measured on a pin and its disc, at the end of a run or in between, turned into the wear of each."""

from dataclasses import dataclass, replace
from functools import cached_property

from numpy.typing import ArrayLike

from tribopipe.end_values.disc_track import Groove, SlidingPath, disc_notes, disc_wear
from tribopipe.end_values.measured import BodyWear, EndValueUsed, stated_or_default, surest
from tribopipe.end_values.pin_tip import PinTip, pin_values, pin_wear
from tribopipe.records.manifest import EndValues
from tribopipe.records.quantity import Quantity
from tribopipe.records.recipe import DefaultUncertainty
from tribopipe.run import Column, RawRun
from tribopipe.uncertainty import first_order


@dataclass(frozen=True)
class EndWear:
    """Wear of the run at its end, by what was measured on the specimens."""

    pin: EndValueUsed
    disc: EndValueUsed | None
    tip: PinTip

    @cached_property
    def pin_depth(self) -> Quantity:
        """Wear depth of the pin, m: as measured, or as it follows from a scar, a volume, a mass or a profile.

        Its uncertainty is that of the end value alone; the tip radius is an input of k_D by itself.
        """
        return first_order(lambda value: float(self.pin_depth_of(value, self.tip.radius)), (self.pin.quantity,), "m")

    def pin_depth_of(self, end_value: ArrayLike, pin_radius: ArrayLike) -> Column:
        """Return the pin's wear depth, m, were end value and tip radius these."""
        return self.tip.depth(self.pin, end_value, pin_radius)

    def grown(self, depth: float) -> "EndWear":
        """Return the end values of a pin worn to another depth, m, the disc's in proportion, as uncertain as before."""
        disc = self.disc
        if disc is not None:
            disc = _with_value(disc, disc.quantity.value * depth / self.pin_depth.value)
        return replace(self, pin=_with_value(self.pin, self.tip.value(self.pin, depth)), disc=disc)

    @property
    def total(self) -> Quantity:
        """Wear of pin and disc together, m: what a displacement sensor has seen."""
        if self.disc is None:
            return self.pin_depth
        return first_order(lambda pin, disc: pin + disc, (self.pin_depth, self.disc.quantity), "m")

    @property
    def anchor(self) -> str:
        """Names of the end values used."""
        return " + ".join(used.name for used in (self.pin, self.disc) if used is not None)


def _with_value(used: EndValueUsed, value: float) -> EndValueUsed:
    return replace(used, quantity=used.quantity.model_copy(update={"value": value}))


def end_wear(run: RawRun, defaults: DefaultUncertainty, interruption: int | None = None) -> EndWear | None:
    """Return the wear measured at the end of a run or in between; none where nothing was measured on the pin.

    Of several things measured on the pin the one is used that tells its depth most certainly; of the disc the most
    certain depth, a measured one before one that follows from the shape of the groove.

    Raises ``FitError`` for a mass without density, and for profiles of which nothing can be taken.
    """
    where, end = measured_at(run, interruption)
    best = _surest_pin(_pins(run, where, end, defaults))
    if best is None:
        return None
    disc = surest(disc_wear(run, where, end, _groove(run, best, defaults), defaults), "depth")
    if disc is None or disc.depth is None:
        return best
    return replace(best, disc=EndValueUsed(disc.name, disc.depth, disc.source))


def _pins(run: RawRun, where: str, end: EndValues, defaults: DefaultUncertainty) -> list[EndWear]:
    """Return the wear of the pin by each end value."""
    tip = PinTip.of(run.manifest.pin_on_disc.pin)
    return [EndWear(used, None, tip) for used in pin_values(run, where, end, defaults)]


def _surest_pin(found: list[EndWear]) -> EndWear | None:
    return min(found, key=lambda wear: wear.pin_depth.standard_uncertainty or 0.0, default=None)


def measured_at(run: RawRun, interruption: int | None = None) -> tuple[str, EndValues]:
    """Return what was measured at the end of a run, or at an interruption, and the key it stands under."""
    if interruption is None:
        return "end_values", run.manifest.end_values
    return f"interruptions[{interruption}]", run.manifest.interruptions[interruption]


@dataclass(frozen=True)
class PinOnDiscWear:
    """Everything that was measured on pin and disc at the end, as depth and volume."""

    pin: tuple[BodyWear, ...]
    disc: tuple[BodyWear, ...]
    notes: tuple[str, ...] = ()
    """What stands in the way of a volume, and what is taken for granted."""


def pin_on_disc_wear(run: RawRun, defaults: DefaultUncertainty, interruption: int | None = None) -> PinOnDiscWear:
    """Return depth and volume of both bodies by each end value, or by what was measured at an interruption.

    Raises ``FitError`` for a mass without density, and for profiles of which nothing can be taken.
    """
    where, end = measured_at(run, interruption)
    pins, radius = _pins(run, where, end, defaults), tip_radius(run, defaults)
    groove = _groove(run, _surest_pin(pins), defaults)
    discs = tuple(disc_wear(run, where, end, groove, defaults))
    return PinOnDiscWear(
        pin=tuple(pin_wear(wear.tip, wear.pin, radius) for wear in pins),
        disc=discs,
        notes=tuple(disc_notes(run, end, discs, groove)),
    )


def tip_radius(run: RawRun, defaults: DefaultUncertainty) -> Quantity:
    """Return the radius of the pin with its standard uncertainty, stated or by default."""
    radius = run.manifest.pin_on_disc.pin.radius
    known, _ = stated_or_default(radius, defaults.pin_radius * radius.value)
    return known


def _groove(run: RawRun, pin: EndWear | None, defaults: DefaultUncertainty) -> Groove | None:
    """Return the groove of the pin as it is worn at the end, or of its unworn tip; none for a flat pin."""
    tip = PinTip.of(run.manifest.pin_on_disc.pin)
    if tip.shape == "flat":
        return None
    worn = Quantity(value=0.0, unit="m") if pin is None else pin.pin_depth
    flat = first_order(lambda depth: float(tip.scar_radius(depth, tip.radius)), (worn,), "m")
    return Groove(tip_radius(run, defaults), flat, SlidingPath.of(run.manifest.conditions, defaults))
