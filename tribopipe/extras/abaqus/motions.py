"""How the bodies of a contact move, and what of the files follows from that: they slide, or roll and slip."""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

from tribopipe.documents.contact import Contact, SlidingPin
from tribopipe.documents.contact_kinds import family_of
from tribopipe.documents.twin_disc import TwinDisc
from tribopipe.extras.abaqus.example import Example, UnwornContact, along_a_radius, on_streamlines
from tribopipe.extras.abaqus.fortran import in_mm

README = "README.txt"


@dataclass(frozen=True)
class Sliding:
    """A body that is in contact all the way."""

    start: UnwornContact
    speed: float
    """Of sliding, or of slip, m/s."""
    travel: float
    """Distance that the surface goes in one unit of the contact's progress, m."""

    template: ClassVar[str] = "pin_on_disc.f"
    further_templates: ClassVar[tuple[str, ...]] = ()
    speed_template: ClassVar[str | None] = None
    """Of the speed, where the law needs it and the template does not have it."""
    drives: ClassVar[int] = 2
    """Number of dimensions of the harness."""
    on_lines: ClassVar[bool] = False
    """Whether nodes wear by streamlines."""
    rate: ClassVar[str] = "k_D p v"
    factors: ClassVar[tuple[str, ...]] = ("V",)
    """Factors next to k_D·E_c in the longest increment."""
    use: ClassVar[str] = ""
    """What the model has to be like in addition."""
    arguments: ClassVar[str] = ""
    """Of the job."""
    data: ClassVar[str] = ""
    """What the job's own file has in it."""

    @property
    def turns(self) -> float:
        """Slip rotations per time, 1/s; none of a body that slides all the way."""
        return 0.0

    @property
    def words(self) -> str:
        """Additional notes on the law."""
        return ""

    @property
    def reach(self) -> float:
        """What takes the place of the sliding speed in the longest stable increment, m/s."""
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
        """What the first node of the example wears per time over k_D: p·v, or n·∫p dl, Pa m/s."""
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
        "Run with cpus=1: streamlines and their integrals are kept in COMMON. streamlines.dat has to be in the "
        f"folder of the job; {README} describes it. Its node numbers are those of an input file without "
        "parts and assemblies."
    )
    arguments: ClassVar[str] = " cpus=1"
    data: ClassVar[str] = (
        "streamlines.dat: the number of rows, then in each row a node, its streamline (1, 2, ...) and the length "
        "dl in mm that the node stands for along the direction of rolling: half the distance between its "
        "neighbors, twice that where a plane of symmetry mirrors it. Nodes on no streamline do not wear. The one "
        "of the harness is an example."
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
        """Eq. 9, and what its k_D counts."""
        return (
            f"Eq. 9: n = |V1 - V2|/(2 pi r) = {self.turns:.6g} slip rotations per second, with the slip speed "
            f"{in_mm(self.speed, 'm/s'):.6g} mm/s and the radius r = {in_mm(self.travel / (2 * math.pi), 'm'):.6g} mm "
            "of the crowned disc, which wears; k_D counts what a point slides while it is in contact. Pressures are "
            "those of the increment itself: the utility routines are called for all nodes of all streamlines at the "
            "first call in an increment."
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
        """What the first node of the example wears per time over k_D: n·∫p dl, Pa m/s."""
        first = self.example.streamline == 1
        return float(self.example.pressure[first] @ self.example.length[first]) * self.turns


def motion_of(contact: Contact, start: UnwornContact, speed: float) -> Sliding:
    """Return how the bodies of a contact move at a speed of sliding, or of slip, m/s."""
    return family_of(contact, _FAMILIES)(start, speed, contact.travel)


_FAMILIES: dict[type[Contact], type[Sliding]] = {SlidingPin: Sliding, TwinDisc: Rolling}
