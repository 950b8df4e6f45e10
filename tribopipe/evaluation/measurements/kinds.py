"""Evaluation of post-test measurements for each kind of contact."""

from collections.abc import Callable, Iterable
from typing import NamedTuple

from tribopipe.documents.contact import Contact, SlidingPin
from tribopipe.documents.contact_kinds import family_of
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import DefaultUncertainty, Recipe
from tribopipe.documents.twin_disc import TwinDisc
from tribopipe.evaluation.measurements.pin_on_disc import EndWear, end_wear, pin_on_disc_wear
from tribopipe.evaluation.measurements.readings import SignalDepths
from tribopipe.evaluation.measurements.twin_disc import DiscEndWear, disc_end_wear, disc_totals, twin_disc_wear
from tribopipe.evaluation.measurements.worn_pair import WornBodies
from tribopipe.results.run import RawRun


class Measurements(NamedTuple):
    """Functions that evaluate the measurements of the bodies."""

    worn: Callable[[RawRun, DefaultUncertainty, int | None, SignalDepths], WornBodies]
    """Depth and volume of each body at an interruption, or at the end, with what only the depth signal shows."""
    at_end: Callable[[RawRun, Recipe, Quantity | None], EndWear | DiscEndWear | None]
    """The wear at the end as a displacement sensor has seen it, next to an unmeasured groove; None if it is unknown."""
    totals: Callable[[RawRun, Recipe], Iterable[DiscEndWear]] | None
    """Wear depth of both bodies together by each kind of measurement, where one shape that both share determines it."""
    needed: str
    """Measurement required for that."""


def measurements_of(contact: Contact) -> Measurements:
    """Return what follows from measurements of the bodies of a contact."""
    return family_of(contact, _FAMILIES)


_FAMILIES: dict[type[Contact], Measurements] = {
    SlidingPin: Measurements(
        pin_on_disc_wear,
        lambda run, recipe, approach: end_wear(run, recipe.uncertainty, approach=approach),
        None,
        "a post-test measurement of the pin (wear depth, scar, wear volume, mass or profile)",
    ),
    TwinDisc: Measurements(
        lambda run, defaults, interruption, _: twin_disc_wear(run, defaults, interruption),
        lambda run, recipe, _: disc_end_wear(run, recipe),
        disc_totals,
        "a post-test measurement of the crowned disc (wear depth, track width or wear volume)",
    ),
}
