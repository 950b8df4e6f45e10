"""The main values of a result: those that a run is processed for, and that a later method may change."""

from collections.abc import Iterator, Mapping
from typing import TypeAlias

from tribopipe.base.units import KINDS, WEAR_COEFFICIENT
from tribopipe.documents.contact_kinds import spoken
from tribopipe.documents.quantity import Quantity, change, in_unit
from tribopipe.documents.record import Record
from tribopipe.results.evaluation import DriftCorrection
from tribopipe.results.wear_fit import WearFit

Headline: TypeAlias = Mapping[str, Quantity | None]
"""Main values by name; None if the run does not have the value."""


def headline(result: Record | None) -> Headline:
    """Return the main values of a result: drift rate, or k_D of each body; nothing for results of other steps.

    Parameters
    ----------
    result
        Result of a step of a run.

    Returns
    -------
    Headline
        ``drift_rate`` in m/s; k_D of each body by its name, in m²/N.
    """
    if isinstance(result, DriftCorrection):
        return {"drift_rate": result.drift_rate}
    if isinstance(result, WearFit):
        return {name: body.wear_coefficient for name, body in result.bodies.items()}
    return {}


def changes(before: Headline, result: Record | None) -> Iterator[str]:
    """Write each main value that has changed: "archard: k_D of the pin 1.35 → 1.42 mm³/(N·mm)".

    Parameters
    ----------
    before
        Main values of the earlier result.
    result
        The result that has replaced it.

    Yields
    ------
    str
        One line for each value of which the digits shown differ.
    """
    model = f"{result.model}: " if isinstance(result, WearFit) else ""
    after = headline(result)
    for name in dict.fromkeys((*after, *before)):
        label, unit = _shown(name)
        earlier, now = before.get(name), after.get(name)
        if in_unit(earlier, unit) != in_unit(now, unit):
            yield f"{model}{label} {change(earlier, now, unit)}"


def _shown(name: str) -> tuple[str, str]:
    """Return what a value is called, and the unit in which people read it."""
    if name == "drift_rate":
        return "drift rate", KINDS["drift rate"].shown
    return f"k_D of the {spoken(name)}", WEAR_COEFFICIENT
