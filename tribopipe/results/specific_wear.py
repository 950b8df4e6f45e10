"""Wear volume and specific wear rate of each body of a run, by what was measured on it.

Post-test measurements are put in words from their keys under ``[end_values]``.
"""

import re
from typing import Literal

from tribopipe.base.units import SPECIFIC_WEAR_RATE
from tribopipe.documents.contact_kinds import ROLES, spoken
from tribopipe.documents.quantity import CubicMetres, Metres, Newtons, Quantity, SquareMetresPerNewton
from tribopipe.documents.record import Record

_KEY = re.compile(
    r"(?P<body>\w+?)_"
    r"(?P<measured>wear_depth|wear_volume|mass_loss|profile|height_map|height_map_difference|profile_difference|"
    r"track_width|track_area|"
    r"scar_diameter|scar_length|scar_width)"
)


def measured_quantity(key: str) -> str:
    """Return what was measured: "scar diameter" for ``pin_scar_diameter``."""
    match = _KEY.fullmatch(key)
    return spoken(match["measured"] if match else key)


def measured_quantities(anchor: str) -> str:
    """Return measurements, joined by " + ", with their bodies: "scar diameter of the pin and profile of the disc"."""
    return " and ".join(map(_with_body, anchor.split(" + ")))


def _with_body(key: str) -> str:
    match = _KEY.fullmatch(key)
    return f"{spoken(match['measured'])} of the {spoken(match['body'])}" if match else spoken(key)


class MeasuredWear(Record):
    """Wear of one body by one post-test measurement."""

    by: str
    """Name of the post-test measurement."""
    depth: Quantity | None = None
    """Wear depth; None if this post-test measurement does not determine it."""
    volume: Quantity | None = None
    """Wear volume; None if this post-test measurement does not determine it."""


class WearInterval(Record):
    """Wear of one body between two measurements."""

    start: Metres
    """Sliding distance at its beginning."""
    end: Metres
    """Sliding distance at its end."""
    volume: CubicMetres
    """Volume lost in it."""
    specific_wear_rate: SquareMetresPerNewton
    """Specific wear rate from that volume and the load and sliding distance in it."""


class BodyWearRate(Record):
    """Wear of one body at the end of a run."""

    depth: Metres | None = None
    """Height lost, by the most certain post-test measurement."""
    depth_by: str | None = None
    """Name of that post-test measurement."""
    volume: CubicMetres | None = None
    """Volume lost, by the most certain post-test measurement."""
    volume_by: str | None = None
    """Name of that post-test measurement."""
    specific_wear_rate: SquareMetresPerNewton | None = None
    """Volume over normal load and sliding distance, k = V/(F_N·s)."""
    measured: tuple[MeasuredWear, ...] = ()
    """Everything measured on the body, as depth and volume."""
    intervals: tuple[WearInterval, ...] = ()
    """Wear between one measurement and the next, where the test was interrupted."""
    steady_rate: SquareMetresPerNewton | None = None
    """Specific wear rate after running-in: slope of volume over ∫F_N ds; requires at least four measurements."""
    steady_from: Metres | None = None
    """Sliding distance at which running-in is over."""
    steady_deviation: float | None = None
    """Overall minus steady rate, divided by the standard uncertainty of the difference."""

    def __str__(self) -> str:
        if self.volume is None or self.specific_wear_rate is None:
            return "no wear volume" if self.depth is None else f"wear depth {self.depth.shown('um')}, no wear volume"
        rate = self.specific_wear_rate.shown(SPECIFIC_WEAR_RATE)
        depth = "" if self.depth is None else f", wear depth {self.depth.shown('um')}"
        steady = "" if self.steady_rate is None else f", steady {self.steady_rate.shown(SPECIFIC_WEAR_RATE)}"
        by = "" if self.volume_by is None else f" from the {measured_quantity(self.volume_by)}"
        return f"{rate}{steady}, wear volume {self.volume.shown('mm^3')}{by}{depth}"


class SpecificWear(Record):
    """Specific wear rate of a run: what each body has lost, over load and distance."""

    outcome: Literal["evaluated", "not evaluated"]
    """Not evaluated if no wear volume is known."""
    notes: tuple[str, ...] = ()
    """Missing inputs and assumptions."""
    sliding_distance: Metres | None = None
    """Sliding distance at the end; of two discs, the distance they slipped on each other."""
    normal_load: Newtons | None = None
    """Mean normal load over that distance."""
    load: Literal["measured", "nominal"] | None = None
    """Whether the load was recorded, or is as run.toml states it."""
    pin: BodyWearRate | None = None
    """The pin."""
    disc: BodyWearRate | None = None
    """The disc on which a pin slides."""
    curved_disc: BodyWearRate | None = None
    """The crowned disc."""
    flat_disc: BodyWearRate | None = None
    """The cylindrical disc."""
    total: SquareMetresPerNewton | None = None
    """Specific wear rate of both bodies together; None if the volume of one is unknown."""

    @property
    def bodies(self) -> dict[str, BodyWearRate]:
        """What is known of each body, by its name."""
        found = {name: getattr(self, name) for name in ROLES}
        return {name: body for name, body in found.items() if body is not None}

    def __str__(self) -> str:
        told = [f"{spoken(name)}: {body}" for name, body in self.bodies.items()]
        if self.total is not None:
            told.append(f"both: {self.total.shown(SPECIFIC_WEAR_RATE)}")
        return "; ".join(["specific wear rate", *told, *self.notes] if told else ["no specific wear rate", *self.notes])
