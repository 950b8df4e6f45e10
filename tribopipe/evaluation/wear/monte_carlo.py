"""How a wear coefficient that was drawn is recorded, beside its first-order interval."""

from tribopipe.base.units import WEAR_COEFFICIENT
from tribopipe.documents.quantity import between, wear_coefficient
from tribopipe.physics.uncertainty import Distribution, first_order_holds
from tribopipe.results.wear_fit import BodyWear, MonteCarlo


def with_draws(body: BodyWear, found: Distribution, digits: int) -> tuple[BodyWear, tuple[str, ...]]:
    """Replace what k_D of a body has to first order by what was drawn, and note where they disagree (JCGM 101, 8)."""
    low, high = first_order = body.interval
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
    changed = {
        "wear_coefficient": body.wear_coefficient.model_copy(
            update={"standard_uncertainty": found.standard_uncertainty}
        ),
        "interval": (wear_coefficient(found.interval[0]), wear_coefficient(found.interval[1])),
        "monte_carlo": record,
    }
    return body.model_copy(update=changed), () if agrees else (note,)
