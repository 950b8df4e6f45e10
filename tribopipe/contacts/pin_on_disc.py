"""A pin on a disc: from what run.toml states of it to the curve of its wear."""

from tribopipe.base.arrays import Values
from tribopipe.base.errors import ContactError
from tribopipe.documents.contact import SlidingPin
from tribopipe.physics.conventions import WearEngine
from tribopipe.physics.hertz import contact_modulus
from tribopipe.physics.local.sphere import LocalSphere
from tribopipe.physics.pin_on_disc import FlatPin, PinContact, RigidSphere, SphericalPin


def pin_contact(contact: SlidingPin, values: Values) -> PinContact:
    """Build the pin's master curve from ``normal_load``, ``pin_radius``, ``pin_modulus`` and ``disc_modulus``.

    The flat of a truncated sphere is taken as run.toml states it: it is not among what is uncertain.
    """
    if contact.pin.shape == "flat":
        return FlatPin(values["pin_radius"])
    modulus = contact_modulus(
        pin_modulus=values["pin_modulus"],
        pin_ratio=contact.pin.poisson_ratio.value,
        disc_modulus=values["disc_modulus"],
        disc_ratio=contact.counterbody.poisson_ratio.value,
    )
    return SphericalPin(
        normal_load=values["normal_load"],
        radius=values["pin_radius"],
        modulus=modulus,
        flat_radius=0.0 if contact.pin.flat_radius is None else contact.pin.flat_radius.value,
    )


def pin_curve(contact: SlidingPin, values: Values, engine: WearEngine) -> PinContact:
    """Build the pin's curve by an engine, from the values that ``pin_contact`` takes.

    Raises ``ContactError`` for local wear of a truncated sphere, whose flat has an edge that Hertz's contact does not.
    """
    pin = pin_contact(contact, values)
    if engine == "giwm" or not isinstance(pin, SphericalPin):
        return pin
    if engine == "volume":
        return RigidSphere(pin.radius, pin.flat_radius)
    if contact.pin.flat_radius is not None:
        raise ContactError(
            f"local wear: found a truncated sphere with a flat of {contact.pin.flat_radius.shown('um')}; expected a "
            "whole sphere or a flat pin; fit and predict it by the GIWM, --engine giwm"
        )
    return LocalSphere(pin)
