"""Quantities as numbers of a column: both value and standard uncertainty in the unit of the column."""

from tribopipe.base.number_columns import Number
from tribopipe.base.units import from_si, interval_from_si
from tribopipe.documents.quantity import Quantity


def number(quantity: Quantity, unit: str) -> Number:
    """Return a quantity as a value and its standard uncertainty, in a unit."""
    u = quantity.standard_uncertainty
    value = float(from_si(quantity.value, quantity.unit, unit))
    return value, None if u is None else float(interval_from_si(u, quantity.unit, unit))
