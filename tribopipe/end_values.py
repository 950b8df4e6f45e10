"""What was measured on the specimens after the test, turned into the wear depth of each body."""

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from tribopipe.geometry import cap_height
from tribopipe.records.manifest import EndValues
from tribopipe.records.quantity import EndValue, Quantity
from tribopipe.records.recipe import DefaultUncertainty
from tribopipe.run import Column

Source = Literal["manifest", "default"]


@dataclass(frozen=True)
class EndValueUsed:
    """One end value as it enters the correction."""

    name: Literal["pin_wear_depth", "pin_scar_diameter", "disc_wear_depth"]
    quantity: Quantity
    source: Source


@dataclass(frozen=True)
class EndWear:
    """Wear of the run at its end, by what was measured on the specimens."""

    pin: EndValueUsed
    disc: EndValueUsed | None
    pin_radius: float

    @property
    def pin_depth(self) -> Quantity:
        """Wear depth of the pin, m: as measured, or the cap height of its flat scar.

        Its uncertainty is that of the end value alone; the tip radius is an input of k_D by itself.
        """
        value = self.pin.quantity.value
        spread = self.pin.quantity.standard_uncertainty or 0.0
        if self.pin.name == "pin_scar_diameter":
            spread *= value / 4 / math.sqrt(self.pin_radius**2 - value**2 / 4)
        depth = float(self.pin_depth_of(value, self.pin_radius))
        return Quantity(value=depth, unit="m", standard_uncertainty=spread)

    def pin_depth_of(self, end_value: ArrayLike, pin_radius: ArrayLike) -> Column:
        """Return the pin's wear depth, m, were end value and tip radius these: R − √(R² − d²/4) of a scar d."""
        measured = np.asarray(end_value, dtype=float)
        if self.pin.name != "pin_scar_diameter":
            return measured
        depth = cap_height(scar_radius=np.abs(measured) / 2, sphere_radius=pin_radius)
        return np.asarray(np.copysign(depth, measured))

    @property
    def total(self) -> Quantity:
        """Wear of pin and disc together, m: what a displacement sensor has seen."""
        if self.disc is None:
            return self.pin_depth
        spread = math.hypot(*(part.standard_uncertainty or 0.0 for part in (self.pin_depth, self.disc.quantity)))
        value = self.pin_depth.value + self.disc.quantity.value
        return Quantity(value=value, unit="m", standard_uncertainty=spread)

    @property
    def anchor(self) -> str:
        """Names of the end values used."""
        return " + ".join(used.name for used in (self.pin, self.disc) if used is not None)


def stated_or_default(quantity: Quantity, default: float) -> tuple[Quantity, Source]:
    """Give a quantity the default standard uncertainty where the manifest states none."""
    if quantity.standard_uncertainty is not None:
        return quantity, "manifest"
    return quantity.model_copy(update={"standard_uncertainty": default}), "default"


def end_wear(end: EndValues, pin_radius: float, defaults: DefaultUncertainty) -> EndWear | None:
    """Return the wear measured at the end of a run or in between; none where nothing was measured on the pin.

    Of a depth and a scar diameter of the pin, the more certain one is used.
    """
    depth = _used("pin_wear_depth", end.pin_wear_depth, defaults.wear_depth.value)
    scar = _used("pin_scar_diameter", end.pin_scar_diameter, defaults.pin_scar_diameter.value)
    disc = _used("disc_wear_depth", end.disc_wear_depth, defaults.wear_depth.value)
    found = [EndWear(pin, disc, pin_radius) for pin in (depth, scar) if pin is not None]
    return min(found, key=lambda wear: wear.pin_depth.standard_uncertainty or 0.0, default=None)


def _used(
    name: Literal["pin_wear_depth", "pin_scar_diameter", "disc_wear_depth"], value: EndValue | None, default: float
) -> EndValueUsed | None:
    if value is None:
        return None
    plain = Quantity(value=value.value, unit=value.unit, standard_uncertainty=value.standard_uncertainty)
    return EndValueUsed(name, *stated_or_default(plain, default))
