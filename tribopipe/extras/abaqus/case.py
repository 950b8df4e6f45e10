"""Input of a subroutine: contact, motion of the bodies, wear law, and k_D with its source.

The surface is moved explicitly, increment by increment. A wave of wear whose length is two elements, 2h, changes the
pressure by πE_c/(2h) times its height on a half space. With the rate dw/dt = k_D·f·v·p of a pin, an increment leaves 1
− k_D·f·v·(πE_c/2h)·Δt of it, which grows in turns of sign beyond

Δt = (4/π)·h / (k_D·f·v·E_c).

Of discs all points of a streamline wear alike, at k_D·f·n·∫p dl with n slip rotations per time (Eq. 9), so that n
times the length of the contact, 2a_z, takes the place of v, and h is the width of an element across the direction of
rolling. 1.2 in the place of 4/π leaves a margin.

`Example` has nodes under the pressure of the unworn contact, as an example of what drives a subroutine.
"""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from tribopipe.base.arrays import Column
from tribopipe.base.errors import ContactError, FitError
from tribopipe.base.units import WEAR_COEFFICIENT, show
from tribopipe.documents.contact import ROTATIONS, SLIDING, Contact
from tribopipe.documents.contact_kinds import spoken
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import LawName
from tribopipe.evaluation.wear.local import ARCHARDS, archards_wear
from tribopipe.evaluation.wear.scenario import known_wear
from tribopipe.extras.abaqus.fortran import in_mm
from tribopipe.physics.friction_path import ExponentialFriction, junction_factor
from tribopipe.physics.hertz import hertz_ellipse
from tribopipe.results.wear_fit import WearFit

_STEPS = 10
_REACH = 1.2
"""Extent of the nodes, relative to the contact radius."""


@dataclass(frozen=True)
class UnwornContact:
    """The contact that wear starts from: Hertz's, or that of a flat end under uniform pressure."""

    half_width: float
    """m; across the direction of rolling."""
    half_length: float
    """m; along it."""
    peak_pressure: float
    """Pa."""
    even: bool = False

    def pressure(self, across: Column, along: Column) -> Column:
        """Return the pressure at places from the middle, m, in Pa."""
        inside = 1 - (across / self.half_width) ** 2 - (along / self.half_length) ** 2
        profile = np.sign(np.maximum(inside, 0.0)) if self.even else np.sqrt(np.maximum(inside, 0.0))
        return np.asarray(self.peak_pressure * profile)


@dataclass(frozen=True)
class Example:
    """Nodes 1, 2, … of a contact surface; the first is in the middle, or on the streamline through it."""

    pressure: Column
    """Pa."""
    streamline: NDArray[np.int64]
    """Streamline number of each node: 1, 2, …; under a pin, each node has its own streamline."""
    length: Column
    """Length of streamline that each node represents, m."""


def _across(start: UnwornContact) -> Column:
    return np.linspace(0.0, _REACH, 2 * _STEPS + 1) * start.half_width


def along_a_radius(start: UnwornContact) -> Example:
    """Return nodes along a radius of a round contact."""
    radius = _across(start)
    numbers = np.arange(1, radius.size + 1)
    return Example(start.pressure(radius, np.zeros_like(radius)), numbers, np.zeros_like(radius))


def on_streamlines(start: UnwornContact) -> Example:
    """Return nodes on streamlines across half of the contact of two discs."""
    across = _across(start)[::4]
    along = np.linspace(-_REACH, _REACH, 2 * _STEPS + 1) * start.half_length
    x, z = np.meshgrid(across, along, indexing="ij")
    numbers = np.repeat(np.arange(1, across.size + 1), along.size)
    return Example(start.pressure(x, z).ravel(), numbers, np.full(x.size, along[1] - along[0]))


README = "README.txt"


@dataclass(frozen=True)
class Sliding:
    """A body that is in contact all the way."""

    start: UnwornContact
    speed: float
    """Sliding or slip speed, m/s."""
    travel: float
    """Distance that the surface goes in one unit of the contact's progress, m."""

    template: ClassVar[str] = "pin_on_disc.f"
    further_templates: ClassVar[tuple[str, ...]] = ()
    speed_template: ClassVar[str | None] = None
    """Template of the speed, if the law requires it and the main template does not contain it."""
    drives: ClassVar[int] = 2
    """Number of dimensions of the harness."""
    on_lines: ClassVar[bool] = False
    """True if wear is calculated along streamlines."""
    rate: ClassVar[str] = "k_D p v"
    factors: ClassVar[tuple[str, ...]] = ("V",)
    """Factors next to k_D·E_c in the longest increment."""
    use: ClassVar[str] = ""
    """Additional requirements on the model."""
    arguments: ClassVar[str] = ""
    """Arguments of the ABAQUS job."""
    data: ClassVar[str] = ""
    """Description of the data file of the job."""

    @property
    def turns(self) -> float:
        """Slip rotations per time, 1/s; only for rolling bodies."""
        return 0.0

    @property
    def words(self) -> str:
        """Additional notes on the law."""
        return ""

    @property
    def reach(self) -> float:
        """Speed in the longest stable increment, m/s."""
        return self.speed

    @property
    def numbers(self) -> list[str]:
        """The factors with their numbers."""
        return [f"V = {in_mm(self.speed, 'm/s'):.6g} mm/s"]

    @cached_property
    def example(self) -> Example:
        """Nodes under the unworn contact."""
        return along_a_radius(self.start)

    @property
    def dose(self) -> float:
        """Wear rate of the first node of the example divided by k_D: p·v, or n·∫p dl, Pa m/s."""
        return float(self.example.pressure[0]) * self.speed


@dataclass(frozen=True)
class Rolling(Sliding):
    """Two bodies that roll on each other and slip."""

    template: ClassVar[str] = "twin_disc.f"
    further_templates: ClassVar[tuple[str, ...]] = ("streamlines.f",)
    speed_template: ClassVar[str | None] = "slip_speed.f"
    drives: ClassVar[int] = 3
    on_lines: ClassVar[bool] = True
    rate: ClassVar[str] = "k_D n (integral of p along its streamline)"
    factors: ClassVar[tuple[str, ...]] = ("CLEN", "TURNS")
    use: ClassVar[str] = (
        "Run with cpus=1: streamlines and their integrals are kept in COMMON. streamlines.dat must be in the job "
        "folder; {README} describes it. Its node numbers are those of an input file without parts and assemblies."
    )
    arguments: ClassVar[str] = " cpus=1"
    data: ClassVar[str] = (
        "streamlines.dat: the number of rows, then in each row a node, its streamline (1, 2, ...) and the length dl "
        "in mm that the node represents along the rolling direction: half the distance between its neighbors, or "
        "twice that for a node with a mirror image across a plane of symmetry. Nodes that are not on a streamline do "
        "not wear. See harness/streamlines.dat for an example."
    )

    @property
    def turns(self) -> float:
        """Slip rotations per time, n = |V₁ − V₂|/(2πr) of Eq. 9, 1/s."""
        return self.speed / self.travel

    @property
    def reach(self) -> float:
        """N times the length of the contact, m/s."""
        return self.turns * 2 * self.start.half_length

    @property
    def words(self) -> str:
        """Eq. 9, and the sliding distance in its k_D."""
        return (
            f"Eq. 9: n = |V1 - V2|/(2 pi r) = {self.turns:.6g} slip rotations per second, with the slip speed "
            f"{in_mm(self.speed, 'm/s'):.6g} mm/s and the radius r = {in_mm(self.travel / (2 * math.pi), 'm'):.6g} mm "
            "of the crowned disc, which wears; k_D refers to the distance that a point slides in contact. Pressures "
            "are those of the current increment: the utility routines are called for all nodes of all streamlines at "
            "the first call in an increment."
        )

    @property
    def numbers(self) -> list[str]:
        """The factors with their numbers."""
        length = in_mm(2 * self.start.half_length, "m")
        return [f"CLEN = {length:.4g} mm (of the unworn contact)", f"TURNS = {self.turns:.4g} 1/s"]

    @cached_property
    def example(self) -> Example:
        """Nodes under the unworn contact."""
        return on_streamlines(self.start)

    @property
    def dose(self) -> float:
        """Wear rate of the first node of the example divided by k_D: n·∫p dl, Pa m/s."""
        first = self.example.streamline == 1
        return float(self.example.pressure[first] @ self.example.length[first]) * self.turns


def motion_of(contact: Contact, start: UnwornContact, speed: float) -> Sliding:
    """Return how the bodies of a contact move at a speed of sliding, or of slip, m/s."""
    return _MOTIONS[contact.progress.signal](start, speed, contact.travel)


_MOTIONS: dict[str, type[Sliding]] = {SLIDING.signal: Sliding, ROTATIONS.signal: Rolling}
"""Motion by what wear grows along."""


_MEASURED = "k_D was identified with the measured friction; the subroutine uses the fit of Eq. 7."
_OTHER_WEARS = "in the test, the {} wore as well; the subroutine includes only the wear of the {}."
_PRESSURES = {
    "giwm": "uniform contact pressure (the Global Incremental Wear Model)",
    "volume": "the wear volume of the pin",
    "local": "local contact pressure",
}


@dataclass(frozen=True)
class KnownWear:
    """k_D of a run's pin or crowned disc."""

    run_id: str
    coefficient: Quantity
    """k_D, m²/N; for discs as in Eq. 9, which uses the distance that a point slides in contact."""
    origin: str
    """Source of k_D, in one sentence."""
    notes: tuple[str, ...] = ()
    """Limitations of this k_D."""


def given_wear(run_id: str, coefficient: Quantity) -> KnownWear:
    """Return a k_D that somebody states."""
    return KnownWear(run_id, coefficient, "It was specified with --wear-coefficient.")


def fitted_wear(run_id: str, fit: WearFit) -> KnownWear:
    """Return the k_D of a fit. Raises ``FitError`` where it found none, or none that Eq. 9 can be given."""
    origin = f"It was identified from run {run_id} under {fit.model.title()}'s law"
    notes: tuple[str, ...] = (_MEASURED,) if fit.friction == "measured" else ()
    if fit.first is None:
        missing = " and ".join(fit.missing)
        raise FitError(
            f"{run_id}: found no k_D (missing: {missing}); expected a fitted value; specify it with --wear-coefficient"
        )
    first, *others = fit.bodies
    worn = (name for name in others if fit.bodies[name].wear_coefficient.value > 0)
    notes += tuple(_OTHER_WEARS.format(spoken(name), spoken(first)) for name in worn)
    if fit.distance_per_rotation is None:
        return KnownWear(run_id, fit.first.wear_coefficient, f"{origin} with {_PRESSURES[fit.engine]}.", notes)
    coefficient, how = _of_eq_9(run_id, fit)
    return KnownWear(run_id, coefficient, f"{origin} {how}", notes)


def _of_eq_9(run_id: str, fit: WearFit) -> tuple[Quantity, str]:
    """Return k_D of the crowned disc for Eq. 9, with distance counted as in Archard's law, and how it was obtained."""
    own, same = known_wear(fit), archards_wear(fit)
    if own is None or same is None:
        raise FitError(
            f'{run_id}: found a k_D fitted with distance_per_rotation = "{fit.distance_per_rotation}"; expected '
            f'"{ARCHARDS}", as in Eq. 9 of the paper; set distance_per_rotation = "{ARCHARDS}" under [wear] in the '
            "recipe and fit again"
        )
    if own.distance == ARCHARDS:
        return same.first, f"with the convention {ARCHARDS}, as in Eq. 9."
    return same.first, (
        f"with the convention {own.distance} ({own.first.value * 1e6:.4g} mm^3/(N mm)), and converted to {ARCHARDS}, "
        f"as in Eq. 9; with either value, the {spoken(next(iter(fit.bodies)))} loses the same volume in this run."
    )


_STABLE_SHARE = 1.2
_ELEMENTS_A_RADIUS = 10
_MOST_INCREMENTS = 1e9


@dataclass(frozen=True)
class WearCase:
    """All that a subroutine and its step need, SI. Raises ``ContactError`` where nothing wears, or too fast."""

    contact: Contact
    normal_load: float
    known: KnownWear
    speed: float
    """Sliding speed, or slip speed |V₁ − V₂|, m/s."""
    duration: float
    """s."""
    friction: ExponentialFriction | None = None
    """μ(s) where the law is Sarkar's; None if it is Archard's."""
    element_size: float | None = None
    """Element size of the contact surface across the rolling direction, m; by default a tenth of the unworn contact."""

    def __post_init__(self) -> None:
        if math.isinf(self.contact.unworn_radii[0]):
            raise ContactError(
                f"{self.known.run_id}: found {self.contact.title}, a line contact; expected a point contact, for "
                "which the subroutine is written; calculate the wear volume as k_D·F_N·s"
            )
        if not self.known.coefficient.value > 0:
            raise ContactError(
                f"{self.known.run_id}: found a k_D of {self.known.coefficient.shown(WEAR_COEFFICIENT)}; expected a "
                "positive value; specify one with --wear-coefficient"
            )
        if not self.increments < _MOST_INCREMENTS:
            raise ContactError(
                f"{self.known.run_id}: found a test that requires {self.increments:.3g} stable increments; expected "
                f"fewer than {_MOST_INCREMENTS:.0g}; check k_D, speed and their units, or use larger elements or a "
                "shorter test"
            )

    @property
    def law(self) -> LawName:
        """Name of the law."""
        return "archard" if self.friction is None else "sarkar"

    @cached_property
    def modulus(self) -> float:
        """E_c, Pa."""
        return float(self.contact.reduced_modulus())

    @cached_property
    def start(self) -> UnwornContact:
        """The unworn contact by Hertz; a flat end where that is larger."""
        (across, along), end = self.contact.unworn_radii, self.contact.flat_end
        hertz = hertz_ellipse(normal_load=self.normal_load, radius_x=across, radius_z=along, modulus=self.modulus)
        if end > hertz.half_width:
            return UnwornContact(end, end, self.normal_load / (math.pi * end**2), even=True)
        return UnwornContact(hertz.half_width, hertz.half_length, hertz.peak_pressure)

    @property
    def element(self) -> float:
        """h, m; in two digits where it was not stated."""
        return self.element_size or float(f"{self.start.half_width / _ELEMENTS_A_RADIUS:.2g}")

    @cached_property
    def motion(self) -> Sliding:
        """Motion of the bodies."""
        return motion_of(self.contact, self.start, self.speed)

    @property
    def largest_factor(self) -> float:
        """f: the largest √(1 + 3μ²) on the way under Sarkar's law, 1 under Archard's."""
        return max(self.factor(distance) for distance in (0.0, self.speed * self.duration))

    def factor(self, distance: float) -> float:
        """Return √(1 + 3μ²) at a sliding distance, m; 1 under Archard's law."""
        return 1.0 if self.friction is None else float(junction_factor(self.friction.coefficient(distance)))

    @property
    def step_limit(self) -> float:
        """Longest stable increment, s."""
        stiffness = self.known.coefficient.value * self.modulus * self.motion.reach * self.largest_factor
        return _STABLE_SHARE * self.element / stiffness

    @property
    def increments(self) -> float:
        """Number of such increments in the test."""
        return self.duration / self.step_limit

    def __str__(self) -> str:
        return (
            f"{self.known.run_id}: increments are stable below {show(self.step_limit, None, 's')} with elements of "
            f"{show(self.element, None, 'm', 'um')} in the contact, {math.ceil(self.increments):,} increments in total"
        )
