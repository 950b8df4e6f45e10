"""Results of local wear of a run: the wear of the surface, compared with the Global Incremental Wear Model."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import ClassVar, NamedTuple

from tribopipe.base.arrays import Column
from tribopipe.base.units import WEAR_COEFFICIENT
from tribopipe.documents.contact_kinds import spoken
from tribopipe.documents.quantity import Metres, Newtons, Quantity, SquareMetresPerNewton, force
from tribopipe.documents.recipe import LawName
from tribopipe.documents.record import Record
from tribopipe.physics.calculation_methods import Course, Engine
from tribopipe.physics.local.course import LocalWear
from tribopipe.results.wear_prediction import PredictedBody, PredictedPoint


class LocalPoint(Record):
    """Values of any contact at one point of the test."""

    wear_depth: Quantity
    """Wear depth of the deepest point: of the pin, or of both bodies together where both wear."""
    peak_pressure: Quantity
    """Largest contact pressure; in a worn contact it is at the edge, and depends on the grid."""
    middle_pressure: Quantity
    """Contact pressure at the center."""
    mean_pressure: Quantity
    """Normal load over the area in contact."""
    giwm_depth: Quantity
    """Wear depth by the model with uniform pressure and the same k_D: the Global Incremental Wear Model, or for a pin
    on a counterbody that wears the engine volume."""
    difference: float | None
    """Wear depth divided by that of the GIWM or of the engine volume, minus 1; None without wear."""

    uniform: ClassVar[str] = "GIWM"
    """Name of the model with uniform pressure."""

    @property
    def depths(self) -> str:
        """Both depths, as people read them."""
        more = "" if self.difference is None else f" ({100 * self.difference:+.2f} %)"
        return f"{self.wear_depth.shown('um')}{more}, {self.uniform} {self.giwm_depth.shown('um')}"


class LocalPinPoint(LocalPoint):
    """A pin after sliding some distance."""

    sliding_distance: Quantity
    """Sliding distance."""
    contact_radius: Quantity
    """Radius of the contact."""
    wear_volume: Quantity
    """Wear volume of the pin."""

    def __str__(self) -> str:
        return (
            f"{self.sliding_distance.shown('m')}: {self.depths}; a = {self.contact_radius.shown('um')}, "
            f"p = {self.middle_pressure.shown('MPa')} (center), {self.mean_pressure.shown('MPa')} (mean)"
        )


class LocalPairPoint(LocalPoint):
    """A pin and the counterbody, both of which wear, after sliding some distance."""

    sliding_distance: Quantity
    """Sliding distance."""
    half_width: Quantity
    """Half-width of the scar, across the sliding direction."""
    half_length: Quantity
    """Half-length of the scar, along it."""
    bodies: dict[str, PredictedBody]
    """Wear of each body."""
    uniform_pressure: PredictedPoint
    """Both bodies by the engine volume, which has uniform pressure and rigid bodies, with the same k_D."""

    uniform: ClassVar[str] = "uniform pressure"

    def __str__(self) -> str:
        bodies = "".join(
            f"\n    {spoken(name)}: {self.bodies[name]}; {self.uniform} {other.wear_depth.shown('um')}"
            for name, other in self.uniform_pressure.bodies.items()
        )
        return (
            f"{self.sliding_distance.shown('m')}: {self.depths} (both bodies); scar half-width = "
            f"{self.half_width.shown('um')}, half-length = {self.half_length.shown('um')}, p = "
            f"{self.middle_pressure.shown('MPa')} (center), {self.mean_pressure.shown('MPa')} (mean){bodies}"
        )


class LocalDiscPoint(LocalPoint):
    """Two discs after some rotations of the crowned one."""

    rotations: Quantity
    """Rotations of the crowned disc."""
    slip_rotations: Quantity
    """Rotations of one disc relative to the other (Eq. 9): rotations times slip."""
    half_width: Quantity
    """a_x: half the width of the contact, across the direction of rolling."""
    half_length: Quantity
    """a_z: half its length along it."""
    curved_disc_wear_depth: Quantity
    """The crowned disc's part of the depth."""
    flat_disc_wear_depth: Quantity
    """The cylindrical disc's part of it."""
    curved_disc_wear_volume: Quantity
    """Wear volume of the crowned disc."""
    flat_disc_wear_volume: Quantity
    """Wear volume of the cylindrical disc."""

    def __str__(self) -> str:
        return (
            f"{self.rotations} rotations, {self.slip_rotations} slip rotations: {self.depths}; a_x = "
            f"{self.half_width.shown('um')}, a_z = {self.half_length.shown('um')}, p = "
            f"{self.middle_pressure.shown('MPa')} (center), {self.mean_pressure.shown('MPa')} (mean)"
        )


class LocalWearResult(Record):
    """Local wear against sliding distance, or rotations, from a known k_D."""

    model: LawName
    """Wear law."""
    engine: Engine
    """Engine that solves the contact."""
    scheme: Course
    """Whether pressure at the end of a step wears the surface, or that before it as in the paper; or, by economy, that
    of a contact that is corrected rather than solved again."""
    wear_coefficient: SquareMetresPerNewton
    """k_D of the pin, or of the crowned disc, as V = k_D·F_N·s has it."""
    flat_disc_wear_coefficient: SquareMetresPerNewton | None = None
    """k_D of the cylindrical disc; only for discs."""
    track_wear_coefficient: SquareMetresPerNewton | None = None
    """k_D of the counterbody of a pin; None if it does not wear."""
    reference: str | None = None
    """Run that k_D was identified from; None if k_D was given."""
    normal_load: Newtons
    """F_N."""
    steps_per_decade: int
    """Wear steps for each power of ten in the amount of wear; explicit ones are divided where they have to be."""
    update_mesh_every: int
    """Steps after which elasticity was computed for the worn shape, where the engine's depends on it; by economy,
    increments after which the contact was solved as well, 0 for never."""
    stress_loss: float = 0.0
    """Share of its stresses that an increment of the economy was taken to lose."""
    grid: tuple[int, ...]
    """Number of points from the axis outwards, or across and along the contact."""
    finest: Metres
    """Least distance between neighboring points."""
    notes: tuple[str, ...] = ()
    """Notes and warnings."""
    points: tuple[LocalPinPoint | LocalPairPoint | LocalDiscPoint, ...] = ()
    """The requested positions, in the order of the request."""

    @property
    def pair(self) -> tuple[str, ...]:
        """Names of a pin and of its counterbody, both of which wear; empty for other bodies."""
        return next((tuple(one.bodies) for one in self.points if isinstance(one, LocalPairPoint)), ())

    def told(self, notes: Iterable[str]) -> "LocalWearResult":
        """Return the result with more notes."""
        return self.model_copy(update={"notes": (*self.notes, *notes)})

    def __str__(self) -> str:
        flat, track = self.flat_disc_wear_coefficient, self.track_wear_coefficient
        both = "" if flat is None else f" (crowned disc), {flat.shown(WEAR_COEFFICIENT)} (cylindrical disc)"
        if track is not None and self.pair:
            first, second = map(spoken, self.pair)
            both = f" ({first}), {track.shown(WEAR_COEFFICIENT)} ({second})"
        head = (
            f"{self.model}, {self.engine}, {self.scheme}: k_D = {self.wear_coefficient.shown(WEAR_COEFFICIENT)}{both}, "
            f"F_N = {force(self.normal_load)}"
        )
        return "\n".join([head, *(f"  {point}" for point in self.points), *(f"  {note}" for note in self.notes)])


class GlobalWear(NamedTuple):
    """The Global Incremental Wear Model along the same course."""

    depth: Column
    """m."""
    pressure: Column
    """Mean pressure, Pa."""
    half_width: Column
    """a or a_x, m."""
    half_length: Column
    """a or a_z, m."""


@dataclass(frozen=True)
class LocalCurves:
    """Local wear along sliding distance or rotations, and the GIWM next to it."""

    result: LocalWearResult
    along: Column
    """Sliding distance, m, or rotations of the crowned disc; the first is 0."""
    course: LocalWear
    gap: Column
    """Distance of each point of the unworn surface from the plane that touches it, m."""
    mean_pressure: Column
    """Normal load over the area in contact, Pa."""
    giwm: Mapping[str, GlobalWear]
    """As ``giwm``; of discs that conserves volume, and stands next to it ``giwm_as_printed``. For a pin on a
    counterbody that wears, it is the engine volume."""
    track: Mapping[str, Column] = field(default_factory=dict)
    """Wear of the counterbody of a pin: ``track_depth``, m, ``track_section``, m², and ``giwm_track_depth``, m."""

    @property
    def discs(self) -> bool:
        """Whether two discs wear, rather than a pin."""
        return self.result.flat_disc_wear_coefficient is not None

    @property
    def middle_pressure(self) -> Column:
        """Contact pressure at the center, Pa."""
        return self.course.middle_pressure
