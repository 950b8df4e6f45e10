"""Dissipated energy: the wear volume is proportional to the friction work, V = α·E_d.

E_d = F_N·∫μ ds, so that α takes the place of k_D: with f = μ its unit m²/N is m³/J. A k_D of 1 mm³/(N·mm) under this
law is α = 1000 mm³/J.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from tribopipe.base.arrays import Column
from tribopipe.base.errors import FitError
from tribopipe.physics.friction_path import FrictionPath
from tribopipe.physics.laws import WearLaw, required


@dataclass(frozen=True)
class DissipatedEnergy(WearLaw):
    """V = α·E_d: k_D is α, the wear volume per friction work, m³/J."""

    name = "dissipated_energy"
    title = "the dissipated-energy law"
    rate = "k_D·p·μ; k_D is the energy wear coefficient α, and 1 mm³/(N·mm) is 1000 mm³/J"
    citation = "S. Fouvry, T. Liskiewicz, P. Kapsa, S. Hannel, E. Sauger, Wear 255 (2003) 287"
    needs_friction = True

    def rate_factor(self, distance: ArrayLike, friction: FrictionPath | None) -> Column:
        """Return μ. Raises ``FitError`` where there is no friction."""
        return required(self, friction).coefficient(distance)

    def effective_distance(self, distance: ArrayLike, friction: FrictionPath | None) -> Column:
        """Return ∫₀ˢ μ ds', m, NaN for draws without friction work.

        Raises ``FitError`` where there is no friction, or no friction work.
        """
        path, end = required(self, friction), float(np.max(distance, initial=0.0))
        work = np.asarray(path.work_per_load(end))
        idle = (work <= 0) & (end > 0)
        if np.all(idle):
            raise FitError(
                f"dissipated-energy law: found a mean friction coefficient of {np.mean(work) / end:.2g}; "
                "expected a value above zero, since wear is proportional to the friction work in this law; check the "
                "sign and the zero of the friction signal, or use Archard's law"
            )
        return np.where(idle, np.nan, path.work_per_load(distance))
