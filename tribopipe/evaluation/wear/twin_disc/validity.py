"""Where two discs start, and where they leave what the wear model describes."""

from tribopipe.base.arrays import Values
from tribopipe.base.units import show
from tribopipe.contacts.twin_disc import disc_pair
from tribopipe.documents.contact import TwinDisc
from tribopipe.documents.quantity import Quantity
from tribopipe.physics.hertz import HARDNESS_UNIT
from tribopipe.physics.hertz_ellipse import hertz_ellipse
from tribopipe.results.wear_fit import HertzStart

_FLAT_CROWN = 0.5
"""Half width of the worn flat over the crown radius, beyond which the model was never tested."""
_SLIP_LOST = 0.25
"""Share of the slip, by which it may change before it is worth a word."""


def hertz_start(contact: TwinDisc, values: Values) -> HertzStart:
    """Return Hertz's contact of the unworn discs, for single values of the inputs."""
    # The way of counting distance plays no part before anything is slid.
    load, crown, curved, flat, modulus, _ = (float(x) for x in disc_pair(contact, values, "full-slip").inputs)
    ellipse = hertz_ellipse(normal_load=load, radius_x=crown, radius_z=curved * flat / (curved + flat), modulus=modulus)
    return HertzStart(
        half_width=Quantity(value=ellipse.half_width, unit="m"),
        half_length=Quantity(value=ellipse.half_length, unit="m"),
        peak_pressure=Quantity(value=ellipse.peak_pressure, unit="Pa"),
    )


def validity_notes(
    contact: TwinDisc, start: HertzStart, slip: float, half_width: float, slip_of_worn: float
) -> tuple[str, ...]:
    """Say where discs worn to a flat of some half width, m, or their slip, leave what the model describes."""
    crown, width, notes = contact.curved_disc.crown_radius, 2 * half_width, []
    hardness = [body.vickers_hardness for body in contact.bodies.values() if body.vickers_hardness is not None]
    if hardness and start.peak_pressure.value > min(hardness) * HARDNESS_UNIT:
        softer = Quantity(value=min(hardness) * HARDNESS_UNIT, unit="Pa")
        notes.append(
            f"extrapolation: Hertz's pressure of {start.peak_pressure.shown('GPa')} at the start exceeds the hardness "
            f"of the softer disc, {softer.shown('GPa')}: it yields before it wears"
        )
    if half_width > _FLAT_CROWN * crown.value:
        notes.append(
            f"extrapolation: the worn flat is {show(width, None, 'm', 'mm')} wide, more than the crown radius of "
            f"{crown.shown('mm')}: the model takes worn surfaces as flat, and was never tested that far"
        )
    widths = [disc.width.value for disc in (contact.curved_disc, contact.flat_disc) if disc.width is not None]
    if widths and width > min(widths):
        notes.append(
            f"extrapolation: the worn flat would be {show(width, None, 'm', 'mm')} wide on a disc of "
            f"{show(min(widths), None, 'm', 'mm')}: beyond that the contact no longer widens, and the model ends"
        )
    if abs(slip_of_worn - slip) > _SLIP_LOST * abs(slip):
        notes.append(f"wear changes the slip from {slip:.2%} to {slip_of_worn:.2%} at constant rotation rates")
    return tuple(notes)
