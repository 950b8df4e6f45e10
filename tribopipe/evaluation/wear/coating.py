"""Coatings that wear through: the place along a test at which a body has worn as deep as its coating is thick."""

import math
from collections.abc import Collection, Iterator
from dataclasses import dataclass

import numpy as np

from tribopipe.base.units import KINDS, show
from tribopipe.documents.contact_kinds import spoken
from tribopipe.documents.quantity import Quantity
from tribopipe.evaluation.wear.scenario import Scenario
from tribopipe.results.finding import Finding

_STEP = 1e-3
"""Relative step of a place in a difference quotient."""


@dataclass(frozen=True)
class WornCoating:
    """Coating that is worn through at the end of a test."""

    body: str
    thickness: Quantity
    """m."""
    depth: float
    """Wear depth at the end, m."""
    place: Quantity
    """Sliding distance, m, or rotations, at which the wear depth exceeds the thickness."""

    def __str__(self) -> str:
        at = f"{self.place} rotations" if self.place.unit == "1" else self.place.shown("m")
        return (
            f"found a wear depth of {show(self.depth, None, 'm', 'um')} on the {spoken(self.body)}, more than its "
            f"coating thickness of {self.thickness.shown('um')}, which is exceeded from {at} on"
        )


def worn_coatings(scenario: Scenario, end: float, of: Collection[str] | None = None) -> Iterator[WornCoating]:
    """Yield the coatings that are worn through until a place, m or rotations; uncertain by all inputs or those named.

    Raises ``ContactError`` where a body is worn away.
    """
    bodies = scenario.contact.bodies
    for name, state in scenario.wear.bodies.items():
        thickness, depth = bodies[name].coating_thickness, state["wear_depth"]
        if thickness is None:
            continue
        worn = float(scenario.worn(np.asarray(end))[depth])
        if worn > thickness.value:
            yield WornCoating(name, thickness, worn, _place(scenario, depth, thickness, end, of))


def _place(scenario: Scenario, depth: str, thickness: Quantity, end: float, of: Collection[str] | None) -> Quantity:
    """Return where a depth reaches a thickness, as uncertain as both make it, over the wear rate there."""
    from scipy.optimize import brentq

    def excess(place: float) -> float:
        return float(scenario.worn(np.asarray(place))[depth]) - thickness.value

    place = float(brentq(excess, 0.0, end, xtol=1e-9 * end))
    rate = (excess(place * (1 + _STEP)) - excess(place * (1 - _STEP))) / (2 * _STEP * place)
    spread = float(scenario.uncertainties(np.asarray([place]), of)[depth][0])
    spread = math.hypot(spread, thickness.u_or_zero) / rate
    return Quantity(value=place, unit=KINDS[scenario.contact.progress.kind].si, standard_uncertainty=spread)


def coating_notes(scenario: Scenario, end: float) -> Iterator[str]:
    """Warn of coatings that a prediction wears through, by k_D of the coating."""
    for worn in worn_coatings(scenario, end):
        yield f"warning: {worn}; expected wear within the coating, since k_D is that of the coating"


def coating_findings(scenario: Scenario, end: float) -> Iterator[Finding]:
    """Report coatings that wore through in a test by its fitted course of wear, uncertain by what was fitted."""
    for worn in worn_coatings(scenario, end, scenario.wear.coefficients):
        yield Finding(
            severity="warning",
            code="coating_worn_through",
            where=f"contact.{worn.body}.coating_thickness",
            message=f"in the fitted course of wear, {worn}; expected wear within the coating",
            remedy="repeat the test over a shorter distance; k_D is that of coating and substrate combined",
        )
