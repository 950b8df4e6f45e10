"""Two discs that roll on each other and slip, as run.toml describes them."""

import math
from collections.abc import Mapping
from typing import Any, ClassVar, Literal, Self

from tribopipe.documents.contact import ROTATIONS, Contact, ModulusInput, Progress, Specimen
from tribopipe.documents.quantity import Length, Quantity

DiscName = Literal["curved_disc", "flat_disc"]
DISCS: tuple[DiscName, DiscName] = ("curved_disc", "flat_disc")
"""Names of the discs, in the order of k₁ and k₂."""


class CurvedDisc(Specimen):
    """The disc with a crown."""

    rolling_radius: Length
    """r₁z: radius along the direction of rolling."""
    crown_radius: Length
    """r₁x: radius of the surface across the direction of rolling."""
    width: Length | None = None
    """Width of the running surface, which limits the width of the worn flat."""

    size_keys: ClassVar[tuple[str, ...] | None] = ("rolling_radius", "crown_radius")


class FlatDisc(Specimen):
    """The disc whose running surface is flat across the direction of rolling."""

    rolling_radius: Length
    """r₂z: radius along the direction of rolling."""
    width: Length | None = None
    """Width of the running surface."""

    size_keys: ClassVar[tuple[str, ...] | None] = ("rolling_radius",)


class TwinDisc(Contact):
    """Two discs that roll on each other and slip."""

    kind: Literal["twin-disc"]
    """Type of tribometer."""
    curved_disc: CurvedDisc
    """The disc with a crown; rotations are counted on it."""
    flat_disc: FlatDisc
    """The cylindrical disc."""

    progress: ClassVar[Progress] = ROTATIONS
    body_names: ClassVar[tuple[str, ...]] = ("curved_disc", "flat_disc")
    roles: ClassVar[tuple[str, ...]] = ("curved_disc", "flat_disc")
    fitted_bodies: ClassVar[tuple[str, ...]] = ("curved_disc", "flat_disc")
    shown: ClassVar[tuple[str, ...]] = ("wear_depth", "wear_volume")
    test: ClassVar[str] = "twin-disc run"
    study_word: ClassVar[str] = "twin disc"
    modulus_inputs: ClassVar[tuple[ModulusInput, ...]] = ("curved_modulus", "flat_modulus")
    family_conditions: ClassVar[tuple[str, ...]] = ("curved_disc_speed", "flat_disc_speed", "slip", "rotations")
    replaced_conditions: ClassVar[Mapping[str, str]] = {"slip": "flat_disc_speed"}
    both: ClassVar[str] = "both discs"
    body_words: ClassVar[Mapping[str, str]] = {"curved_disc": "crowned disc", "flat_disc": "cylindrical disc"}
    slid: ClassVar[str] = "slip distance"
    title: ClassVar[str] = "two discs in rolling-sliding contact"

    @property
    def travel(self) -> float:
        """Distance, m, that the surface of the crowned disc goes in a rotation."""
        return 2 * math.pi * self.curved_disc.rolling_radius.value

    def slip(self, conditions: Any, default: float = 0.0) -> Quantity:
        """Return (v₂ − v₁)/v₁; its uncertainty is that stated, or follows from those stated of the speeds.

        If only one speed has an uncertainty, the other adds a fraction of the slip, ``default``.
        """
        stated, curved, flat = conditions.slip, conditions.curved_disc_speed, conditions.flat_disc_speed
        if stated is not None or curved is None or flat is None:
            return stated or Quantity(value=0.0, unit="1")
        ratio, speeds = flat.value / curved.value, (curved, flat)
        known = [ratio * one.standard_uncertainty / one.value for one in speeds if one.standard_uncertainty is not None]
        other = default * abs(ratio - 1) if len(known) == 1 else 0.0
        return Quantity(value=ratio - 1, unit="1", standard_uncertainty=math.hypot(*known, other) if known else None)

    @property
    def rolling_radii(self) -> tuple[Quantity, ...]:
        """r₁z and r₂z, m."""
        return self.curved_disc.rolling_radius, self.flat_disc.rolling_radius

    def friction_arm(self, _: float | None, /) -> float:
        """Return the radius of the crowned disc, m."""
        return self.curved_disc.rolling_radius.value

    @property
    def inputs(self) -> dict[str, Quantity]:
        """Radii and moduli of the discs, by their keys."""
        radii = {f"{name}.rolling_radius": getattr(self, name).rolling_radius for name in self.body_names}
        return {"curved_disc.crown_radius": self.curved_disc.crown_radius, **radii, **self.moduli}

    @property
    def unworn_radii(self) -> tuple[float, float]:
        """Radii of the gap before the test across the motion and along it, m."""
        curved, flat = self.curved_disc.rolling_radius.value, self.flat_disc.rolling_radius.value
        return self.curved_disc.crown_radius.value, curved * flat / (curved + flat)

    @property
    def round_surfaces(self) -> dict[str, Quantity]:
        """Radius of the crown, m."""
        return {"curved_disc": self.curved_disc.crown_radius}

    @property
    def worn_radius(self) -> tuple[str, Quantity]:
        """Return the name of the radius that is worn flat, and the radius, m."""
        return "crown radius", self.curved_disc.crown_radius

    def resized(self, radius: Quantity) -> Self:
        """Return a copy of the contact with another crown radius, m."""
        return self.model_copy(update={"curved_disc": self.curved_disc.model_copy(update={"crown_radius": radius})})

    @property
    def alike(self) -> dict[str, object]:
        """What else than the materials runs must have in common for one k_D, by its name."""
        return {
            "crown radius in m": self.curved_disc.crown_radius.value,
            "crowned disc's radius in m": self.curved_disc.rolling_radius.value,
            "cylindrical disc's radius in m": self.flat_disc.rolling_radius.value,
        }

    def refuse_conditions(self, conditions: Any) -> None:
        """Raise ``ValueError`` for discs that do not slip, or whose slip is stated twice."""
        slip = conditions.slip
        curved, flat = (getattr(conditions, f"{disc}_speed") for disc in self.body_names)
        if slip is None and None in (curved, flat):
            raise ValueError(
                'conditions.slip: missing; expected the slip of the discs, or the speeds of both; add slip = "4 %", or '
                "curved_disc_speed and flat_disc_speed"
            )
        if slip is not None and flat is not None:
            raise ValueError(
                "conditions.slip: found slip in addition to flat_disc_speed, which is equivalent; expected only one of "
                "the two; remove the other"
            )
        equal = slip is None and curved is not None and flat is not None and curved.value == flat.value
        if equal or (slip is not None and slip.value == 0):
            raise ValueError(
                "conditions.slip: found zero slip, with both discs at the same speed; expected a nonzero slip, since "
                "there is no sliding wear in pure rolling; check both speeds"
            )
        if slip is not None and slip.value <= -1:
            raise ValueError(
                f"conditions.slip: found {slip.shown('%')}; expected a slip greater than -100 %, at which the "
                "cylindrical disc stands still; enter the slip as (v2 - v1)/v1"
            )

    def refuse_wear(self, where: str, measured: Any) -> None:
        """Raise ``ValueError`` for a depth or a track beyond the crown, or a track wider than its disc."""
        crown = self.curved_disc.crown_radius
        for name, disc in (("curved_disc", self.curved_disc), ("flat_disc", self.flat_disc)):
            depth, width = getattr(measured, f"{name}_wear_depth"), getattr(measured, f"{name}_track_width")
            if depth is not None and depth.value >= crown.value:
                raise ValueError(
                    f"{where}.{name}_wear_depth: found {depth.shown('um')}, not less than the crown radius of "
                    f"{crown.shown('mm')}; expected a smaller wear depth; check the units of both values"
                )
            if width is not None and width.value >= 2 * crown.value:
                raise ValueError(
                    f"{where}.{name}_track_width: found {width.shown('mm')}, not less than twice the crown radius of "
                    f"{crown.shown('mm')}; expected a narrower wear track; check the units of both values"
                )
            if width is not None and disc.width is not None and width.value > disc.width.value:
                raise ValueError(
                    f"{where}.{name}_track_width: found {width.shown('mm')}, more than the disc width of "
                    f"{disc.width.shown('mm')}; expected a narrower wear track; check the units of both values"
                )
