"""Wear laws: how fast a surface recedes under pressure and friction.

Each law is written dh/ds = k_D · p · f(μ) with the dimensional wear coefficient k_D = k/H, m²/N, and a
factor f of the friction coefficient. So a law is known by its effective distance S(s) = ∫₀ˢ f(μ(s')) ds': the
distance over which Archard's law would wear as much.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from tribopipe.errors import FitError
from tribopipe.records.recipe import LawName
from tribopipe.run import Column
from tribopipe.wear.friction_path import FrictionPath, junction_factor


class WearLaw(Protocol):
    """One wear law."""

    @property
    def name(self) -> LawName:
        """Name in commands, recipes and results."""
        ...

    @property
    def needs_friction(self) -> bool:
        """Whether μ enters."""
        ...

    def rate_factor(self, distance: ArrayLike, friction: FrictionPath | None) -> Column:
        """Return f(μ(s)) of dh/ds = k_D·p·f."""
        ...

    def effective_distance(self, distance: ArrayLike, friction: FrictionPath | None) -> Column:
        """Return S(s) = ∫₀ˢ f ds', m."""
        ...


@dataclass(frozen=True)
class Archard:
    """V/s = k·F_N/H (Eq. 1): friction plays no part."""

    name: LawName = "archard"
    needs_friction: bool = False

    def rate_factor(self, distance: ArrayLike, friction: FrictionPath | None) -> Column:  # noqa: ARG002
        """Return ones."""
        return np.ones_like(np.asarray(distance, dtype=float))

    def effective_distance(self, distance: ArrayLike, friction: FrictionPath | None) -> Column:  # noqa: ARG002
        """Return the sliding distance itself."""
        return np.asarray(distance, dtype=float)


@dataclass(frozen=True)
class Sarkar:
    """V/s = k·F_N/H·√(1 + 3μ²) (Eq. 2): junctions grow with friction."""

    name: LawName = "sarkar"
    needs_friction: bool = True

    def rate_factor(self, distance: ArrayLike, friction: FrictionPath | None) -> Column:
        """Return √(1 + 3μ²). Raises ``FitError`` where there is no friction."""
        return junction_factor(_given(friction).coefficient(distance))

    def effective_distance(self, distance: ArrayLike, friction: FrictionPath | None) -> Column:
        """Return ∫₀ˢ √(1 + 3μ²) ds'. Raises ``FitError`` where there is no friction."""
        return _given(friction).sarkar_distance(distance)


LAWS: dict[LawName, WearLaw] = {"archard": Archard(), "sarkar": Sarkar()}


def _given(friction: FrictionPath | None) -> FrictionPath:
    if friction is None:
        raise FitError(
            "Sarkar's law: found no friction coefficient; expected μ(s), fitted or given; give it with "
            '--friction "A=0.2 b=0.4 c=50 m", or use Archard\'s law'
        )
    return friction
