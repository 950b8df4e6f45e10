"""The two bodies of a contact as they went into the test, and what wear grows along on each kind of tribometer.

Another package adds a kind under the entry point ``tribopipe.contacts``; its class is a ``SlidingPin``.
"""

import math
import re
from collections.abc import Mapping
from importlib.metadata import EntryPoint
from typing import Annotated, Any, ClassVar, Literal, NamedTuple, Self, TypeVar, cast, get_args

from pydantic import (
    AfterValidator,
    Field,
    GetCoreSchemaHandler,
    ValidationInfo,
    ValidatorFunctionWrapHandler,
    model_validator,
)
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from tribopipe.base.plugins import Plugins
from tribopipe.base.units import show
from tribopipe.documents.quantity import Density, Length, Pressure, Quantity, Ratio, Toughness
from tribopipe.documents.record import Record
from tribopipe.documents.signals import SignalName

Answer = TypeVar("Answer")


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
    """Needed for post-test measurements given as a mass."""
    surface_roughness: Length | None = None
    """Arithmetic mean roughness Ra before the test."""
    vickers_hardness: float | None = Field(default=None, gt=0)
    """HV, a number without a unit as usual."""
    fracture_toughness: Toughness | None = None
    """K_Ic."""
    diameter: Length | None = None
    """Outer diameter of the specimen."""
    film_thickness: Length | None = None
    """Thickness of a coating on it: k_D of a test that wears through it is of no material."""


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


class Contact(Record):
    """Two bodies that wear each other; each kind states what follows from it."""

    kind: str
    """Type of tribometer."""

    progress: ClassVar[Progress]
    body_names: ClassVar[tuple[str, ...]]
    """Both bodies, as run.toml and people call them."""
    roles: ClassVar[tuple[str, ...]]
    """Both bodies, in the same order, as post-test measurements and results of this family call them."""
    fitted_bodies: ClassVar[tuple[str, ...]]
    """Those whose k_D is found, the one that every fit finds first."""
    shown: ClassVar[tuple[str, ...]]
    """What tables state about predicted wear."""
    rolls: ClassVar[bool] = False
    """Whether the bodies roll on each other and slip, so that rotations count."""
    both: ClassVar[str]
    """Both bodies in words."""
    body_words: ClassVar[Mapping[str, str]] = {}
    """Names for readers of bodies whose name in run.toml is different."""
    slid: ClassVar[str] = "sliding distance"
    """What the distance is called that the bodies slide on each other."""
    sensor_tells: ClassVar[bool] = False
    """Whether the depth reading of a test gives the wear without a measurement after it."""
    title: ClassVar[str]
    """What the test is called in a sentence: "a pin on a disc"."""

    @property
    def travel(self) -> float:
        """Distance, m, at the nominal speed in one unit of the progress."""
        return 1.0

    @property
    def bodies(self) -> dict[str, Specimen]:
        """The two bodies by name."""
        return {name: getattr(self, name) for name in self.body_names}

    @classmethod
    def body_name(cls, role: str) -> str:
        """Return the name of the body in a role."""
        return dict(zip(cls.roles, cls.body_names, strict=True))[role]

    @property
    def in_roles(self) -> dict[str, Specimen]:
        """The two bodies by role."""
        return dict(zip(self.roles, self.bodies.values(), strict=True))

    @property
    def alike(self) -> dict[str, object]:
        """What else than the materials runs must have in common for one k_D, by its name."""
        raise NotImplementedError

    @property
    def inputs(self) -> dict[str, Quantity]:
        """Sizes and moduli that a wear coefficient depends on, by their keys under ``[contact]``."""
        raise NotImplementedError

    @property
    def unworn_radii(self) -> tuple[float, float]:
        """Radii of the gap before the test across the motion and along it, m."""
        raise NotImplementedError

    @property
    def flat_end(self) -> float:
        """Radius of the flat that the bodies touch on before the test, m; 0 where both are rounded."""
        return 0.0

    @property
    def round_surfaces(self) -> dict[str, Quantity]:
        """Radius of the unworn surface that a profile leads across, m, by the role of the body; none of flat ones."""
        return {}

    @property
    def worn_radius(self) -> tuple[str, Quantity]:
        """What the radius that is worn flat is called, and the radius, m."""
        raise NotImplementedError

    @property
    def limits(self) -> tuple[str, ...]:
        """Assumptions on the contact that results have to state, and where they do not hold well."""
        return ()

    def refuse_conditions(self, conditions: Any, /) -> None:
        """Raise ``ValueError`` for conditions of run.toml under which the bodies do not wear each other."""

    def refuse_wear(self, where: str, measured: Any, /) -> None:
        """Raise ``ValueError`` for post-test measurements, which stand at a key, of more wear than the bodies have."""

    @classmethod
    def completed(cls, document: Mapping[str, Any]) -> Mapping[str, Any]:
        """Return a run.toml with the names of this contact put as those that all contacts of its family share."""
        return document

    @classmethod
    def stated(cls, document: dict[str, Any]) -> dict[str, Any]:
        """Return a run.toml as it was before it was ``completed``, so that it can be read again, changed or not."""
        return document

    @classmethod
    def worded(cls, text: str) -> str:
        """Return a text with the body names of this contact in place of those of its family."""
        return text

    @classmethod
    def kinds(cls) -> "tuple[type[Record], ...]":
        """Return the kinds that are installed, where the class itself is none."""
        kinds = tuple(kind for kind in contacts().values() if issubclass(kind, cls))
        return kinds if cls in (Contact, SlidingPin) else (cls,)


_OF_A_DISC = (
    re.compile(
        r"(?<![A-Za-z_])disc"
        r"([_ ](?:wear[_ ]depth|wear[_ ]volume|track[_ ]width|mass[_ ]loss|profile|modulus|end[_ ]value)\b)"
    ),
    re.compile(r"(?:(?<=^)|(?<=; )|(?<=, ))disc(?=$|:)|(?<=\b[Tt]he )disc\b(?![._])"),
)
"""Keys of a disc and names of what belongs to it, and the disc itself where a text speaks of it."""


class SlidingPin(Contact):
    """A pin or ball that stays in contact while a track of the counterbody passes it; the depth sensor reads its wear.

    A subclass adds the field of its counterbody and names it in ``body_names``. Within tribopipe the counterbody has
    the names of a disc; run.toml and messages have those of the contact.
    """

    pin: Pin
    """The pin."""

    progress: ClassVar[Progress] = SLIDING
    body_names: ClassVar[tuple[str, ...]] = ("pin", "disc")
    roles: ClassVar[tuple[str, ...]] = ("pin", "disc")
    fitted_bodies: ClassVar[tuple[str, ...]] = ("pin",)
    shown: ClassVar[tuple[str, ...]] = ("wear_depth", "mean_pressure")
    sensor_tells: ClassVar[bool] = True

    @property
    def counterbody(self) -> Specimen:
        """The body that the pin rubs on."""
        return self.bodies[self.counterbody_name()]

    @classmethod
    def counterbody_name(cls) -> str:
        """Return what the counterbody is called: "disc"."""
        return cls.body_names[1]

    @property
    def equivalent_pin(self) -> Pin:
        """The pin that touches and wears on a flat counterbody as this one does on its own."""
        return self.pin

    @property
    def inputs(self) -> dict[str, Quantity]:
        """Radius of the pin, and the moduli, by their keys."""
        moduli = {f"{name}.youngs_modulus": body.youngs_modulus for name, body in self.bodies.items()}
        return {"pin.radius": self.pin.radius, **moduli}

    @property
    def unworn_radii(self) -> tuple[float, float]:
        """Radii of the gap before the test across the motion and along it, m."""
        return (self.equivalent_pin.radius.value,) * 2

    @property
    def flat_end(self) -> float:
        """Radius of the flat end of the pin before the test, m; 0 of a whole sphere."""
        flat = self.pin.radius if self.pin.shape == "flat" else self.pin.flat_radius
        return 0.0 if flat is None else flat.value

    @property
    def round_surfaces(self) -> dict[str, Quantity]:
        """Radius of the tip, m; none of a flat pin."""
        return {} if self.pin.shape == "flat" else {"pin": self.pin.radius}

    @property
    def worn_radius(self) -> tuple[str, Quantity]:
        """Return the name of the radius that is worn flat, and the radius, m."""
        return "pin radius", self.pin.radius

    def refuse_wear(self, where: str, measured: Any) -> None:
        """Raise ``ValueError`` for a scar or a depth that is no less than the tip."""
        for name in ("pin_scar_diameter", "pin_scar_length", "pin_scar_width"):
            scar = getattr(measured, name)
            if scar is not None:
                self._refuse_scar(f"{where}.{name}", scar)
        depth, radius = measured.pin_wear_depth, self.pin.radius
        if depth is not None and self.pin.shape != "flat" and depth.value >= radius.value:
            raise ValueError(
                f"{where}.pin_wear_depth: found {depth.shown('um')}, no less than the pin "
                f"radius of {radius.shown('um')}; expected a depth within the tip; check both units"
            )

    def _refuse_scar(self, key: str, scar: Quantity) -> None:
        if self.pin.shape == "flat":
            raise ValueError(
                f"{key}: found one for a flat pin, whose contact does not grow; give pin_wear_depth instead"
            )
        diameter = 2 * self.pin.radius.value
        if scar.value >= diameter:
            raise ValueError(
                f"{key}: found {scar.shown('um')}, no smaller than the pin's diameter of "
                f"{show(diameter, None, 'm', 'um')}; expected a scar on the tip; check both units"
            )

    def with_bodies(self, pin: Pin, counterbody: Specimen) -> Self:
        """Return a copy of the contact with other bodies."""
        return self.model_copy(update={"pin": pin, self.counterbody_name(): counterbody})

    @property
    def alike(self) -> dict[str, object]:
        """What else than the materials runs must have in common for one k_D, by its name."""
        return {"pin shape": self.pin.shape, "pin radius in m": self.pin.radius.value}

    @classmethod
    def completed(cls, document: Mapping[str, Any]) -> Mapping[str, Any]:
        """Return a run.toml with its post-test measurements of the counterbody under the names of a disc's.

        Raises ``ValueError`` where one of them is given by both names.
        """
        ends = document.get("end_values")
        stops = document.get("interruptions")
        named = dict(document)
        if isinstance(ends, Mapping):
            named["end_values"] = cls._of_a_disc("end_values", ends)
        if isinstance(stops, list | tuple):
            named["interruptions"] = [
                cls._of_a_disc(f"interruptions[{number}]", stop) if isinstance(stop, Mapping) else stop
                for number, stop in enumerate(stops)
            ]
        return named

    @classmethod
    def stated(cls, document: dict[str, Any]) -> dict[str, Any]:
        """Return a run.toml with the contact's own names for post-test measurements of its counterbody."""
        if cls.counterbody_name() == "disc":
            return document
        stops = document.get("interruptions") or ()
        return document | {
            name: ends
            for name, ends in (
                ("end_values", cls._of_the_counterbody(document.get("end_values"))),
                ("interruptions", [cls._of_the_counterbody(stop) for stop in stops]),
            )
            if name in document
        }

    @classmethod
    def _of_the_counterbody(cls, ends: Any) -> Any:
        return {cls.worded(key): value for key, value in ends.items()} if isinstance(ends, Mapping) else ends

    @classmethod
    def _of_a_disc(cls, where: str, ends: Mapping[str, Any]) -> dict[str, Any]:
        own = f"{cls.counterbody_name()}_"
        names = {key: f"disc_{key.removeprefix(own)}" if str(key).startswith(own) else key for key in ends}
        names = {key: name if _OF_A_DISC[0].fullmatch(str(name)) else key for key, name in names.items()}
        twice = next((key for key, name in names.items() if key != name and name in ends), None)
        if twice is not None:
            raise ValueError(f"{where}.{twice}: found it twice, once by the name that it has on a disc; remove one")
        return {names[key]: value for key, value in ends.items()}

    @classmethod
    def worded(cls, text: str) -> str:
        """Return a text that speaks of a disc in the names of this contact."""
        own = cls.counterbody_name()
        if own == "disc":
            return text
        key, body = _OF_A_DISC
        return body.sub(own.replace("_", " "), key.sub(rf"{own}\1", text)).replace("contact.disc", f"contact.{own}")


class PinOnDisc(SlidingPin):
    """A pin pressed on a rotating disc."""

    kind: Literal["pin-on-disc"]
    """Type of tribometer."""
    disc: Specimen
    """The disc."""

    both: ClassVar[str] = "pin + disc"
    title: ClassVar[str] = "a pin on a disc"


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


class TwinDisc(Contact):
    """Two discs that roll on each other and slip."""

    kind: Literal["twin-disc"]
    """Type of tribometer."""
    curved_disc: CurvedDisc
    """The disc with a crown; rotations are counted on it."""
    flat_disc: FlatDisc
    """The flat disc."""

    progress: ClassVar[Progress] = ROTATIONS
    body_names: ClassVar[tuple[str, ...]] = ("curved_disc", "flat_disc")
    roles: ClassVar[tuple[str, ...]] = ("curved_disc", "flat_disc")
    fitted_bodies: ClassVar[tuple[str, ...]] = ("curved_disc", "flat_disc")
    shown: ClassVar[tuple[str, ...]] = ("wear_depth", "wear_volume")
    rolls: ClassVar[bool] = True
    both: ClassVar[str] = "both discs"
    body_words: ClassVar[Mapping[str, str]] = {"curved_disc": "crowned disc"}
    slid: ClassVar[str] = "slip distance"
    title: ClassVar[str] = "two discs that roll on each other and slip"

    @property
    def travel(self) -> float:
        """Distance, m, that the surface of the crowned disc goes in a rotation."""
        return 2 * math.pi * self.curved_disc.rolling_radius.value

    @property
    def inputs(self) -> dict[str, Quantity]:
        """Radii and moduli of the discs, by their keys."""
        radii = {f"{name}.rolling_radius": getattr(self, name).rolling_radius for name in self.body_names}
        moduli = {f"{name}.youngs_modulus": body.youngs_modulus for name, body in self.bodies.items()}
        return {"curved_disc.crown_radius": self.curved_disc.crown_radius, **radii, **moduli}

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

    @property
    def alike(self) -> dict[str, object]:
        """What else than the materials runs must have in common for one k_D, by its name."""
        return {
            "crown radius in m": self.curved_disc.crown_radius.value,
            "crowned disc's radius in m": self.curved_disc.rolling_radius.value,
            "flat disc's radius in m": self.flat_disc.rolling_radius.value,
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
                "conditions.slip: found it together with flat_disc_speed, which is equivalent; expected one of the "
                "two; remove the other"
            )
        equal = slip is None and curved is not None and flat is not None and curved.value == flat.value
        if equal or (slip is not None and slip.value == 0):
            raise ValueError(
                "conditions.slip: found none, both discs at the same speed; expected slip, since discs that only roll "
                "do not wear by sliding; check both speeds"
            )
        if slip is not None and slip.value <= -1:
            raise ValueError(
                f"conditions.slip: found {slip.shown('%')}; expected more than -100 %, at which the flat disc would "
                "stand still; write (v2 - v1)/v1"
            )

    def refuse_wear(self, where: str, measured: Any) -> None:
        """Raise ``ValueError`` for a depth or a track beyond the crown, or a track wider than its disc."""
        crown = self.curved_disc.crown_radius
        for name, disc in (("curved_disc", self.curved_disc), ("flat_disc", self.flat_disc)):
            depth, width = getattr(measured, f"{name}_wear_depth"), getattr(measured, f"{name}_track_width")
            if depth is not None and depth.value >= crown.value:
                raise ValueError(
                    f"{where}.{name}_wear_depth: found {depth.shown('um')}, no less than the crown radius of "
                    f"{crown.shown('mm')}; expected wear within the crown; check both units"
                )
            if width is not None and width.value >= 2 * crown.value:
                raise ValueError(
                    f"{where}.{name}_track_width: found {width.shown('mm')}, no less than twice the crown radius of "
                    f"{crown.shown('mm')}; expected a track on the crown; check both units"
                )
            if width is not None and disc.width is not None and width.value > disc.width.value:
                raise ValueError(
                    f"{where}.{name}_track_width: found {width.shown('mm')} on a disc {disc.width.shown('mm')} wide; "
                    "expected a track within the disc; check both units"
                )


DiscName = Literal["curved_disc", "flat_disc"]
DISCS: tuple[DiscName, DiscName] = ("curved_disc", "flat_disc")
"""In the order of k₁ and k₂."""
GROUP = "tribopipe.contacts"
_SHIPPED: tuple[type[Contact], ...] = (PinOnDisc, TwinDisc)


def family_of(contact: "Contact", answers: Mapping[type["Contact"], Answer]) -> Answer:
    """Return the answer for the family of a contact."""
    return next(answers[family] for family in type(contact).__mro__ if family in answers)


def kind_of(contact: type[Contact]) -> str:
    """Return the kind that run.toml names a class by."""
    return str(get_args(contact.model_fields["kind"].annotation)[0])


SHIPPED: dict[str, type[Contact]] = {kind_of(contact): contact for contact in _SHIPPED}
"""tribopipe's own kinds of contact by their names in run.toml."""


def _load(entry: EntryPoint) -> type[Contact]:
    contact = entry.load()
    if not (isinstance(contact, type) and issubclass(contact, SlidingPin)):
        raise TypeError(f"found {contact!r}; expected a subclass of SlidingPin")
    kinds = get_args(contact.model_fields["kind"].annotation)
    if kinds != (entry.name,):
        raise TypeError(f"found the kind {contact.model_fields['kind'].annotation}; expected Literal['{entry.name}']")
    if entry.name in SHIPPED:
        raise ValueError("the name is used by tribopipe itself")
    bodies = [
        contact.model_fields[name].annotation if name in contact.model_fields else None for name in contact.body_names
    ]
    if (
        len(bodies) != 2
        or contact.body_names[0] != "pin"
        or not all(isinstance(body, type) and issubclass(body, Specimen) for body in bodies)
    ):
        raise TypeError(f"found the bodies {contact.body_names}; expected the pin and the field of a specimen")
    return contact


ADDED: Plugins[type[Contact]] = Plugins(GROUP, "contact", _load, kind_of)
"""Kinds that other packages add."""


def contacts() -> dict[str, type[Contact]]:
    """Return each kind of contact by its name in run.toml, tribopipe's own first."""
    return SHIPPED | dict(ADDED)


def contact_named(kind: object) -> type[Contact] | None:
    """Return the class of a kind; none of a kind that is not installed."""
    if not isinstance(kind, str):
        return None
    return SHIPPED.get(kind) or ADDED.get(kind)


def spoken(name: str) -> str:
    """Write a key as words: "crowned disc" for ``curved_disc``."""
    for kind in contacts().values():
        for body, words in kind.body_words.items():
            name = name.replace(body, words)
    return name.replace("_", " ")


class _OfItsKind:
    """Has a contact read as the class of its kind, and written with all its fields."""

    def __init__(self, *shipped: type[Contact]) -> None:
        self._shipped = shipped

    def __get_pydantic_core_schema__(self, source: type[Contact], handler: GetCoreSchemaHandler) -> CoreSchema:
        """Return the schema of tribopipe's kinds, which reports what is missing in a document without a kind."""
        union: Any = self._shipped[0]
        for kind in self._shipped[1:]:
            union |= kind
        tagged = Annotated[union, Field(discriminator="kind")] if len(self._shipped) > 1 else union

        def read(written: Any, own: ValidatorFunctionWrapHandler, info: ValidationInfo) -> Contact:
            kind = written.get("kind") if isinstance(written, Mapping) else None
            if isinstance(written, source):
                return written
            if isinstance(kind, str):
                return _of_family(source, kind).model_validate(written, context=info.context)
            return cast("Contact", own(written))

        anything = core_schema.simple_ser_schema("any")
        return core_schema.with_info_wrap_validator_function(
            read, handler.generate_schema(tagged), serialization=anything
        )


def _of_family(family: type[Contact], kind: str) -> type[Contact]:
    """Return the class of a kind. Raises ``ValueError`` where none of the family is installed by that name."""
    contact = contact_named(kind)
    if contact is None or not issubclass(contact, family):
        known = [name for name, other in contacts().items() if issubclass(other, family)]
        raise PydanticCustomError(
            "union_tag_invalid", "", {"discriminator": "'kind'", "expected_tags": ", ".join(map(repr, known))}
        )
    return contact


AnyContact = Annotated[Contact, _OfItsKind(PinOnDisc, TwinDisc)]
"""A contact of any installed kind."""
AnySlidingPin = Annotated[SlidingPin, _OfItsKind(PinOnDisc)]
"""A pin on a counterbody, of any installed kind."""
