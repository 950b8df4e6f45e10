"""The wear of a contact of any kind: which module answers for it."""

from collections.abc import Callable
from typing import NamedTuple

from tribopipe.contacts.pin_on_disc import PinWear
from tribopipe.contacts.twin_disc import TwinDiscWear
from tribopipe.contacts.wear import ContactWear
from tribopipe.documents.contact import Contact, SlidingPin, TwinDisc, family_of
from tribopipe.documents.quantity import Quantity
from tribopipe.physics.conventions import DistanceConvention, WearEngine

_NO_SLIP = Quantity(value=0.0, unit="1")


class Terms(NamedTuple):
    """What k_D is right with."""

    slip: Quantity | None = None
    """Nominal slip of bodies that roll."""
    engine: WearEngine = "giwm"
    """Pressure that k_D is found by."""
    distance: DistanceConvention = "full-slip"
    """What counts as sliding distance in one rotation of bodies that roll."""


def wear_of(contact: Contact, terms: Terms = Terms()) -> ContactWear:  # noqa: B008 - it is immutable
    """Return how the bodies of a contact wear."""
    return family_of(contact, _FAMILIES)(contact, terms)


_FAMILIES: dict[type[Contact], Callable[..., ContactWear]] = {
    SlidingPin: lambda contact, terms: PinWear(contact, terms.engine),
    TwinDisc: lambda contact, terms: TwinDiscWear(contact, terms.slip or _NO_SLIP, terms.distance),
}
