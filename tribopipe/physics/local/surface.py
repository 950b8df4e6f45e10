"""What local wear asks of a contact solver, whichever it is: rings, a half space of rectangles, or finite elements."""

from dataclasses import dataclass
from typing import Protocol, Self

from tribopipe.base.arrays import Column


@dataclass(frozen=True)
class Contact:
    """Two surfaces pressed on each other."""

    pressure: Column
    """At each point of the surface that wears, Pa; 0 where the surfaces are apart."""
    approach: float
    """How far remote points of the bodies have come closer, m."""


@dataclass(frozen=True)
class Extent:
    """How far a contact reaches from its middle, m: in both directions a where it is round."""

    half_width: float
    """a, or a_x across the direction of rolling."""
    half_length: float
    """a, or a_z along it."""


class Surface(Protocol):
    """The surface that wears, pressed on one that does not.

    At each of its points p ≥ 0, g ≥ 0 and p·g = 0, where the gap is

        g = gap + worn + u(p) + amount·m(p) − approach,    Σ areas·p = F_N,

    with the elastic displacement u. m(p) is what a unit amount of wear removes: the pressure itself under a pin,
    where the amount is k_D·S in m³/N; its integral along the direction of rolling under a disc (Eq. 8), where the
    amount is k_D·N in m²/N. The term with m(p) makes wear implicit: what is worn in a step is worn by the
    pressure at its end.
    """

    @property
    def gap(self) -> Column:
        """Distance of each point, unworn and unloaded, from the plane that touches the surface, m."""
        ...

    @property
    def areas(self) -> Column:
        """What the pressure at each point counts for in the normal load, m²; symmetric parts counted in."""
        ...

    @property
    def places(self) -> tuple[Column, ...]:
        """Axes of the points, m: (radius,), or (across, along) of a grid."""
        ...

    def press(self, worn: Column, amount: float = 0.0, start: Contact | None = None) -> Contact:
        """Solve the contact, from the pressure of a similar one where given. Raises ``ContactError``."""
        ...

    def exposure(self, pressure: Column) -> Column:
        """Return m(p), shaped as the points."""
        ...

    def extent(self, contact: Contact) -> Extent:
        """Return how far the contact reaches."""
        ...

    def volume(self, worn: Column) -> float:
        """Return what is lost by wear: a pin's volume, m³, or the cross-section of a disc's track, m²."""
        ...

    def stable_amount(self, contact: Contact) -> float:
        """Return the amount of wear beyond which an explicit step makes a checkerboard of the pressure."""
        ...

    def roughness(self, contact: Contact) -> float:
        """Return how much the pressure alternates from point to point well inside the contact, over its mean."""
        ...

    def refreshed(self, worn: Column) -> Self:
        """Return the surface with the elasticity of the worn shape; itself where that is the same."""
        ...
