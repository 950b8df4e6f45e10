"""A block pressed on a rotating ring (ASTM G77), as run.toml describes it.

The block touches the ring in a line and wears to a part of a cylinder. A scar of width b along the sliding, under a
ring of radius r and over the width B of the block, has lost

    V = B·(r²·arcsin(b/2r) − (b/4)·√(4r² − b²))

The wear is even across the sliding, so that the volume defines the scar, and the ring loses a layer of equal depth.
"""

import math
from collections.abc import Mapping
from typing import Any, ClassVar, Literal, Self

from pydantic import ConfigDict, model_validator

from tribopipe.base.errors import UnitError
from tribopipe.documents.contact import SlidingPin, Specimen, Tip
from tribopipe.documents.quantity import Length, Quantity, read_quantity, scaled

_SCAR = ("block_scar_width", "pin_scar_length")
"""Key of the scar width of the standard, which is the scar length along the sliding direction here."""

_SAME = 1e-3
"""Relative difference up to which a radius is half of a diameter."""
_NO_WIDTHS = ("pin_scar_diameter", "pin_scar_width")
"""Measurements of round scars, and of scars that are wider if the counterbody has worn."""


class Block(Specimen):
    """The block, which stays in contact."""

    width: Length
    """Width of the block across the sliding direction, which is the length of the line contact with the ring."""


def _may_follow_from_diameter(schema: dict[str, Any]) -> None:
    schema["required"].remove("radius")


class Ring(Specimen):
    """The ring, which rotates."""

    model_config = ConfigDict(json_schema_extra=_may_follow_from_diameter)

    radius: Length
    """Outer radius of the ring; half the diameter if only this is stated."""

    @model_validator(mode="before")
    @classmethod
    def _half_the_diameter(cls, ring: Any) -> Any:
        radius = _radius_of(ring)
        return ring if radius is None else {**ring, "radius": radius}


def _radius_of(ring: Any) -> Any:
    """Return the radius of a ring as it is stated, or half its diameter; None if neither can be read."""
    if not isinstance(ring, Mapping) or "radius" in ring or "diameter" not in ring:
        return ring.get("radius") if isinstance(ring, Mapping) else None
    try:
        return scaled(read_quantity(ring["diameter"], "length"), 0.5)
    except (UnitError, ValueError):
        return None  # the diameter itself is refused, with its key


class BlockTip(Tip):
    """A block as the tip whose gap to a flat is that to the ring."""

    shape: Literal["block"]
    width: float
    """m."""

    @property
    def line(self) -> float:
        """Width of the block, m."""
        return self.width

    @property
    def depth_exponent(self) -> float:
        """Exponent n of depth ∝ sⁿ under Archard's law."""
        return 2 / 3

    @property
    def usual_measurement(self) -> str:
        """Key of the width of the scar, which is its length along the sliding direction."""
        return _SCAR[1]


class BlockOnRing(SlidingPin):
    """A block pressed on a rotating ring."""

    kind: Literal["block-on-ring"]
    """Type of tribometer."""
    block: Block
    """The block."""
    ring: Ring
    """The ring."""

    body_names: ClassVar[tuple[str, ...]] = ("block", "ring")
    fitted_bodies: ClassVar[tuple[str, ...]] = ("block",)
    both: ClassVar[str] = "block + ring"
    title: ClassVar[str] = "a block on a ring"
    standard: ClassVar[str] = "g77"
    track_key: ClassVar[str | None] = "contact.ring.radius"
    usual_diameters: ClassVar[tuple[float, ...]] = (35.0, 49.22)

    @property
    def pin(self) -> BlockTip:
        """The block as a tip."""
        stated = {name: getattr(self.block, name) for name in Specimen.model_fields}
        return BlockTip(shape="block", radius=self.ring.radius, width=self.block.width.value, **stated)

    @property
    def inputs(self) -> dict[str, Quantity]:
        """Radius of the ring, and the moduli, by their keys."""
        return {"ring.radius": self.ring.radius, **self.moduli}

    @property
    def unworn_radii(self) -> tuple[float, float]:
        """Radii of the gap before the test across the motion, where it is even, and along it, m."""
        return math.inf, self.ring.radius.value

    @property
    def own_track_radius(self) -> Quantity:
        """Radius of the ring, m."""
        return self.ring.radius

    @property
    def alike(self) -> dict[str, object]:
        """What else than the materials runs must have in common for one k_D, by its name."""
        return {"block width in m": self.block.width.value, "ring radius in m": self.ring.radius.value}

    @property
    def limits(self) -> tuple[str, ...]:
        """State what is taken of the contact."""
        return ("the block is assumed to wear uniformly over its width and to conform to the ring",)

    @model_validator(mode="after")
    def _radius_is_half_the_diameter(self) -> Self:
        radius, diameter = self.ring.radius, self.ring.diameter
        if diameter is not None and not math.isclose(2 * radius.value, diameter.value, rel_tol=_SAME):
            raise ValueError(
                f"ring.radius: found {radius.shown('mm')} for a ring diameter of {diameter.shown('mm')}; expected half "
                "the diameter; correct one of the two"
            )
        return self

    def with_bodies(self, pin: Tip, counterbody: Specimen) -> Self:
        """Return a copy of the contact with other moduli, and the ring as large as the tip."""
        block = self.block.model_copy(update={"youngs_modulus": pin.youngs_modulus})
        ring = {"radius": pin.radius, "youngs_modulus": counterbody.youngs_modulus}
        return self.model_copy(update={"block": block, "ring": self.ring.model_copy(update=ring)})

    def refuse_wear(self, where: str, measured: Any) -> None:
        """Raise ``ValueError`` for scars that are no width of a block's, and for more wear than the ring reaches."""
        for name in _NO_WIDTHS:
            if getattr(measured, name) is not None:
                raise ValueError(
                    f"{where}.{name}: found this key for a block; expected block_scar_width, the width of the scar "
                    "along the sliding direction; rename the key"
                )
        super().refuse_wear(where, measured)

    @classmethod
    def track_radius_of(cls, contact: Mapping[str, Any]) -> Any:
        """Return the radius of the ring."""
        return _radius_of(contact.get("ring"))

    @classmethod
    def _in_roles(cls, where: str, ends: Mapping[str, Any]) -> dict[str, Any]:
        if "block_scar_length" in ends:
            raise ValueError(
                f"{where}.block_scar_length: found a scar length; expected block_scar_width, the width of the scar "
                "along the sliding direction; rename the key if this width was measured"
            )
        return super()._in_roles(where, ends)

    @classmethod
    def _role_key(cls, key: str) -> str:
        return _SCAR[1] if key == _SCAR[0] else super()._role_key(key)

    @classmethod
    def _in_own_names(cls, ends: Any) -> Any:
        known = isinstance(ends, Mapping)
        return super()._in_own_names({key: ends[key] for key in ends if key not in _NO_WIDTHS} if known else ends)

    @classmethod
    def worded(cls, text: str) -> str:
        """Return a text in the names of this contact."""
        for written in (_SCAR[1], _SCAR[1].replace("_", " ")):
            text = text.replace(written, _SCAR[0] if "_" in written else _SCAR[0].replace("_", " "))
        # The radius of the gap is the ring's.
        worded = (
            super()
            .worded(text)
            .replace("or block_scar_diameter", f"or {_SCAR[0]}")
            .replace("block's diam", "ring's diam")
        )
        return worded.replace("radius of the block", "radius of the ring").replace("block radius", "ring radius")
