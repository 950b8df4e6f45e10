"""Four balls, one of which rotates against three stationary ones (ASTM D4172, D5183), as run.toml describes them.

The centers of the balls, of radius R, are the vertices of a regular tetrahedron. The line from the top ball to one
below is inclined to the axis by θ with cos θ = √(2/3), and the balls touch in a circle of radius R/√3 about the axis.
Hence

    F_n = F/√6        normal load on each of the three contacts under the load F as it is applied
    μ = T·√2/(R·F)    by the friction torque T about the axis
    D = √(2/3)·d      approach of two balls where the top one sinks by d

Two balls of radius R leave the gap of one of radius R/2 on a flat, so that a scar of diameter d on a ball means a
volume of π·d⁴/(32·R). Every place of the track of the top ball meets three contacts a turn.
"""

import math
from collections.abc import Mapping
from typing import Any, ClassVar, Literal, Self

from pydantic import model_validator

from tribopipe.base.errors import UnitError
from tribopipe.documents.contact import Ball, Pin, SlidingBall, Specimen, Tip
from tribopipe.documents.quantity import Quantity, read_quantity, scaled

_SAME = 1e-3
"""Relative difference of diameters up to which balls count as equal."""
_GRADE = 1e-4
"""Relative standard uncertainty of a diameter that states none: bearing balls are made to less."""


class FourBall(SlidingBall):
    """Three stationary balls, and one that rotates on them."""

    kind: Literal["four-ball"]
    """Type of tribometer."""
    ball: Ball
    """The three stationary balls."""
    top_ball: Ball
    """The rotating ball; default: same as the stationary balls."""

    body_names: ClassVar[tuple[str, ...]] = ("ball", "top_ball")
    both: ClassVar[str] = "ball + top ball"
    title: ClassVar[str] = "a ball that rotates on three others"
    standard: ClassVar[str] = "d4172"
    track_key: ClassVar[str | None] = "contact.ball.diameter"
    usual_diameters: ClassVar[tuple[float, ...]] = (12.7,)
    equivalent_words: ClassVar[str] = "equivalent ball"
    own_conditions: ClassVar[tuple[str, ...]] = ("weld_load",)
    like: ClassVar[Mapping[str, str]] = {"top_ball": "ball"}
    load_share: ClassVar[float] = 1 / math.sqrt(6)
    depth_share: ClassVar[float] = math.sqrt(2 / 3)
    contacts_per_turn: ClassVar[int] = 3

    @model_validator(mode="before")
    @classmethod
    def _balls_are_alike_unless_stated(cls, contact: Any) -> Any:
        if not isinstance(contact, Mapping):
            return contact
        return {body: contact[other] for body, other in cls.like.items() if other in contact} | {**contact}

    @model_validator(mode="after")
    def _balls_are_equal(self) -> Self:
        one, other = self.ball.diameter, self.top_ball.diameter
        if not math.isclose(one.value, other.value, rel_tol=_SAME):
            raise ValueError(
                f"top_ball.diameter: found {other.shown('mm')}, but ball.diameter is {one.shown('mm')}; expected four "
                "balls of the same diameter, as the load per contact is calculated for equal balls; correct one of the "
                "diameters"
            )
        return self

    @property
    def equivalent_pin(self) -> Pin:
        """The pin of the radius R/2."""
        return self.pin.model_copy(update={"radius": scaled(self.ball.diameter, 0.25)})

    @property
    def own_track_radius(self) -> Quantity:
        """Radius of the circle on which the balls touch, m."""
        return _circle(self.ball.diameter)

    def friction_arm(self, _: float | None, /) -> float:
        """Return R/√2, m, so that the force over the load applied is μ."""
        return self.ball.diameter.value / (2 * math.sqrt(2))

    @property
    def alike(self) -> dict[str, object]:
        """What else than the materials runs must have in common for one k_D, by its name."""
        return {"ball diameter in m": self.ball.diameter.value}

    @property
    def limits(self) -> tuple[str, ...]:
        """State which load and which ball are taken."""
        return (
            f"each of the three contacts carries {self.load_share:.3f} of the applied load; the wear is that of one "
            f"lower ball, treated as a ball of {self.equivalent_pin.radius.shown('mm')} radius on a flat",
        )

    def with_bodies(self, pin: Tip, counterbody: Specimen) -> Self:
        """Return a copy of the contact with other bodies, the balls as large as the pin."""
        diameter = scaled(pin.radius, 2.0)
        bodies = {"ball": (self.ball, pin), "top_ball": (self.top_ball, counterbody)}
        return self.model_copy(
            update={
                name: ball.model_copy(update={"diameter": diameter, "youngs_modulus": body.youngs_modulus})
                for name, (ball, body) in bodies.items()
            }
        )

    def refuse_conditions(self, conditions: Any) -> None:
        """Raise ``ValueError`` for a load at which the balls weld, so that nothing slides."""
        load, weld = conditions.normal_load, conditions.weld_load
        if weld is not None and load.value >= weld.value:
            raise ValueError(
                f"conditions.normal_load: found {load.shown('N')}, not less than the weld load of {weld.shown('N')}; "
                "expected a load below the weld load, since welded balls do not slide; check the units of both values"
            )

    @classmethod
    def track_radius_of(cls, contact: Mapping[str, Any]) -> Any:
        """Return the radius of the circle on which the balls touch."""
        ball = contact.get("ball")
        try:
            return _circle(read_quantity(ball.get("diameter"), "length")) if isinstance(ball, Mapping) else None
        except (UnitError, ValueError):
            return None  # the diameter itself is refused, with its key


def _circle(diameter: Quantity) -> Quantity:
    """Return the radius of the circle on which four equal balls touch, R/√3."""
    spread = diameter.standard_uncertainty
    known = diameter.value * _GRADE if spread is None else spread
    circle = Quantity(value=diameter.value, unit="m", standard_uncertainty=known)
    return scaled(circle, 0.5 / math.sqrt(3))
