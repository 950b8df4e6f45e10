"""A contact: a pin pressed against the side of a rotating drum, on which it slides along one circular track.

Near the contact, the sphere of the pin, radius R, and the drum, radius R_d, leave a gap of x²/2R across the sliding
direction and of y²/2·(1/R + 1/R_d) along it. If depths are small compared with both radii, a pin with the radius

    R_e = R / √(1 + R/R_d)

on a flat disc has the same wear volume and the same contact area at each wear depth. Its unworn contact is a circle,
that of the pin on the drum an ellipse (H. Hertz, J. reine angew. Math. 92 (1882) 156). Up to R/R_d = 0.5, the mean
pressures differ by less than 0.5 %, and the wear volumes at a depth of R/100 by less than 0.2 %.
"""

import math
from collections.abc import Mapping
from typing import Any, ClassVar, Literal, Self

from pydantic import model_validator

from tribopipe.documents.contact import Pin, SlidingPin, Specimen
from tribopipe.documents.quantity import Length, Quantity

LARGEST_RATIO = 0.5
"""Largest R/R_d for which these differences are small."""


class Drum(Specimen):
    """The drum, on whose side the pin slides."""

    radius: Length
    """Radius of the side of the drum."""


class PinOnDrum(SlidingPin):
    """A pin pressed against the side of a rotating drum."""

    kind: Literal["pin-on-drum"]
    """Type of tribometer."""
    pin: Pin
    """The pin."""
    drum: Drum
    """The drum."""

    body_names: ClassVar[tuple[str, ...]] = ("pin", "drum")
    both: ClassVar[str] = "pin + drum"
    title: ClassVar[str] = "a pin on the side of a drum"
    track_key: ClassVar[str | None] = "contact.drum.radius"

    @model_validator(mode="after")
    def _the_pin_is_a_sphere(self) -> Self:
        if self.pin.shape != "spherical":
            raise ValueError(
                f"pin.shape: found a {self.pin.shape} pin, which does not make point contact with the "
                "drum; expected a spherical pin; correct pin.shape"
            )
        return self

    @property
    def ratio(self) -> float:
        """R/R_d."""
        return self.pin.radius.value / self.drum.radius.value

    @property
    def equivalent_pin(self) -> Pin:
        """The pin with the radius R_e, with the uncertainty of both radii if stated."""
        radius, share = self.pin.radius, self.ratio / (1 + self.ratio) / 2
        value = radius.value / math.sqrt(1 + self.ratio)
        parts = (((1 - share), radius), (share, self.drum.radius))
        relative = [weight * (one.standard_uncertainty or 0.0) / one.value for weight, one in parts]
        u = None if radius.standard_uncertainty is None else value * math.hypot(*relative)
        equivalent = Quantity(value=value, unit="m", standard_uncertainty=u)
        return self.pin.model_copy(update={"radius": equivalent})

    @property
    def alike(self) -> dict[str, object]:
        """Quantities that must be equal in runs that share one k_D."""
        return super().alike | {"drum radius in m": self.drum.radius.value}

    @property
    def limits(self) -> tuple[str, ...]:
        """The assumed contact, and a warning if the drum is too small."""
        assumption = (
            f"the pin on the drum is treated as a pin of radius {self.equivalent_pin.radius.shown('mm')} on a flat "
            "disc, with a circular contact and one track"
        )
        if self.ratio <= LARGEST_RATIO:
            return (assumption,)
        return (
            assumption,
            f"warning: found a ratio of pin radius to drum radius of {self.ratio:.2g}; expected at most "
            f"{LARGEST_RATIO:g}, beyond which the errors of k_D and wear exceed their uncertainty",
        )

    @classmethod
    def track_radius_of(cls, contact: Mapping[str, Any]) -> Any:
        """Return the radius of the drum."""
        drum = contact.get("drum")
        return drum.get("radius") if isinstance(drum, Mapping) else None
