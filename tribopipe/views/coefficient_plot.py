"""The plot of effective k_D against friction, of one run or of a study, beside the laws (paper, Fig. 5)."""

from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import LawName
from tribopipe.evaluation.study.effective import EffectiveCoefficient
from tribopipe.physics.friction_path import junction_factor
from tribopipe.physics.laws import law_title
from tribopipe.results.evaluation import COVERAGE_FACTOR
from tribopipe.views.plot import COEFFICIENT, Curve, Panel

BY_FRICTION = ("archard", "sarkar")
"""Laws under which effective k_D is known by the friction coefficient alone."""


class LawCoefficient(NamedTuple):
    """k_D by a law, and its 95 % interval."""

    law: LawName
    best: Quantity
    interval: tuple[Quantity, Quantity]


def coefficient_panel(measured: Sequence[EffectiveCoefficient], laws: Iterable[LawCoefficient]) -> Panel:
    """Draw effective k_D of each run in the order of sliding, and what the laws say of it, with 95 % bands."""
    curves = [_measured(one) for one in measured]
    if measured:
        curves += law_curves(friction_range(measured), laws)
    return Panel("effective k_D", COEFFICIENT, tuple(curves))


def _measured(found: EffectiveCoefficient) -> Curve:
    half = COVERAGE_FACTOR * found.standard_uncertainty
    low, high = found.coefficient - half, found.coefficient + half
    name = f"{found.run_id}, measured"
    return Curve(name, "measured", found.friction, found.coefficient, COEFFICIENT, found.run_id, lower=low, upper=high)


def friction_range(measured: Sequence[EffectiveCoefficient]) -> Column:
    """Return friction coefficients over all that were measured, and somewhat beyond."""
    friction = np.concatenate([one.friction for one in measured])
    room = 0.08 * max(float(np.ptp(friction)), 0.02)
    return np.linspace(np.min(friction) - room, np.max(friction) + room, 100)


def law_curves(friction: Column, laws: Iterable[LawCoefficient]) -> Iterator[Curve]:
    """Draw what laws say of effective k_D; only those that know it by friction alone."""
    for law, best, interval in laws:
        if law in BY_FRICTION:
            factor = junction_factor(friction) if law == "sarkar" else np.ones_like(friction)
            line, low, high = (quantity.value * factor for quantity in (best, *interval))
            yield Curve(law_title(law), "fit", friction, line, COEFFICIENT, "", law, low, high)
