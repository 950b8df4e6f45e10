"""Wear of a contact of any kind."""

from collections.abc import Callable, Collection
from typing import NamedTuple

from tribopipe.base.errors import ContactError
from tribopipe.contacts.pin_on_disc import PinWear
from tribopipe.contacts.pin_on_track import PinAndTrackWear
from tribopipe.contacts.twin_disc import TwinDiscWear
from tribopipe.contacts.wear import ContactWear, SensedWear
from tribopipe.documents.contact import Contact, SlidingPin
from tribopipe.documents.contact_kinds import family_of
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.twin_disc import TwinDisc
from tribopipe.physics.calculation_methods import DistanceConvention, WearEngine

_NO_SLIP = Quantity(value=0.0, unit="1")


class Terms(NamedTuple):
    """What k_D is right with."""

    slip: Quantity | None = None
    """Nominal slip of bodies that roll."""
    engine: WearEngine = "giwm"
    """Pressure that k_D is found by."""
    distance: DistanceConvention = "full-slip"
    """Convention for the sliding distance in one rotation of bodies that roll."""
    path: Quantity | None = None
    """Sliding distance between two passages of a pin at one place of its track, m."""
    there_and_back: bool = False
    """Whether that path is a stroke."""
    worn: Collection[str] = ()
    """Names of the bodies whose k_D is known."""


def wear_of(contact: Contact, terms: Terms = Terms()) -> ContactWear:  # noqa: B008 - it is immutable
    """Return how the bodies of a contact wear."""
    return family_of(contact, _FAMILIES)(contact, terms)


def sensed_wear(contact: Contact, engine: WearEngine) -> SensedWear:
    """Return how the body that stays in contact wears. Raises ``ContactError`` where both bodies pass."""
    wear = wear_of(contact, Terms(engine=engine))
    if isinstance(wear, SensedWear):
        return wear
    raise ContactError(f"found a {contact.test}; expected a contact whose depth signal shows its wear")


def _pin_wear(contact: SlidingPin, terms: Terms) -> ContactWear:
    counterbody = contact.counterbody_name()
    if counterbody not in terms.worn:
        return PinWear(contact, terms.engine, terms.path if terms.there_and_back else None)
    if terms.path is None:
        raise ContactError(
            "conditions: found neither track_radius nor stroke; expected one of the two, to determine the length of "
            f"the wear track on the {counterbody}; add one to run.toml, such as "
            'track_radius = "5 mm"'
        )
    return PinAndTrackWear(contact, terms.path, terms.engine, terms.there_and_back)


_FAMILIES: dict[type[Contact], Callable[..., ContactWear]] = {
    SlidingPin: _pin_wear,
    TwinDisc: lambda contact, terms: TwinDiscWear(contact, terms.slip or _NO_SLIP, terms.distance),
}
