"""The two bodies of a contact as they went into the test, and what wear grows along.

Each kind of tribometer is a class in a module of its own (tribopipe.documents.contact_kinds lists them).
"""

import re
from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, NamedTuple, Self, cast, get_args

from numpy.typing import ArrayLike
from pydantic import AfterValidator, Field, model_validator

from tribopipe.base.arrays import Column
from tribopipe.base.errors import ContactError
from tribopipe.base.units import show
from tribopipe.documents.quantity import Density, Length, Pressure, Quantity, Ratio, Toughness, scaled
from tribopipe.documents.record import Record
from tribopipe.documents.signals import SignalName
from tribopipe.physics.hertz import contact_modulus


class Progress(NamedTuple):
    """Quantity that wear increases with on a tribometer: the axis of its curves, and the length of a test."""

    signal: SignalName
    """Name of the signal; the planned end in ``conditions`` has the same name."""
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
        """Name in a sentence."""
        return self.signal.replace("_", " ")

    def shown(self, value: float) -> str:
        """Write a place for people: "50 m", "1,000 rotations"."""
        return f"{value:,.0f} {self.unit}" if self.kind == "count" else f"{value:.6g} {self.unit}"


SLIDING = Progress("sliding_distance", "distance", "m", "sliding_speed", "500 m")
ROTATIONS = Progress("rotations", "count", "rotations", "curved_disc_speed", "1e6")


def _physical_poisson_ratio(ratio: Quantity) -> Quantity:
    if not -1 < ratio.value <= 0.5:
        raise ValueError(f"found {ratio.value:g}; expected a Poisson ratio greater than -1 and at most 0.5")
    return ratio


class Specimen(Record):
    """One of the two bodies: material and surface before the test."""

    material: str = Field(min_length=1)
    """Material, under the name used in the lab, such as "Si3N4"."""
    youngs_modulus: Pressure
    """Young's modulus E (Eq. 3)."""
    poisson_ratio: Annotated[Ratio, AfterValidator(_physical_poisson_ratio)]
    """Poisson ratio ν (Eq. 3)."""
    density: Density | None = None
    """Density; required for post-test measurements of mass."""
    surface_roughness: Length | None = None
    """Arithmetic mean roughness Ra before the test."""
    vickers_hardness: float | None = Field(default=None, gt=0)
    """Vickers hardness HV, without a unit."""
    fracture_toughness: Toughness | None = None
    """Fracture toughness K_Ic."""
    diameter: Length | None = None
    """Outer diameter of the specimen."""
    coating_thickness: Length | None = None
    """Thickness of the coating, if any; if it is worn through, k_D applies to coating and substrate together."""

    size_keys: ClassVar[tuple[str, ...] | None] = None
    """Keys of the dimensions that reports state, the main one last; None for all that it has of its own."""

    @classmethod
    def sizes(cls) -> tuple[str, ...]:
        """Return the keys of the dimensions that reports state, except the diameter."""
        own = tuple(name for name in cls.model_fields if name not in Specimen.model_fields)
        return own if cls.size_keys is None else cls.size_keys


Shape = Literal["spherical", "flat", "truncated-sphere", "block"]


class Tip(Specimen):
    """The end of a body that stays in contact, against a flat that passes it."""

    shape: Shape
    """How the gap to the flat widens: not over a flat end, along the sliding alone over a block on a ring."""
    radius: Length
    """Radius of the gap, or of a flat end."""
    flat_radius: Length | None = None
    """Radius of the flat that a sphere begins with."""

    @property
    def line(self) -> float:
        """Length of a line contact across the sliding, m; 0 of any other."""
        return 0.0

    @property
    def flat(self) -> float:
        """Radius of the flat of a truncated sphere before the test, m; 0 for other tips."""
        return 0.0 if self.flat_radius is None else self.flat_radius.value

    @property
    def widens(self) -> bool:
        """Whether wear makes the contact wider across the sliding, so that a groove shapes it."""
        return self.shape in ("spherical", "truncated-sphere")

    @property
    def constant_area(self) -> bool:
        """Whether the contact area stays the same as the tip wears: a flat end."""
        return self.shape == "flat"

    @property
    def depth_exponent(self) -> float:
        """Exponent n of depth ∝ sⁿ under Archard's law: about ½ for a sphere, truncated or not."""
        return 1.0 if self.constant_area else 0.5

    @property
    def usual_measurement(self) -> str:
        """Key of the post-test measurement that gives its wear volume most easily."""
        return "pin_wear_depth" if self.constant_area else "pin_scar_diameter"

    @property
    def how_to_measure(self) -> str:
        """Remedy where its wear was not measured."""
        what = "wear depth" if self.constant_area else "scar"
        return f"measure the {what} and state it as end_values.{self.usual_measurement}"


class Pin(Tip):
    """The pin or ball that slides on the disc."""

    shape: Literal["spherical", "flat", "truncated-sphere"]
    """Spherical tip, flat end of constant area, or sphere with a flat that was ground or worn before the test."""
    radius: Length
    """Radius R_P of a spherical tip, truncated or not; radius of the flat end of a flat pin."""
    flat_radius: Length | None = None
    """Radius of the flat on a truncated sphere before the test."""

    size_keys: ClassVar[tuple[str, ...] | None] = ("radius",)

    @model_validator(mode="after")
    def _flat_belongs_to_a_truncated_sphere(self) -> Self:
        if (self.flat_radius is None) == (self.shape == "truncated-sphere"):
            found = "none" if self.flat_radius is None else self.flat_radius.shown("um")
            raise ValueError(
                f"flat_radius: found {found} for a {self.shape} pin; expected flat_radius for truncated-sphere pins, "
                "and only for them; correct shape or flat_radius"
            )
        if self.flat_radius is not None and self.flat_radius.value >= self.radius.value:
            raise ValueError(
                f"flat_radius: found {self.flat_radius.shown('um')}, not less than the sphere radius of "
                f"{self.radius.shown('um')}; expected a smaller flat; check the units of both values"
            )
        return self


ModulusInput = Literal["pin_modulus", "disc_modulus", "curved_modulus", "flat_modulus"]


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
    """Bodies whose k_D is determined; the first one is determined in every fit."""
    shown: ClassVar[tuple[str, ...]]
    """Quantities of the predicted wear that tables show."""
    test: ClassVar[str]
    """What a test of this family is called in a message: "run with a sliding pin"."""
    study_word: ClassVar[str] = ""
    """What the IDs of drafted studies call a test of this family, if anything."""
    tribodatafair: ClassVar[str | None] = None
    """Identifier of this type of tribometer in TriboDataFAIR, if it has one."""
    both: ClassVar[str]
    """Both bodies in words."""
    body_words: ClassVar[Mapping[str, str]] = {}
    """Names for readers of bodies whose name in run.toml is different."""
    slid: ClassVar[str] = "sliding distance"
    """Name of the relative sliding distance of the bodies."""
    load_share: ClassVar[float] = 1.0
    """Load on one contact over the load that is applied."""
    track_key: ClassVar[str | None] = None
    """Key of run.toml that determines the track radius; None if the conditions state it, or there is no track."""
    modulus_inputs: ClassVar[tuple[ModulusInput, ...]]
    """Names of the inputs that are the Young's moduli of the bodies."""
    family_conditions: ClassVar[tuple[str, ...]]
    """Keys of conditions that make sense for this family alone."""
    own_conditions: ClassVar[tuple[str, ...]] = ()
    """Keys of conditions that make sense for this kind alone."""
    needed_conditions: ClassVar[tuple[str, ...]] = ()
    """Keys of conditions that this kind needs in addition to the load."""
    replaced_conditions: ClassVar[Mapping[str, str]] = {}
    """Keys of conditions that this kind needs unless another is stated, and that other one."""
    like: ClassVar[Mapping[str, str]] = {}
    """Bodies that may be left out of run.toml, and the body that each is like then."""
    standard: ClassVar[str] = "g99"
    """Standard test method that reports name by default."""
    usual_diameters: ClassVar[tuple[float, ...]] = ()
    """Diameters, mm, of the body described by ``track_key`` in most tests."""
    contacts_per_turn: ClassVar[int] = 1
    """Contacts that a place of the second body's track meets in one turn."""
    depth_share: ClassVar[float] = 1.0
    """Approach of the two bodies over the displacement that a sensor reads."""
    tip_role: ClassVar[str | None] = None
    """Role of the body that stays in contact while a track of the other one passes it; None if both pass."""
    material_transfer: ClassVar[bool] = False
    """Whether a body may gain material from the other one, so that its volume or mass grows."""
    sensor_tells: ClassVar[bool] = False
    """Whether the depth reading of a test gives the wear without a measurement after it."""
    title: ClassVar[str]
    """Name of the test in a sentence: "a pin on a disc"."""

    @classmethod
    def of(cls, contact: "Contact", run_id: str) -> Self:
        """Return a contact of this family. Raises ``ContactError`` for a run on another tribometer."""
        if isinstance(contact, cls):
            return contact
        raise ContactError(f"{run_id}: found a {contact.kind} run; expected a {cls.test}; specify another run")

    @property
    def tip(self) -> "Tip | None":
        """The end of the body that stays in contact; None if both bodies pass."""
        return None

    @property
    def sliding_tip(self) -> "Tip":
        """The end of the body that stays in contact. Raises ``ContactError`` where both bodies pass."""
        if self.tip is None:
            raise ContactError(f"found a {self.test}; expected a body that stays in contact; specify another run")
        return self.tip

    @property
    def equivalent_pin(self) -> "Tip":
        """The tip that touches and wears on a flat counterbody as this one does on its own."""
        return self.sliding_tip

    @classmethod
    def counterbody_name(cls) -> str:
        """Return what the second body is called: "disc"."""
        return cls.body_names[1]

    @property
    def counterbody(self) -> Specimen:
        """The second body, which a pin rubs on."""
        return self.bodies[self.counterbody_name()]

    @property
    def disc_of_track(self) -> Specimen | None:
        """The disc on whose face the track lies, which limits its radius; None if there is none."""
        return None

    @property
    def travel(self) -> float:
        """Distance, m, at the nominal speed in one unit of the progress."""
        return 1.0

    @property
    def bodies(self) -> dict[str, Specimen]:
        """The two bodies by name."""
        return {name: getattr(self, name) for name in self.body_names}

    @classmethod
    def specimen(cls, name: str) -> type[Specimen]:
        """Return the record of a body."""
        return cast(type[Specimen], cls.model_fields[name].annotation)

    @classmethod
    def body_name(cls, role: str) -> str:
        """Return the name of the body in a role."""
        return dict(zip(cls.roles, cls.body_names, strict=True))[role]

    def slip(self, conditions: Any, default: float = 0.0) -> Quantity | None:  # noqa: ARG002
        """Return the slip of bodies that roll on each other; None for others."""
        return None

    def slip_per_rotation(self, conditions: Any) -> float:
        """Return the slip distance of unworn bodies that roll, in one unit of the progress, m."""
        slip = self.slip(conditions)
        return 0.0 if slip is None else self.travel * abs(slip.value)

    @property
    def rolling_radii(self) -> tuple[Quantity, ...]:
        """Radii of the bodies along the direction in which both roll, m; empty where one stays in contact."""
        return ()

    def friction_arm(self, track_radius: float | None, /) -> float | None:
        """Return friction torque over friction force, as it belongs to the load that is applied, m."""
        return track_radius

    def pressed_by(self, applied: Quantity) -> Quantity:
        """Return the normal load on one contact under a load as it is applied, N."""
        return scaled(applied, self.load_share)

    def contacts_of(self, role: str) -> int:
        """Return in how many contacts the body in a role wears."""
        return self.contacts_per_turn if role == self.roles[1] else 1

    @property
    def own_track_radius(self) -> Quantity | None:
        """Track radius that the bodies determine, m; None if the conditions state it."""
        return None

    @property
    def in_roles(self) -> dict[str, Specimen]:
        """The two bodies by role."""
        return dict(zip(self.roles, self.bodies.values(), strict=True))

    @property
    def alike(self) -> dict[str, object]:
        """What else than the materials runs must have in common for one k_D, by its name."""
        raise NotImplementedError

    @property
    def moduli(self) -> dict[str, Quantity]:
        """Young's moduli of the bodies, by their keys under ``[contact]``."""
        return {f"{name}.youngs_modulus": body.youngs_modulus for name, body in self.bodies.items()}

    def reduced_modulus(self, first: ArrayLike | None = None, second: ArrayLike | None = None) -> Column:
        """Return E_c of 1/E_c = (1 − ν₁²)/E₁ + (1 − ν₂²)/E₂, Pa.

        Parameters
        ----------
        first, second
            Young's moduli of the bodies, Pa, in the order of ``body_names``; left out, as stated in run.toml.
        """
        one, other = self.bodies.values()
        return contact_modulus(
            pin_modulus=one.youngs_modulus.value if first is None else first,
            pin_ratio=one.poisson_ratio.value,
            disc_modulus=other.youngs_modulus.value if second is None else second,
            disc_ratio=other.poisson_ratio.value,
        )

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
        """Radius of the unworn surface that a profile leads across, m, by the role of the body; empty if flat."""
        return {}

    @property
    def worn_radius(self) -> tuple[str, Quantity]:
        """What the radius that is worn flat is called, and the radius, m."""
        raise NotImplementedError

    def resized(self, radius: Quantity, /) -> Self:
        """Return a copy of the contact with another radius in the place of ``worn_radius``, m."""
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
        """Return the class itself if run.toml can name it, otherwise the kinds of its family that are loaded."""
        if get_args(cls.model_fields["kind"].annotation):
            return (cls,)
        return tuple(kind for family in cls.__subclasses__() for kind in family.kinds())


_MEASURED = (
    r"([_ ](?:wear[_ ]depth|wear[_ ]volume|track[_ ](?:width|area)|scar[_ ](?:diameter|length|width)|mass[_ ]loss"
    r"|profile|modulus|radius|end[_ ]value)\b)"
)


class _Called(NamedTuple):
    """Pattern of the places in a text where a body has the name of its role."""

    key: re.Pattern[str]
    """Keys of what belongs to it."""
    body: re.Pattern[str]
    table: re.Pattern[str]
    """Name of its table in run.toml."""

    @classmethod
    def by(cls, role: str) -> Self:
        """Return where a text calls a body by its role."""
        alone = rf"(?:(?<=^)|(?<=; )|(?<=, )){role}(?=$|:)|(?<=\b[Tt]he ){role}\b(?![._])"
        key = rf"(?<![A-Za-z_]){role}{_MEASURED}"
        return cls(re.compile(key), re.compile(alone), re.compile(rf"contact\.{role}\b"))

    def put(self, text: str, own: str) -> str:
        """Return a text with the body's own name."""
        words = own.replace("_", " ")
        text = self.key.sub(lambda found: (words if found[1].startswith(" ") else own) + found[1], text)
        return self.table.sub(f"contact.{own}", self.body.sub(words, text))


_CALLED = {role: _Called.by(role) for role in ("pin", "disc")}


class SlidingPin(Contact):
    """A pin or ball that stays in contact while a track of the counterbody passes it; the depth sensor reads its wear.

    A subclass adds the fields of its bodies and names them in ``body_names``, the one that stays in contact first.
    Within tribopipe they have the names of a pin and a disc; run.toml and messages have those of the contact.
    """

    if TYPE_CHECKING:

        @property
        def pin(self) -> Tip:
            """The pin, or as which tip the body that stays in contact is taken: a field or a property."""

    progress: ClassVar[Progress] = SLIDING
    body_names: ClassVar[tuple[str, ...]] = ("pin", "disc")
    roles: ClassVar[tuple[str, ...]] = ("pin", "disc")
    tip_role: ClassVar[str | None] = "pin"
    test: ClassVar[str] = "run with a sliding pin"
    fitted_bodies: ClassVar[tuple[str, ...]] = ("pin",)
    modulus_inputs: ClassVar[tuple[ModulusInput, ...]] = ("pin_modulus", "disc_modulus")
    family_conditions: ClassVar[tuple[str, ...]] = (
        *("sliding_speed", "sliding_distance", "track_radius", "rotational_speed", "stroke", "frequency"),
    )
    material_transfer: ClassVar[bool] = True
    shown: ClassVar[tuple[str, ...]] = ("wear_depth", "mean_pressure")
    sensor_tells: ClassVar[bool] = True
    equivalent_words: ClassVar[str] = "pin"
    """Name of ``equivalent_pin``."""

    @property
    def tip(self) -> Tip:
        """The end of the body that stays in contact."""
        return self.pin

    @property
    def disc_of_track(self) -> Specimen | None:
        """The counterbody, unless its size determines the track radius."""
        return self.counterbody if self.track_key is None else None

    @property
    def inputs(self) -> dict[str, Quantity]:
        """Radius of the pin, and the moduli, by their keys."""
        return {"pin.radius": self.pin.radius, **self.moduli}

    @property
    def unworn_radii(self) -> tuple[float, float]:
        """Radii of the gap before the test across the motion and along it, m."""
        return (self.equivalent_pin.radius.value,) * 2

    @property
    def flat_end(self) -> float:
        """Radius of the flat end of the pin before the test, m; 0 for a full sphere."""
        flat = self.pin.radius if self.pin.constant_area else self.pin.flat_radius
        return 0.0 if flat is None else flat.value

    @property
    def round_surfaces(self) -> dict[str, Quantity]:
        """Radius of the tip, m, by the role of the pin; empty for a flat pin."""
        return {"pin": self.pin.radius} if self.pin.widens else {}

    @property
    def worn_radius(self) -> tuple[str, Quantity]:
        """Return the name of the radius that is worn flat, and the radius, m."""
        return "pin radius", self.pin.radius

    def resized(self, radius: Quantity) -> Self:
        """Return a copy of the contact with another radius of the pin, m."""
        return self.with_bodies(self.pin.model_copy(update={"radius": radius}), self.counterbody)

    def refuse_wear(self, where: str, measured: Any) -> None:
        """Raise ``ValueError`` for a scar or a depth that is no less than the tip."""
        for name in ("pin_scar_diameter", "pin_scar_length", "pin_scar_width"):
            scar = getattr(measured, name)
            if scar is not None:
                self._refuse_scar(f"{where}.{name}", scar)
        if self.pin.constant_area:
            return
        gained, radius = measured.pin_wear_depth, self.equivalent_pin.radius
        if gained is not None and gained.value < 0:
            raise ValueError(
                f"{where}.pin_wear_depth: found {gained.shown('um')}; expected zero or more, since the depth of a gain "
                "does not determine its volume on a tip whose contact area changes; enter a gain of material as a "
                "negative pin_wear_volume or pin_mass_loss"
            )
        for name in ("pin_wear_depth", "disc_wear_depth"):
            depth = getattr(measured, name)
            if depth is not None and depth.value >= radius.value:
                raise ValueError(
                    f"{where}.{name}: found {depth.shown('um')}, not less than the {self.equivalent_words} radius of "
                    f"{radius.shown('um')}; expected a smaller wear depth; check the units of both values"
                )

    def _refuse_scar(self, key: str, scar: Quantity) -> None:
        if self.pin.constant_area:
            raise ValueError(
                f"{key}: found a scar size for a flat pin, whose contact area is constant; expected pin_wear_depth; "
                "specify the wear depth instead"
            )
        diameter = 2 * self.equivalent_pin.radius.value
        if scar.value >= diameter:
            raise ValueError(
                f"{key}: found {scar.shown('um')}, not less than the {self.equivalent_words} diameter of "
                f"{show(diameter, None, 'm', 'um')}; expected a smaller scar; check the units of both values"
            )

    def with_bodies(self, pin: Tip, counterbody: Specimen) -> Self:
        """Return a copy of the contact with other bodies."""
        return self.model_copy(update={"pin": pin, self.counterbody_name(): counterbody})

    @property
    def alike(self) -> dict[str, object]:
        """What else than the materials runs must have in common for one k_D, by its name."""
        return {"pin shape": self.pin.shape, "pin radius in m": self.pin.radius.value}

    @classmethod
    def completed(cls, document: Mapping[str, Any]) -> Mapping[str, Any]:
        """Return a run.toml with its post-test measurements of both bodies under the names of a pin's and a disc's.

        Adds the track radius if the bodies determine it. Raises ``ValueError`` where a measurement is given by two
        names, or that track radius is stated as well.
        """
        ends = document.get("end_values")
        stops = document.get("interruptions")
        named = dict(document)
        if isinstance(ends, Mapping):
            named["end_values"] = cls._in_roles("end_values", ends)
        if isinstance(stops, list | tuple):
            named["interruptions"] = [
                cls._in_roles(f"interruptions[{number}]", stop) if isinstance(stop, Mapping) else stop
                for number, stop in enumerate(stops)
            ]
        contact, conditions = document.get("contact"), document.get("conditions")
        if isinstance(contact, Mapping) and isinstance(conditions, Mapping):
            radius = cls.track_radius_of(contact)
            if radius is not None and "track_radius" in conditions:
                raise ValueError(
                    f"conditions.track_radius: found a track radius in addition to {cls.track_key}, from which it is "
                    f"computed; expected only {cls.track_key}; remove track_radius"
                )
            if radius is not None:
                named["conditions"] = {**conditions, "track_radius": radius}
        return named

    @classmethod
    def track_radius_of(cls, contact: Mapping[str, Any]) -> Any:  # noqa: ARG003
        """Return the track radius that ``[contact]`` determines, so that rotations become distances.

        Parameters
        ----------
        contact
            ``[contact]`` as it is written.

        Returns
        -------
        Any
            The radius as written in run.toml, or a quantity; None if the conditions state it.
        """
        return None

    @classmethod
    def stated(cls, document: dict[str, Any]) -> dict[str, Any]:
        """Return a run.toml as written: own names of the bodies, and no track radius that they determine."""
        if cls.track_key is not None:
            conditions = {name: value for name, value in document["conditions"].items() if name != "track_radius"}
            document = document | {"conditions": conditions}
        if not cls._names():
            return document
        stops = document.get("interruptions") or ()
        return document | {
            name: ends
            for name, ends in (
                ("end_values", cls._in_own_names(document.get("end_values"))),
                ("interruptions", [cls._in_own_names(stop) for stop in stops]),
            )
            if name in document
        }

    @classmethod
    def _names(cls) -> dict[str, str]:
        """Return the bodies' own names by those of their roles, where they are different."""
        return {role: own for role, own in zip(cls.roles, cls.body_names, strict=True) if role != own}

    @classmethod
    def _in_own_names(cls, ends: Any) -> Any:
        return {cls.worded(key): value for key, value in ends.items()} if isinstance(ends, Mapping) else ends

    @classmethod
    def _in_roles(cls, where: str, ends: Mapping[str, Any]) -> dict[str, Any]:
        names = {key: cls._role_key(str(key)) for key in ends}
        for key, name in names.items():
            other = next((one for one in names if one != key and names[one] == name), None)
            if other is not None:
                raise ValueError(
                    f"{where}.{key}: found this key in addition to {other}, which has the same meaning; expected "
                    "only one of the two; remove the other"
                )
        return {names[key]: value for key, value in ends.items()}

    @classmethod
    def _role_key(cls, key: str) -> str:
        ball = {"pin": "ball"} if "pin" in cls.model_fields else {}
        for role, own in (ball | cls._names()).items():
            name = f"{role}_{key.removeprefix(f'{own}_')}"
            if key.startswith(f"{own}_") and _CALLED[role].key.fullmatch(name):
                return name
        return key

    @classmethod
    def worded(cls, text: str) -> str:
        """Replace "pin" and "disc" in a text with the body names of this contact."""
        for role, own in cls._names().items():
            text = _CALLED[role].put(text, own)
        return text


class Ball(Specimen):
    """A ball."""

    diameter: Length
    """Diameter of the ball."""

    @model_validator(mode="before")
    @classmethod
    def _described_by_its_diameter(cls, ball: Any) -> Any:
        key = next((key for key in ("shape", "radius", "flat_radius") if isinstance(ball, Mapping) and key in ball), "")
        if key:
            # "[contact.pin]" would be worded in the names of this contact, which has a ball.
            halved = key == "radius" and "diameter" not in ball
            remedy = "enter twice the radius as diameter" if halved else f"remove {key}"
            raise ValueError(f"found {key}, a key that does not apply to a ball; expected diameter; {remedy}")
        return ball


def refuse_ball_and_pin(contact: Any) -> None:
    """Raise ``ValueError`` for a ball that is described together with a pin."""
    if isinstance(contact, Mapping) and "pin" in contact:
        raise ValueError("ball: found a ball in addition to a pin; expected only one of the two; remove the other")


class SlidingBall(SlidingPin):
    """A sliding pin that is a ball, described by its diameter."""

    ball: Ball
    """The ball."""

    body_names: ClassVar[tuple[str, ...]] = ("ball", "disc")
    fitted_bodies: ClassVar[tuple[str, ...]] = ("ball",)

    @model_validator(mode="before")
    @classmethod
    def _instead_of_a_pin(cls, contact: Any) -> Any:
        refuse_ball_and_pin(contact)
        return contact

    @classmethod
    def with_a_pin(cls, contact: Mapping[str, Any]) -> dict[str, Any]:
        """Return ``[contact]`` as it is written with the ball as a spherical pin of its diameter."""
        refuse_ball_and_pin(contact)
        others = {name: part for name, part in contact.items() if name != "ball"}
        return others | {"pin": {"shape": "spherical"} | contact["ball"]}

    @property
    def pin(self) -> Pin:
        """The ball as a pin."""
        stated = {name: getattr(self.ball, name) for name in Specimen.model_fields}
        return Pin(shape="spherical", radius=scaled(self.ball.diameter, 0.5), **stated)

    @property
    def inputs(self) -> dict[str, Quantity]:
        """Diameter of the ball, and the moduli, by their keys."""
        return {"ball.diameter": self.ball.diameter, **self.moduli}

    def with_bodies(self, pin: Tip, counterbody: Specimen) -> Self:
        """Return a copy of the contact with other bodies."""
        ball = {"diameter": scaled(pin.radius, 2.0), "youngs_modulus": pin.youngs_modulus}
        return self.model_copy(update={"ball": self.ball.model_copy(update=ball), self.counterbody_name(): counterbody})
