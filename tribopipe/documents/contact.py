"""The two bodies of a contact as they went into the test, and what wear grows along on each kind of tribometer."""

import math
from typing import Annotated, ClassVar, Literal, NamedTuple, Self, TypeAlias

from pydantic import AfterValidator, Field, model_validator

from tribopipe.documents.quantity import Density, Length, Pressure, Quantity, Ratio, Toughness
from tribopipe.documents.record import Record
from tribopipe.documents.signals import SignalName


class Progress(NamedTuple):
    """What wear grows along on a tribometer: the axis of its curves, and how far a test went."""

    signal: SignalName
    """Its column; ``conditions`` names the planned end alike."""
    kind: str
    """Kind of number, of ``tribopipe.base.units.KINDS``."""
    unit: str
    """As people read it."""
    speed: str
    """Which of ``conditions`` is the speed by which it follows from time."""
    example: str
    """A place along it as one would write it."""

    @property
    def words(self) -> str:
        """Its name in a sentence."""
        return self.signal.replace("_", " ")

    def shown(self, value: float) -> str:
        """Write a place for people: "50 m", "1,000 rotations"."""
        return f"{value:,.0f} {self.unit}" if self.kind == "count" else f"{value:.6g} {self.unit}"


SLIDING = Progress("sliding_distance", "distance", "m", "sliding_speed", "500 m")
ROTATIONS = Progress("rotations", "count", "rotations", "curved_disc_speed", "1e6")


def _physical_poisson_ratio(ratio: Quantity) -> Quantity:
    if not -1 < ratio.value <= 0.5:
        raise ValueError(f"found {ratio.value:g}; expected a Poisson ratio above -1 and at most 0.5")
    return ratio


class Specimen(Record):
    """One of the two bodies: its material and surface as they went into the test."""

    material: str = Field(min_length=1)
    """Material as the lab calls it: "Si3N4"."""
    youngs_modulus: Pressure
    """E of Eq. 3."""
    poisson_ratio: Annotated[Ratio, AfterValidator(_physical_poisson_ratio)]
    """ν of Eq. 3."""
    density: Density | None = None
    """Needed for end values given as a mass."""
    surface_roughness: Length | None = None
    """Arithmetic mean roughness Ra before the test."""
    vickers_hardness: float | None = Field(default=None, gt=0)
    """HV, a number without a unit as usual."""
    fracture_toughness: Toughness | None = None
    """K_Ic."""
    diameter: Length | None = None
    """Outer diameter of the specimen."""


class Pin(Specimen):
    """The pin or ball that rubs on the disc."""

    shape: Literal["spherical", "flat", "truncated-sphere"]
    """Spherical tip, a flat end of constant area, or a sphere with a flat ground or worn on it before the test."""
    radius: Length
    """Radius R_P of a spherical tip, truncated or not; radius of the flat end of a flat pin."""
    flat_radius: Length | None = None
    """Radius of the flat on a truncated sphere before the test."""

    @model_validator(mode="after")
    def _flat_belongs_to_a_truncated_sphere(self) -> Self:
        if (self.flat_radius is None) == (self.shape == "truncated-sphere"):
            found = "none" if self.flat_radius is None else self.flat_radius.shown("um")
            raise ValueError(
                f"flat_radius: found {found} on a {self.shape} pin; expected the radius of the flat on a pin of the "
                "shape truncated-sphere, and on no other; correct shape or flat_radius"
            )
        if self.flat_radius is not None and self.flat_radius.value >= self.radius.value:
            raise ValueError(
                f"flat_radius: found {self.flat_radius.shown('um')}, no less than the radius of the sphere of "
                f"{self.radius.shown('um')}; expected a smaller one; check both units"
            )
        return self


class PinOnDisc(Record):
    """A pin pressed on a rotating disc."""

    kind: Literal["pin-on-disc"]
    """Type of tribometer."""
    pin: Pin
    """The pin."""
    disc: Specimen
    """The disc."""

    progress: ClassVar[Progress] = SLIDING
    body_names: ClassVar[tuple[str, ...]] = ("pin", "disc")
    """Both bodies."""
    fitted_bodies: ClassVar[tuple[str, ...]] = ("pin",)
    """Those whose k_D is found, the one that every fit finds first."""
    shown: ClassVar[tuple[str, ...]] = ("wear_depth", "pressure")
    """What tables say of predicted wear."""
    rolls: ClassVar[bool] = False
    """Whether the bodies roll on each other and slip, so that rotations count."""
    both: ClassVar[str] = "pin + disc"
    """Both bodies in words."""
    slid: ClassVar[str] = "sliding distance"
    """What the distance is called that the bodies slide on each other."""

    @property
    def travel(self) -> float:
        """Distance, m, at the nominal speed in one unit of the progress."""
        return 1.0

    @property
    def bodies(self) -> dict[str, Specimen]:
        """The two bodies by name."""
        return {"pin": self.pin, "disc": self.disc}

    @property
    def alike(self) -> dict[str, object]:
        """What else than the materials runs must have in common for one k_D, by its name."""
        return {"pin shape": self.pin.shape, "pin radius in m": self.pin.radius.value}


class CurvedDisc(Specimen):
    """The disc with a crown."""

    rolling_radius: Length
    """r₁z: radius along the direction of rolling."""
    crown_radius: Length
    """r₁x: radius of its surface across the direction of rolling."""
    width: Length | None = None
    """Width of the running surface, beyond which a worn flat cannot widen."""


class FlatDisc(Specimen):
    """The disc whose running surface is flat across the direction of rolling."""

    rolling_radius: Length
    """r₂z: radius along the direction of rolling."""
    width: Length | None = None
    """Width of the running surface."""


class TwinDisc(Record):
    """Two discs that roll on each other and slip."""

    kind: Literal["twin-disc"]
    """Type of tribometer."""
    curved_disc: CurvedDisc
    """The disc with a crown; rotations are counted on it."""
    flat_disc: FlatDisc
    """The flat disc."""

    progress: ClassVar[Progress] = ROTATIONS
    body_names: ClassVar[tuple[str, ...]] = ("curved_disc", "flat_disc")
    """Both bodies."""
    fitted_bodies: ClassVar[tuple[str, ...]] = ("curved_disc", "flat_disc")
    """Those whose k_D is found, the one that every fit finds first."""
    shown: ClassVar[tuple[str, ...]] = ("wear_depth", "wear_volume")
    """What tables say of predicted wear."""
    rolls: ClassVar[bool] = True
    """Whether the bodies roll on each other and slip, so that rotations count."""
    both: ClassVar[str] = "both discs"
    """Both bodies in words."""
    slid: ClassVar[str] = "slip distance"
    """What the distance is called that the bodies slide on each other."""

    @property
    def travel(self) -> float:
        """Distance, m, that the surface of the curved disc goes in a rotation."""
        return 2 * math.pi * self.curved_disc.rolling_radius.value

    @property
    def bodies(self) -> dict[str, Specimen]:
        """The two bodies by name."""
        return {"curved_disc": self.curved_disc, "flat_disc": self.flat_disc}

    @property
    def alike(self) -> dict[str, object]:
        """What else than the materials runs must have in common for one k_D, by its name."""
        return {
            "crown radius in m": self.curved_disc.crown_radius.value,
            "curved disc's radius in m": self.curved_disc.rolling_radius.value,
            "flat disc's radius in m": self.flat_disc.rolling_radius.value,
        }


DiscName = Literal["curved_disc", "flat_disc"]
DISCS: tuple[DiscName, DiscName] = ("curved_disc", "flat_disc")
"""In the order of k₁ and k₂."""
Contact: TypeAlias = PinOnDisc | TwinDisc
CONTACTS: dict[str, type[Contact]] = {"pin-on-disc": PinOnDisc, "twin-disc": TwinDisc}
"""Each kind of contact by its name in run.toml."""
