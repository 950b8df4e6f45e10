"""What a subroutine is written for: a contact, how fast it slides or slips, and the law by which it wears.

The surface is moved explicitly, increment by increment. A wave of wear whose length is two elements, 2h, changes the
pressure by πE_c/(2h) times its height on a half space. With the rate dw/dt = k_D·f·v·p of a pin, an increment leaves
1 − k_D·f·v·(πE_c/2h)·Δt of it, which grows in turns of sign beyond

    Δt = (4/π)·h / (k_D·f·v·E_c).

Of discs all points of a streamline wear alike, at k_D·f·n·∫p dl with n slip rotations per time (Eq. 9), so that n times
the length of the contact, 2a_z, takes the place of v, and h is the width of an element across the direction of rolling.
1.2 in the place of 4/π leaves a margin.
"""

import math
from dataclasses import dataclass
from functools import cached_property

from tribopipe.base.errors import ContactError
from tribopipe.base.units import WEAR_COEFFICIENT, show
from tribopipe.documents.contact import Contact
from tribopipe.documents.recipe import LawName
from tribopipe.extras.abaqus.example import UnwornContact
from tribopipe.extras.abaqus.known_wear import KnownWear
from tribopipe.extras.abaqus.motions import Sliding, motion_of
from tribopipe.physics.friction_path import ExponentialFriction, junction_factor
from tribopipe.physics.hertz import contact_modulus
from tribopipe.physics.hertz_ellipse import hertz_ellipse

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
    """Of sliding, or of slip |V₁ − V₂|, m/s."""
    duration: float
    """s."""
    friction: ExponentialFriction | None = None
    """μ(s) where the law is Sarkar's; none where it is Archard's."""
    element_size: float | None = None
    """Of the contact surface, across the direction of rolling, m; a tenth of that of the unworn contact by default."""

    def __post_init__(self) -> None:
        if math.isinf(self.contact.unworn_radii[0]):
            raise ContactError(
                f"{self.known.run_id}: found {self.contact.title}, which touch in a line; expected a contact in a "
                "point, for which the subroutine is written; compute the volume by k_D·F_N·s"
            )
        if not self.known.coefficient.value > 0:
            raise ContactError(
                f"{self.known.run_id}: found a k_D of {self.known.coefficient.shown(WEAR_COEFFICIENT)}; expected more "
                "than zero, or there is no wear to compute; give another with --wear-coefficient"
            )
        if not self.increments < _MOST_INCREMENTS:
            raise ContactError(
                f"{self.known.run_id}: found {self.increments:.3g} stable increments to the end; expected fewer than "
                f"{_MOST_INCREMENTS:.0g}; check k_D, speed and their units, or take larger elements or a shorter way"
            )

    @property
    def law(self) -> LawName:
        """Name of the law."""
        return "archard" if self.friction is None else "sarkar"

    @cached_property
    def modulus(self) -> float:
        """E_c, Pa."""
        one, other = self.contact.bodies.values()
        return float(
            contact_modulus(
                pin_modulus=one.youngs_modulus.value,
                pin_ratio=one.poisson_ratio.value,
                disc_modulus=other.youngs_modulus.value,
                disc_ratio=other.poisson_ratio.value,
            )
        )

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
        """How the bodies move."""
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
        """How many such increments the whole wear takes."""
        return self.duration / self.step_limit

    def __str__(self) -> str:
        return (
            f"{self.known.run_id}: increments stable below {show(self.step_limit, None, 's')} where elements of the "
            f"contact are {show(self.element, None, 'm', 'um')} wide, {math.ceil(self.increments):,} to the end"
        )
