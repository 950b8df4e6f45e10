"""Results of wear predictions, and the curves of a law along a run, fitted or predicted, for any contact."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from pydantic import Field

from tribopipe.base.arrays import Column
from tribopipe.base.units import WEAR_COEFFICIENT
from tribopipe.documents.contact_kinds import spoken
from tribopipe.documents.quantity import Newtons, Quantity, SquareMetresPerNewton, force
from tribopipe.documents.recipe import LawName
from tribopipe.documents.record import Record
from tribopipe.physics.calculation_methods import DistanceConvention, WearEngine
from tribopipe.results.wear_fit import HertzStart, LawValue, WearFit, by

Outcome = Literal[
    "depth",
    "curved_depth",
    "flat_depth",
    "curved_volume",
    "flat_volume",
    "half_width",
    "half_length",
    "pressure",
]
OUTCOMES: dict[Outcome, str] = {
    "depth": "m",
    "curved_depth": "m",
    "flat_depth": "m",
    "curved_volume": "m^3",
    "flat_volume": "m^3",
    "half_width": "m",
    "half_length": "m",
    "pressure": "Pa",
}
"""Quantities of a law along a run, with their SI units."""


class PredictedBody(Record):
    """Wear of one body at one position."""

    wear_depth: Quantity
    """Wear depth at the center of the contact."""
    wear_depth_edge: Quantity | None = None
    """Wear depth at the two sides of a flat pin, outside the groove; only for flat pins."""
    wear_volume: Quantity | None = None
    """Wear volume; None if only the depth is predicted."""
    track_cross_section: Quantity | None = None
    """Cross-section of the groove in the counterbody; None if there is no groove."""

    def __str__(self) -> str:
        volume = "" if self.wear_volume is None else f", wear volume {self.wear_volume.shown('mm^3')}"
        return f"wear depth {self.wear_depth.shown('um')}{volume}"


class PredictedContact(Record):
    """Contact of the bodies at one position."""

    approach: Quantity
    """Total wear depth of all predicted bodies, as measured by a displacement sensor."""
    half_width: Quantity
    """Half width of the contact across sliding; the radius of a round one."""
    half_length: Quantity
    """Half length of the contact along sliding."""
    mean_pressure: Quantity
    """Load over the area of the contact."""


class PredictedPoint(Record):
    """Both bodies and their contact at one position in a test."""

    sliding_distance: Quantity
    """Sliding distance; for rolling bodies the slip distance."""
    rotations: Quantity | None = None
    """Number of rotations of the first body; only for rolling bodies."""
    time: Quantity | None = None
    """Time at the nominal speed; None if the speed is unknown."""
    bodies: dict[str, PredictedBody]
    """Wear of each body."""
    contact: PredictedContact
    """Contact."""
    slip: Quantity | None = None
    """(v₂ − v₁)/v₁ of the worn bodies; only for rolling bodies."""

    def __str__(self) -> str:
        place = self.sliding_distance.shown("m") if self.rotations is None else f"{self.rotations} rotations"
        when = "" if self.time is None else f" ({self.time.shown('s')})"
        return f"{place}{when}: {'; '.join(f'{spoken(name)} {body}' for name, body in self.bodies.items())}"


class UsedCoefficient(Record):
    """k_D of one body that wear is predicted with."""

    wear_coefficient: SquareMetresPerNewton
    """k_D."""


class WearPrediction(Record):
    """Wear during a test, predicted from a known k_D."""

    model: LawName
    """Wear law."""
    engine: WearEngine = "giwm"
    """Pressure that k_D is right with: even, as the Global Incremental Wear Model has it, or local."""
    scheme: Literal["exact", "published"]
    """The limit of small steps, or the paper's explicit Euler steps."""
    distance_per_rotation: DistanceConvention | None = None
    """Convention for the sliding distance in one rotation; None for bodies that do not roll."""
    bodies: dict[str, UsedCoefficient]
    """k_D of each body; a body without k_D does not wear."""
    reference: str | None = None
    """Run that k_D was identified from; None if k_D was given."""
    normal_load: Newtons
    """F_N predicted for."""
    conditions: dict[str, Quantity] = Field(default_factory=dict)
    """Other conditions of the prediction, if different from the run, such as the tip radius or the slip."""
    start: HertzStart | None = None
    """Contact of the unworn bodies by Hertz, where the published scheme starts from it."""
    steps: int | None = None
    """Number of Euler steps of the published scheme."""
    step_error: float | None = None
    """Relative error of the last depth by the finite step of the published scheme."""
    notes: tuple[str, ...] = ()
    """Notes and warnings."""
    prediction: tuple[PredictedPoint, ...] = ()
    """The requested positions, in the order of the request."""
    reached: tuple[PredictedPoint, ...] = ()
    """Positions at which wanted depths of the first body are reached, in the order of the request."""
    parameters: tuple[LawValue, ...] | None = None
    """Parameters of the law in addition to k_D; None if it has none."""

    @property
    def first(self) -> UsedCoefficient:
        """The body whose k_D is always known."""
        return next(iter(self.bodies.values()))

    def __str__(self) -> str:
        counted = "" if self.distance_per_rotation is None else f", {self.distance_per_rotation}"
        used = (
            f"{spoken(name)} k_D = {body.wear_coefficient.shown(WEAR_COEFFICIENT)}"
            for name, body in self.bodies.items()
        )
        others = (f"{spoken(name)} {one.shown(CONDITION_UNITS[one.unit])}" for name, one in self.conditions.items())
        head = f"{self.model}{by(self.engine)}, {self.scheme}{counted}: "
        lines = [head + ", ".join([*used, f"normal load {force(self.normal_load)}", *others])]
        return "\n".join([*lines, *(f"  {line}" for line in (*self.prediction, *self.reached, *self.notes))])


CONDITION_UNITS = {"m": "mm", "1": "%"}
"""Units in which people read sizes and ratios."""


@dataclass(frozen=True)
class Band:
    """A value at each sample, and its 95 % band."""

    best: Column
    lower: Column
    upper: Column
    unit: str = field(kw_only=True)
    """SI."""


@dataclass(frozen=True)
class WearCurves:
    """Wear and contact along a run by a law."""

    result: WearFit | WearPrediction
    bands: Mapping[str, Band]
    """Bands by quantity: ``wear_depth`` of a pin, ``depth``, ``curved_volume`` and so on of two discs."""
