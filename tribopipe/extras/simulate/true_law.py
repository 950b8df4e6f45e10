"""The wear law of a virtual series, with its true parameters."""

from tribopipe.base.units import KINDS
from tribopipe.documents.plan import Series, TwinDiscSeries
from tribopipe.documents.quantity import Quantity
from tribopipe.evaluation.wear.given_parameters import law_with, read_parameters
from tribopipe.physics.laws import WearLaw, law_named

_PLACE = "law_parameters"


def true_law(series: Series | TwinDiscSeries) -> WearLaw:
    """Return the law of a series.

    Raises ``FitError`` where it is not installed here, where a parameter is missing, or one is none of the law's.
    """
    law = law_named(series.law)
    return law_with(law, read_parameters(law, series.law_parameters, _PLACE), f"{_PLACE} of the series")


def true_parameters(law: WearLaw) -> dict[str, Quantity] | None:
    """Return the parameters of a law in addition to k_D, in SI; none where it has none."""
    known = law.parameters()
    return {
        name: Quantity(value=value, unit=KINDS[known[name].kind].si) for name, value in law.values().items()
    } or None
