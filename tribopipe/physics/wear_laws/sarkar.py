"""Sarkar's law: friction increases wear, since the junctions between the bodies grow with it."""

from dataclasses import dataclass

from numpy.typing import ArrayLike

from tribopipe.base.arrays import Column
from tribopipe.physics.friction_path import FrictionPath, junction_factor
from tribopipe.physics.laws import WearLaw, required


@dataclass(frozen=True)
class Sarkar(WearLaw):
    """V/s = k·F_N/H·√(1 + 3μ²) (Eq. 2): junctions grow with friction."""

    name = "sarkar"
    title = "Sarkar's law"
    rate = "k_D·p·√(1 + 3μ²)"
    citation = "A. D. Sarkar, Friction and Wear, Academic Press (1980)"
    needs_friction = True

    def rate_factor(self, distance: ArrayLike, friction: FrictionPath | None) -> Column:
        """Return √(1 + 3μ²). Raises ``FitError`` where there is no friction."""
        return junction_factor(required(self, friction).coefficient(distance))

    def effective_distance(self, distance: ArrayLike, friction: FrictionPath | None) -> Column:
        """Return ∫₀ˢ √(1 + 3μ²) ds'. Raises ``FitError`` where there is no friction."""
        return required(self, friction).sarkar_distance(distance)
