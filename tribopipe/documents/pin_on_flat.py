"""A pin or ball on a flat counterbody, as run.toml describes it.

The counterbody is a disc that rotates or reciprocates (ASTM G99), or a flat on which the pin slides back and forth
(ASTM G133).
"""

from typing import Any, ClassVar, Literal

from tribopipe.documents.contact import Ball, Pin, SlidingBall, SlidingPin, Specimen


class PinOnDisc(SlidingPin):
    """A pin pressed on a rotating disc."""

    kind: Literal["pin-on-disc"]
    """Type of tribometer."""
    pin: Pin
    """The pin."""
    disc: Specimen
    """The disc."""

    both: ClassVar[str] = "pin + disc"
    tribodatafair: ClassVar[str | None] = "PinonDiscMachine"
    title: ClassVar[str] = "a pin on a disc"


class BallOnDisc(SlidingBall):
    """A ball pressed on a rotating disc."""

    kind: Literal["pin-on-disc"]
    """Type of tribometer."""
    ball: Ball
    """The ball."""
    disc: Specimen
    """The disc."""

    both: ClassVar[str] = "ball + disc"
    tribodatafair: ClassVar[str | None] = PinOnDisc.tribodatafair
    title: ClassVar[str] = "a ball on a disc"


class _OnFlat(SlidingPin):
    """Sliding back and forth on a flat."""

    standard: ClassVar[str] = "g133"
    needed_conditions: ClassVar[tuple[str, ...]] = ("stroke",)

    def refuse_conditions(self, conditions: Any) -> None:
        """Raise ``ValueError`` for a motion without a stroke, and for one in a circle."""
        turning = next((name for name in ("track_radius", "rotational_speed") if getattr(conditions, name)), None)
        if turning is not None:
            raise ValueError(
                f"conditions.{turning}: found a key of circular sliding in a reciprocating run; expected stroke and "
                "frequency; "
                'remove the key, or write kind = "pin-on-disc"'
            )
        if conditions.stroke is None:
            raise ValueError(
                "conditions.stroke: missing; expected the stroke length, which is the length of the wear track on the "
                "flat; add this key, such as "
                'stroke = "10 mm"'
            )


class Reciprocating(_OnFlat):
    """A pin that slides back and forth on a flat."""

    kind: Literal["reciprocating"]
    """Type of tribometer."""
    pin: Pin
    """The pin."""
    flat: Specimen
    """The flat."""

    body_names: ClassVar[tuple[str, ...]] = ("pin", "flat")
    both: ClassVar[str] = "pin + flat"
    title: ClassVar[str] = "a pin reciprocating on a flat"


class ReciprocatingBall(_OnFlat, SlidingBall):
    """A ball that slides back and forth on a flat."""

    kind: Literal["reciprocating"]
    """Type of tribometer."""
    ball: Ball
    """The ball."""
    flat: Specimen
    """The flat."""

    body_names: ClassVar[tuple[str, ...]] = ("ball", "flat")
    both: ClassVar[str] = "ball + flat"
    title: ClassVar[str] = "a ball reciprocating on a flat"
