"""Input quantities of k_D: each number with its standard uncertainty and who stated it, and its label and unit.

Results keep the names of inputs, such as ``pin end value``; only what people read has the labels.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, NamedTuple

from tribopipe.base.units import WEAR_COEFFICIENT, force_unit
from tribopipe.documents.contact_kinds import spoken
from tribopipe.documents.quantity import Quantity

Source = Literal["manifest", "default"]
"""Source of a standard uncertainty: the lab in run.toml, or the recipe."""


@dataclass(frozen=True)
class Input:
    """One number that wear depends on."""

    quantity: Quantity
    source: Literal["manifest", "default", "fit", "recipe"]
    above_zero: bool = False
    """Whether it must be, or below zero if its best estimate is: a draw with the other sign is drawn again."""
    factors: tuple[tuple[str, Quantity], ...] = ()
    """Names and values of factors whose standard uncertainty is a default; empty for an input that is no product."""

    @property
    def spread(self) -> float:
        """Standard uncertainty."""
        return self.quantity.u_or_zero


Inputs = Mapping[str, Input]


def best_values(inputs: Inputs) -> dict[str, float]:
    """Return the best estimate of each input."""
    return {name: given.quantity.value for name, given in inputs.items()}


def stated_or_default(quantity: Quantity, default: float) -> tuple[Quantity, Source]:
    """Give a quantity the default standard uncertainty where the manifest states none."""
    if quantity.standard_uncertainty is not None:
        return quantity, "manifest"
    return quantity.model_copy(update={"standard_uncertainty": default}), "default"


def relative_input(quantity: Quantity, share: float, *, above_zero: bool = False) -> Input:
    """Return a quantity as an input; a missing standard uncertainty is set to a fraction of the value."""
    return Input(*stated_or_default(quantity, share * abs(quantity.value)), above_zero)


class InputQuantity(NamedTuple):
    """Label and unit of an input quantity."""

    label: str
    unit: str | None = None
    """None for forces, whose unit depends on their size, and for inputs without a value."""


_QUANTITIES: Mapping[str, InputQuantity] = {
    "normal_load": InputQuantity("normal load"),
    "pin_radius": InputQuantity("radius of the pin", "mm"),
    "crown_radius": InputQuantity("crown radius", "mm"),
    "curved_radius": InputQuantity("rolling radius of the crowned disc", "mm"),
    "flat_radius": InputQuantity("rolling radius of the cylindrical disc", "mm"),
    "curved_modulus": InputQuantity("Young's modulus of the crowned disc", "GPa"),
    "flat_modulus": InputQuantity("Young's modulus of the cylindrical disc", "GPa"),
    "slip": InputQuantity("slip", "%"),
    "sliding_speed": InputQuantity("sliding speed", "mm/s"),
    "track_radius": InputQuantity("radius of the wear track", "mm"),
    "stroke": InputQuantity("stroke", "mm"),
    "rotational_speed": InputQuantity("rotational speed", "rpm"),
    "frequency": InputQuantity("frequency", "Hz"),
    "track_length": InputQuantity("length of the wear track", "mm"),
    "depth_scale": InputQuantity("scale of the depth sensor", "1"),
    "pin_end_value": InputQuantity("post-test measurement of the pin", "um"),
    "disc_end_value": InputQuantity("wear depth of the disc", "nm"),
    "unseen_groove": InputQuantity("unmeasured wear of the disc"),
    "pressure_distribution": InputQuantity("effect of the contact pressure distribution"),
    "zero_offset": InputQuantity("zero offset of the depth sensor", "um"),
    "end_reading": InputQuantity("final depth reading", "um"),
    "friction_fit": InputQuantity("fitted friction coefficient"),
    "running_in_distance": InputQuantity("running-in distance", "m"),
    "wear_coefficient": InputQuantity("wear coefficient", WEAR_COEFFICIENT),
}
_PATTERNS: Mapping[re.Pattern[str], InputQuantity] = {
    re.compile(r"(?P<body>.+)_modulus"): InputQuantity("Young's modulus of the {body}", "GPa"),
    re.compile(r"(?P<body>.+)_end_value"): InputQuantity("post-test measurement of the {body}", "um"),
    re.compile(r"(?P<body>.+)_value(?P<at>_at_interruption_\d+)"): InputQuantity("measurement of the {body}{at}", "um"),
    re.compile(r"(?P<body>.+)_wear_volume(?P<at>_at_interruption_\d+)?"): InputQuantity(
        "wear volume of the {body}{at}", "mm^3"
    ),
    re.compile(r"(?P<body>.+)_volume_scale"): InputQuantity("dimensions and density of the {body}", "1"),
    re.compile(r"(?P<body>.+)_unseen_groove"): InputQuantity("unmeasured groove in the counterbody of the {body}", "1"),
    re.compile(r"(?P<body>.+)_wear_depth(?P<at>_at_interruption_\d+)?"): InputQuantity(
        "wear depth of the {body}{at}", "um"
    ),
    re.compile(r"(?P<body>.+)_track_width(?P<at>_at_interruption_\d+)?"): InputQuantity(
        "track width of the {body}{at}", "um"
    ),
    re.compile(r"law_(?P<parameter>.+)"): InputQuantity("law parameter {parameter}"),
}
"""Inputs named after a body, of any contact, or after a parameter of any wear law."""


def input_label(name: str) -> str:
    """Return the label of an input of k_D: "post-test measurement of the pin" for ``pin end value``."""
    return _quantity(name).label


def shown_unit(name: str, value: Quantity) -> str | None:
    """Return the unit in which people read an input; for a post-test measurement, it depends on what was measured."""
    if value.unit == "m^3":
        return "mm^3"
    return force_unit(value.value) if value.unit == "N" else _quantity(name).unit


def _quantity(name: str) -> InputQuantity:
    key = name.replace(" ", "_")
    if key in _QUANTITIES:
        return _QUANTITIES[key]
    for pattern, quantity in _PATTERNS.items():
        if match := pattern.fullmatch(key):
            parts = {part: spoken(text or "") for part, text in match.groupdict().items()}
            return quantity._replace(label=quantity.label.format(**parts))
    return InputQuantity(spoken(key))
