"""What predictions of wear find: the wear of each body from a known k_D."""

from typing import Literal

from tribopipe.base.units import WEAR_COEFFICIENT
from tribopipe.documents.quantity import Metres, Newtons, Number, Quantity, SquareMetresPerNewton, force
from tribopipe.documents.recipe import LawName
from tribopipe.documents.record import Record
from tribopipe.physics.conventions import DistanceConvention, WearEngine
from tribopipe.results.wear_fit import HertzStart, LawValue, by

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
"""What a law says along a run, in SI."""


class PredictedPoint(Record):
    """State of the pin at one sliding distance."""

    sliding_distance: Quantity
    """Where."""
    time: Quantity | None = None
    """When, at the sliding speed; none where the speed is not known."""
    wear_depth: Quantity
    """Height worn off the pin."""
    contact_radius: Quantity
    """Radius of the contact."""
    pressure: Quantity
    """Mean contact pressure p = F_N/(πa²)."""


class WearPrediction(Record):
    """Wear depth against sliding distance from a known k_D."""

    model: LawName
    """Wear law."""
    engine: WearEngine = "giwm"
    """Pressure on the pin: even, as the Global Incremental Wear Model has it, or local."""
    scheme: Literal["exact", "published"]
    """Closed form, or the paper's explicit Euler steps."""
    wear_coefficient: SquareMetresPerNewton
    """k_D used."""
    reference: str | None = None
    """Run that k_D was identified from; none where it was given."""
    normal_load: Newtons
    """F_N predicted for."""
    pin_radius: Metres
    """R_P predicted for."""
    steps: int | None = None
    """Number of Euler steps of the published scheme."""
    step_error: float | None = None
    """Relative error of the last depth by the finite step of the published scheme."""
    notes: tuple[str, ...] = ()
    """What to beware of."""
    prediction: tuple[PredictedPoint, ...] = ()
    """The wanted distances in the order asked for."""
    reached: tuple[PredictedPoint, ...] = ()
    """Where wanted depths are reached, in the order asked for."""
    parameters: tuple[LawValue, ...] | None = None
    """Parameters of the law beside k_D; none where it has none."""

    def __str__(self) -> str:
        lines = [
            f"{self.model}{by(self.engine)}, {self.scheme}: k_D = {self.wear_coefficient.shown(WEAR_COEFFICIENT)}, "
            f"F_N = {force(self.normal_load)}, R_P = {self.pin_radius.shown('mm')}"
        ]
        for point in (*self.prediction, *self.reached):
            when = "" if point.time is None else f" ({point.time.shown('s')})"
            lines.append(f"  {point.sliding_distance.shown('m')}{when}: {point.wear_depth.shown('um')}")
        return "\n".join([*lines, *(f"  {note}" for note in self.notes)])


class DiscPoint(Record):
    """State of two discs after some rotations of the curved one."""

    rotations: Quantity
    """Of the curved disc."""
    sliding_distance: Quantity
    """Slip distance until then."""
    time: Quantity | None = None
    """When, at the speed of the curved disc; none where that is not known."""
    wear_depth: Quantity
    """h₁ + h₂, what a displacement sensor sees."""
    curved_disc_wear_depth: Quantity
    """h₁."""
    flat_disc_wear_depth: Quantity
    """h₂."""
    curved_disc_wear_volume: Quantity
    """V₁."""
    flat_disc_wear_volume: Quantity
    """V₂."""
    half_width: Quantity
    """a_x: half the width of the track."""
    half_length: Quantity
    """a_z."""
    pressure: Quantity
    """Mean contact pressure p."""
    slip: Quantity
    """(v₂ − v₁)/v₁ of the worn discs."""


class TwinDiscPrediction(Record):
    """Wear of two discs against rotations from known k_D."""

    model: LawName
    """Wear law."""
    scheme: Literal["exact", "published"]
    """The limit of small steps, or the paper's explicit ones."""
    distance_per_rotation: DistanceConvention
    """What counts as slid in one rotation."""
    curved_disc_wear_coefficient: SquareMetresPerNewton
    """k_D of the curved disc."""
    flat_disc_wear_coefficient: SquareMetresPerNewton
    """k_D of the flat disc; 0 where it does not wear."""
    reference: str | None = None
    """Run that k_D was identified from; none where it was given."""
    normal_load: Newtons
    """F_N predicted for."""
    slip: Number
    """(v₂ − v₁)/v₁ predicted for."""
    start: HertzStart
    """Contact of the unworn discs by Hertz, where the published scheme starts."""
    steps: int | None = None
    """Number of Euler steps of the published scheme."""
    step_error: float | None = None
    """Relative error of the curved disc's last depth by the finite step of the published scheme."""
    notes: tuple[str, ...] = ()
    """What to beware of."""
    prediction: tuple[DiscPoint, ...] = ()
    """The wanted rotations in the order asked for."""
    reached: tuple[DiscPoint, ...] = ()
    """Where wanted depths of the curved disc are reached, in the order asked for."""

    def __str__(self) -> str:
        lines = [
            f"{self.model}, {self.scheme}, {self.distance_per_rotation}: k_D = "
            f"{self.curved_disc_wear_coefficient.shown(WEAR_COEFFICIENT)} (curved disc), "
            f"{self.flat_disc_wear_coefficient.shown(WEAR_COEFFICIENT)} (flat disc), F_N = {force(self.normal_load)}, "
            f"slip {self.slip.shown('%')}"
        ]
        for point in (*self.prediction, *self.reached):
            when = "" if point.time is None else f" ({point.time.shown('s')})"
            lines.append(
                f"  {point.rotations} rotations{when}: {point.curved_disc_wear_depth.shown('um')} and "
                f"{point.flat_disc_wear_depth.shown('um')} deep, {point.curved_disc_wear_volume.shown('mm^3')} and "
                f"{point.flat_disc_wear_volume.shown('mm^3')} worn off"
            )
        return "\n".join([*lines, *(f"  {note}" for note in self.notes)])
