"""The wear of a run at its end, by what was measured on the specimens: what a displacement sensor has seen."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

from numpy.typing import ArrayLike

from tribopipe.base.arrays import Column
from tribopipe.documents.quantity import Quantity
from tribopipe.evaluation.measurements.readings import BY_SIGNAL, PIN_VOLUMES, EndValueUsed, combined
from tribopipe.evaluation.measurements.worn_tip import WornTip


@dataclass(frozen=True)
class EndWear:
    """Wear of the run at its end, by what was measured on the specimens."""

    pin: EndValueUsed
    disc: EndValueUsed | None
    tip: WornTip

    @cached_property
    def pin_depth(self) -> Quantity:
        """Wear depth of the pin, m: as measured, or as it follows from a scar, a volume, a mass or a profile.

        Its uncertainty is that of the post-test measurement alone; the tip radius is a separate input of k_D.
        """
        return combined(lambda value: float(self.pin_depth_of(value, self.tip.radius)), (self.pin.quantity,), "m")

    def pin_depth_of(self, end_value: ArrayLike, pin_radius: ArrayLike) -> Column:
        """Return the pin's wear depth, m, were post-test measurement and tip radius these."""
        return self.tip.depth(self.pin, end_value, pin_radius)

    def grown(self, depth: float) -> "EndWear":
        """Return the post-test measurements of a pin worn to another depth, m; the disc's in proportion.

        They are as uncertain as they are, but for a volume, which is as uncertain relative to itself.
        """
        disc = self.disc
        if disc is not None:
            disc = _with_value(disc, disc.quantity.value * depth / self.pin_depth.value)
        pin = _with_value(self.pin, self.tip.value(self.pin, depth))
        if pin.name == "pin_wear_volume" and self.pin.quantity.value:
            spread = self.pin.quantity.u_or_zero
            pin = with_uncertainty(pin, spread * pin.quantity.value / self.pin.quantity.value)
        return replace(self, pin=pin, disc=disc)

    @property
    def by_volume(self) -> bool:
        """Whether a volume or a mass of the pin was measured, which a groove next to it does not change."""
        return self.pin.name in PIN_VOLUMES

    @property
    def total(self) -> Quantity:
        """Wear of pin and disc together, m: what a displacement sensor has seen."""
        if self.disc is None:
            return self.pin_depth
        return combined(lambda pin, disc: pin + disc, (self.pin_depth, self.disc.quantity), "m")

    @property
    def groove_by_signal(self) -> bool:
        """Whether the depth signal alone shows the wear of the disc."""
        return self.disc is not None and self.disc.name == BY_SIGNAL

    @property
    def anchor(self) -> str:
        """Names of the post-test measurements used."""
        return " + ".join(used.name for used in (self.pin, self.disc) if used is not None)


def _with_value(used: EndValueUsed, value: float) -> EndValueUsed:
    return replace(used, quantity=used.quantity.model_copy(update={"value": value}))


def with_uncertainty(used: EndValueUsed, spread: float) -> EndValueUsed:
    """Return a measurement with another standard uncertainty."""
    return replace(used, quantity=used.quantity.model_copy(update={"standard_uncertainty": spread}))


@dataclass(frozen=True)
class TotalWear:
    """Wear of both bodies together at the end of a run."""

    total: Quantity
    """h₁ + h₂, m: what a displacement sensor has seen."""
    names: tuple[str, ...]
    """Names of the post-test measurements it was taken from, that of the first body first."""

    @property
    def anchor(self) -> str:
        """Names of the post-test measurements used."""
        return " + ".join(self.names)


class TotalLimit(NamedTuple):
    """Wear at which two bodies would be in contact over more than the width of one of them."""

    width: float
    """m."""
    total: float
    """h₁ + h₂, m."""
