"""What fits and predictions of twin-disc runs return."""

from typing import Literal

from tribopipe.base.units import WEAR_COEFFICIENT
from tribopipe.documents.contact import DiscName
from tribopipe.documents.quantity import (
    Metres,
    Newtons,
    Number,
    Pascals,
    Quantity,
    SquareMetresPerNewton,
    between,
    force,
    in_both_units,
)
from tribopipe.documents.recipe import FrictionSource, LawName
from tribopipe.documents.record import Record
from tribopipe.physics.conventions import DistanceConvention
from tribopipe.results.evaluation import Contribution, MonteCarlo

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


class DiscCoefficient(Record):
    """k_D of one disc of a pair."""

    disc: DiscName
    """Which disc."""
    wear_coefficient: SquareMetresPerNewton
    """k_D with its combined standard uncertainty."""
    interval: tuple[SquareMetresPerNewton, SquareMetresPerNewton]
    """95 % coverage interval of k_D by Monte Carlo; to first order where none was drawn."""
    budget: tuple[Contribution, ...] = ()
    """What the combined standard uncertainty is made of, to first order."""
    monte_carlo: MonteCarlo | None = None
    """How the interval was drawn."""

    def __str__(self) -> str:
        found, interval = in_both_units(self.wear_coefficient), between(self.interval, WEAR_COEFFICIENT)
        return f"{spoken(self.disc)} k_D = {found}, 95 % interval {interval}"


class HertzStart(Record):
    """Contact of the unworn discs by Hertz."""

    half_width: Metres
    """a_x."""
    half_length: Metres
    """a_z."""
    peak_pressure: Pascals
    """p₀, 1.5 times the mean pressure."""


class FittedValue(Record):
    """One thing measured on a disc beside what the fitted law says of it."""

    name: str
    """What was measured, on which disc, and when."""
    rotations: float
    """Rotations of the curved disc until then."""
    measured: Quantity
    """As measured."""
    fitted: Quantity
    """By the law."""


class ConventionCoefficients(Record):
    """k_D by which another way of counting the distance slid would reach the same end."""

    distance_per_rotation: DistanceConvention
    """The other way."""
    curved_disc: Quantity
    """k_D of the curved disc."""
    flat_disc: Quantity
    """k_D of the flat disc."""


class TwinDiscFit(Record):
    """Dimensional wear coefficients of both discs of one run, found together."""

    model: LawName
    """Wear law."""
    outcome: Literal["fitted", "not fitted"]
    """Not fitted where the run lacks what the fit needs."""
    distance_per_rotation: DistanceConvention
    """What counts as slid in one rotation."""
    lacks: tuple[str, ...] = ()
    """What the run lacks for a fit."""
    notes: tuple[str, ...] = ()
    """What to beware of, the defaults used among it."""
    start: HertzStart | None = None
    """Contact of the unworn discs by Hertz."""
    curved_disc: DiscCoefficient | None = None
    """k_D of the curved disc."""
    flat_disc: DiscCoefficient | None = None
    """k_D of the flat disc; none where nothing was measured on it, so that it counts as unworn."""
    correlation: float | None = None
    """Of both k_D."""
    friction: FrictionSource | None = None
    """Which μ Sarkar's law was given."""
    measurements: tuple[FittedValue, ...] = ()
    """Everything that was fitted."""
    p_value: float | None = None
    """Probability of as much disagreement under the law (χ²); none where there are no more values than unknowns."""
    equivalents: tuple[ConventionCoefficients, ...] = ()
    """The other ways of counting, so that k_D can be compared."""

    @property
    def coefficients(self) -> tuple[DiscCoefficient, ...]:
        """Those that were found, the curved disc's first."""
        return tuple(found for found in (self.curved_disc, self.flat_disc) if found is not None)

    def __str__(self) -> str:
        if not self.coefficients:
            return f"{self.model}: no wear coefficients: the run lacks {' and '.join(self.lacks)}"
        return f"{self.model}, {self.distance_per_rotation}: {'; '.join(map(str, self.coefficients))}"


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


def spoken(name: str) -> str:
    """Write a key as words: "curved disc"."""
    return name.replace("_", " ")
