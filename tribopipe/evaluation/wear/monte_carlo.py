"""How a wear coefficient that was drawn is recorded, beside its first-order interval."""

from tribopipe.base.units import WEAR_COEFFICIENT
from tribopipe.documents.quantity import Quantity, between, wear_coefficient
from tribopipe.physics.uncertainty import Distribution, first_order_holds
from tribopipe.results.evaluation import MonteCarlo


def drawn(
    found: Distribution, first_order: tuple[Quantity, Quantity], digits: int
) -> tuple[MonteCarlo, tuple[Quantity, Quantity], tuple[str, ...]]:
    """Return the record of a Monte Carlo of k_D, its interval, and a note where first order disagrees (JCGM 101, 8)."""
    low, high = first_order
    agrees = first_order_holds((low.value, high.value), found, digits)
    record = MonteCarlo(
        draws=len(found.draws),
        mean=wear_coefficient(found.mean),
        standard_uncertainty=wear_coefficient(found.standard_uncertainty),
        stable=found.stable,
        first_order_interval=first_order,
        agrees_with_first_order=agrees,
    )
    ends = between(first_order, WEAR_COEFFICIENT)
    note = f"first order and Monte Carlo disagree: to first order the 95 % interval would be {ends}"
    interval = wear_coefficient(found.interval[0]), wear_coefficient(found.interval[1])
    return record, interval, () if agrees else (note,)
