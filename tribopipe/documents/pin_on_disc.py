"""A pin on a rotating or reciprocating disc, as run.toml describes it."""

from typing import ClassVar, Literal

from tribopipe.documents.contact import Pin, SlidingPin, Specimen


class PinOnDisc(SlidingPin):
    """A pin pressed on a rotating disc."""

    kind: Literal["pin-on-disc"]
    """Type of tribometer."""
    pin: Pin
    """The pin."""
    disc: Specimen
    """The disc."""

    both: ClassVar[str] = "pin + disc"
    title: ClassVar[str] = "a pin on a disc"
