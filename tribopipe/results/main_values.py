"""The main values of a result: those that a run is processed for, and that a later method may change."""

from collections.abc import Iterator, Mapping
from typing import TypeAlias

from tribopipe.base.units import KINDS, WEAR_COEFFICIENT
from tribopipe.documents.contact import DISCS
from tribopipe.documents.quantity import Quantity, change
from tribopipe.documents.record import Record
from tribopipe.results.disc_evaluation import TwinDiscFit
from tribopipe.results.evaluation import DriftCorrection, WearFit

Headline: TypeAlias = Mapping[str, Quantity | None]
"""By the name of the value; none where the run did not give it."""
_SHOWN = {
    "drift_rate": ("drift rate", KINDS["drift rate"].shown),
    "wear_coefficient": ("k_D", WEAR_COEFFICIENT),
    "curved_disc": ("k_D of the curved disc", WEAR_COEFFICIENT),
    "flat_disc": ("k_D of the flat disc", WEAR_COEFFICIENT),
}
"""What each value is called, and the unit in which people read it."""


def headline(result: Record | None) -> Headline:
    """Return the main values of a result: drift rate, or k_D of each body; nothing for results of other steps.

    Parameters
    ----------
    result
        Result of a step of a run.

    Returns
    -------
    Headline
        ``drift_rate`` in m/s; ``wear_coefficient`` of a pin, ``curved_disc`` and ``flat_disc`` of two discs, in m²/N.
    """
    if isinstance(result, DriftCorrection):
        return {"drift_rate": result.drift_rate}
    if isinstance(result, WearFit):
        return {"wear_coefficient": result.wear_coefficient}
    if isinstance(result, TwinDiscFit):
        discs = {name: getattr(result, name) for name in DISCS}
        return {name: None if disc is None else disc.wear_coefficient for name, disc in discs.items()}
    return {}


def changes(before: Headline, result: Record | None) -> Iterator[str]:
    """Write each main value that has changed: "archard: k_D 1.35 → 1.42 mm³/(N·mm)".

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
    model = f"{result.model}: " if isinstance(result, WearFit | TwinDiscFit) else ""
    for name, now in headline(result).items():
        (label, unit), earlier = _SHOWN[name], before.get(name)
        if _in(earlier, unit) != _in(now, unit):
            yield f"{model}{label} {change(earlier, now, unit)}"


def _in(quantity: Quantity | None, unit: str) -> str | None:
    return None if quantity is None else quantity.shown(unit)
