"""run.toml: what a lab writes with the instrument's own files about one run."""

import math
import re
from collections import Counter
from collections.abc import Collection, Mapping
from datetime import datetime
from itertools import pairwise
from pathlib import Path, PureWindowsPath
from typing import Annotated, Any, Literal, Self

from pydantic import (
    AfterValidator,
    BeforeValidator,
    ConfigDict,
    Field,
    SerializerFunctionWrapHandler,
    field_validator,
    model_serializer,
    model_validator,
)

from tribopipe.base.errors import ContactError, ManifestError, did_you_mean
from tribopipe.base.files import leads_out
from tribopipe.documents.contact import SLIDING, Contact, Progress, Specimen, Tip
from tribopipe.documents.contact_kinds import (
    ASSUMED,
    ROLES,
    ROLLING_ROLES,
    SHIPPED,
    AnyContact,
    contact_described,
    contact_named,
    contacts,
)
from tribopipe.documents.quantity import (
    Distance,
    EndValue,
    Force,
    Frequency,
    Length,
    MeasuredArea,
    MeasuredDepth,
    MeasuredLength,
    MeasuredMass,
    MeasuredVolume,
    Percentage,
    Quantity,
    Ratio,
    RotationalSpeed,
    Slip,
    Speed,
    Temperature,
    scaled,
)
from tribopipe.documents.record import Record, read_document
from tribopipe.documents.signals import SignalName
from tribopipe.documents.toml import parse_toml, read_bytes

MANIFEST_NAME = "run.toml"
MANIFEST_SCHEMA = "tribopipe.run/1"

_ID = re.compile(r"[A-Za-z0-9][A-Za-z0-9._+-]{0,99}")
_WINDOWS_DEVICES = {"con", "prn", "aux", "nul", *(f"{port}{n}" for port in ("com", "lpt") for n in range(10))}


def _usable_as_file_name(identifier: str) -> str:
    if not _ID.fullmatch(identifier) or identifier.endswith("."):
        raise ValueError(
            f"found {identifier!r}; expected up to 100 letters, digits and . _ + -, starting with a "
            "letter or digit, since the archive file is named after the ID"
        )
    if identifier.split(".")[0].lower() in _WINDOWS_DEVICES:
        raise ValueError(f"found {identifier!r}, a device name on Windows; choose another ID")
    return identifier


RunId = Annotated[str, AfterValidator(_usable_as_file_name), Field(json_schema_extra={"pattern": f"^{_ID.pattern}$"})]


_MOST_ROTATIONS = 1e15
"""A year at a million rotations a second is a thirtieth of it, and float64 still resolves each rotation."""


def _a_count(written: Any) -> Any:
    number = isinstance(written, int | float) and not isinstance(written, bool)
    if not number or not math.isfinite(written) or written < 1 or written != math.floor(written):
        raise ValueError(
            f"found {written!r}; expected a whole number of rotations, at least 1, such as 1_000_000 or 1e6"
        )
    if written > _MOST_ROTATIONS:
        raise ValueError(f"found {written!r}; expected at most {_MOST_ROTATIONS:g} rotations; correct the number")
    return float(written)


Rotations = Annotated[float, BeforeValidator(_a_count), Field(json_schema_extra={"minimum": 1, "multipleOf": 1})]


class StatedFriction(Record):
    """Parameters of μ(s) = A·exp(−s/c) + b (Eq. 7), known beforehand."""

    amplitude: Ratio
    """A: friction coefficient at the start minus that in the steady state."""
    steady_state: Ratio
    """b."""
    running_in_distance: Distance
    """c."""


def _product(factor: float, one: Quantity, other: Quantity) -> Quantity:
    """Return a speed; uncertain by what is stated of both, and by nothing where nothing is stated."""
    value = factor * one.value * other.value
    shares = [part.u_or_zero / part.value for part in (one, other)]
    spread = value * math.hypot(*shares) if any(shares) else None
    return Quantity(value=value, unit="m/s", standard_uncertainty=spread)


class Conditions(Record):
    """How the test was run."""

    normal_load: Force
    """Nominal normal load F_N."""
    sliding_speed: Speed | None = None
    """Nominal sliding speed; required if only one of time and sliding distance was recorded."""
    sliding_distance: Distance | None = None
    """Planned sliding distance."""
    curved_disc_speed: Speed | None = None
    """Tangential speed v₁ of the crowned disc; required if only one of time and rotations was recorded."""
    flat_disc_speed: Speed | None = None
    """Tangential speed v₂ of the cylindrical disc; alternative to slip."""
    track_radius: Length | None = None
    """Radius of the wear track; used to convert rotations and rotational speed of the disc to distances and speeds."""
    rotational_speed: RotationalSpeed | None = None
    """Rotational speed of the disc under a pin; together with track_radius, an alternative to sliding_speed."""
    stroke: Length | None = None
    """Length of one stroke of a reciprocating pin."""
    frequency: Frequency | None = None
    """Reciprocating frequency, in cycles of two strokes; together with stroke, an alternative to sliding_speed."""
    weld_load: Force | None = None
    """Load at which the four balls weld, if known; a normal load at or above it is rejected."""
    slip: Slip | None = None
    """(v₂ − v₁)/v₁, such as "4 %" if the cylindrical disc is faster, or "-4 %" if it is slower."""
    rotations: Rotations | None = None
    """Planned rotations of the crowned disc."""
    medium: str | None = None
    """Environment or lubricant of the contact, such as "air" or "water"."""
    temperature: Temperature | None = None
    """Room temperature."""
    relative_humidity: Percentage | None = None
    """Relative humidity of the surrounding air."""
    friction: StatedFriction | None = None
    """Friction for predictions with a law that depends on it, if known in advance; fits use the measured friction."""

    @field_validator("relative_humidity")
    @classmethod
    def _humidity_is_at_most_100_percent(cls, humidity: Quantity | None) -> Quantity | None:
        if humidity is not None and humidity.value > 1:
            value = f"{humidity.value:g}"
            meant = f'write "{value} %", if that is meant' if 2 < humidity.value <= 100 else "correct the value"
            raise ValueError(f"found {value}, that is, {100 * humidity.value:g} %; expected at most 100 %; {meant}")
        return humidity

    @property
    def nominal_speed(self) -> Quantity | None:
        """Nominal sliding speed of a pin, m/s: stated, ω·R of the track, or 2·stroke·frequency; None if unknown."""
        return self.speed_of_motion if self.sliding_speed is None else self.sliding_speed

    @property
    def speed_of_motion(self) -> Quantity | None:
        """Sliding speed by the stated motion, m/s: ω·R of the track, or 2·stroke·frequency; None if unknown."""
        if self.rotational_speed is not None and self.track_radius is not None:
            return _product(1.0, self.rotational_speed, self.track_radius)
        if self.stroke is not None and self.frequency is not None:
            return _product(2.0, self.stroke, self.frequency)
        return None

    @property
    def cycle(self) -> float | None:
        """Sliding distance of one revolution or one reciprocating cycle, m; None if neither is known."""
        if self.track_radius is not None:
            return 2 * math.pi * self.track_radius.value
        return None if self.stroke is None else 2 * self.stroke.value

    @property
    def path(self) -> Quantity | None:
        """Sliding distance between two passages of a pin at one place of its track, m; None if it is unknown.

        It is once around the circle; a reciprocating pin passes twice per cycle, on average after one stroke.
        """
        return self.stroke if self.track_radius is None else scaled(self.track_radius, 2 * math.pi)

    @model_validator(mode="after")
    def _a_pin_slides_in_a_circle_or_there_and_back(self) -> Self:
        for one, other in (("stroke", "track_radius"), ("rotational_speed", "frequency")):
            if getattr(self, one) is not None and getattr(self, other) is not None:
                raise ValueError(
                    f"{one}: found {one} in addition to {other}; expected either circular sliding (track_radius, "
                    "rotational_speed) or reciprocating sliding (stroke, frequency); remove what does not apply"
                )
        return self


class ColumnSource(Record):
    """Column of a file that contains a signal."""

    column: str = Field(min_length=1)
    """Name of the column, as in the header of the file."""
    unit: str | None = None
    """Unit of the column; overrides the unit in the file; required if the file contains none."""


class SignalSource(ColumnSource):
    """Column of a file that contains a signal."""

    arm: Length | None = None
    """Lever arm of the load cell about the axis, such as "150 mm", for a friction_force that is not measured at the
    contact."""

    @field_validator("arm")
    @classmethod
    def _arm_is_exact(cls, arm: Quantity | None) -> Quantity | None:
        if arm is not None and arm.standard_uncertainty:
            raise ValueError(
                "found a standard uncertainty; expected a length alone, since recorded friction forces are treated as "
                "exact; remove the uncertainty"
            )
        return arm


def _column_by_name(written: Any) -> Any:
    return {"column": written} if isinstance(written, str) else written


Source = Annotated[ColumnSource, BeforeValidator(_column_by_name, json_schema_input_type=str | ColumnSource)]
"""A column by its name, or with its unit."""
Signal = Annotated[SignalSource, BeforeValidator(_column_by_name, json_schema_input_type=str | SignalSource)]
"""The same for a signal."""


def _inside_run_folder(name: str) -> str:
    # Windows' rules also see what other systems would take for a folder or a root.
    path = PureWindowsPath(name)
    if not name.isprintable() or path.anchor or ".." in path.parts:
        raise ValueError(
            f"found {name!r}; expected a file in the run folder, which must contain all files of the run; "
            "copy the file next to run.toml"
        )
    return name


FileName = Annotated[str, AfterValidator(_inside_run_folder), Field(min_length=1)]


def _named_or_described(reader: str) -> str:
    """Let a reader be described by a file of the run folder alone."""
    return _inside_run_folder(reader) if is_described(reader) else reader


def is_described(reader: str) -> bool:
    """Return whether a reader is named by the file that describes it."""
    return reader.lower().endswith(".toml")


class SignalFile(Record):
    """One file of the instrument and the meaning of its columns."""

    file: FileName | None = None
    """Name of the file, relative to run.toml."""
    files: tuple[FileName, ...] = ()
    """Consecutive files of one test, in order, instead of file: one per stroke or step."""
    reader: Annotated[str, AfterValidator(_named_or_described)] | None = None
    """Format, such as "delimited" or "ducom-winducom", or the file in the run folder that describes it, such as
    "our-rig.toml"; default: detected."""
    encoding: str | None = None
    """Text encoding, such as "cp1252" or "shift_jis"; default: detected."""
    separator: str | None = None
    """Column separator, such as ";", "\\t", or " " for whitespace; default: detected."""
    decimal: Literal[".", ","] | None = None
    """Decimal separator; default: detected."""
    sheet: str | None = Field(default=None, min_length=1)
    """Sheet of a workbook, if several contain test data."""
    steps: tuple[int, ...] = ()
    """Numbers of the steps to read, if a file contains several; default: all rows form one test."""
    step_column: str | None = Field(default=None, min_length=1)
    """Column with the step numbers, such as "Step"; default: recognized by its name."""
    columns: dict[SignalName, Signal] = Field(default_factory=dict)
    """Signals and their columns; default: recognized by the names of the columns."""

    @model_validator(mode="after")
    def _each_step_is_chosen_once(self) -> Self:
        twice = next((step for step, count in Counter(self.steps).items() if count > 1), None)
        if twice is not None:
            raise ValueError(f"steps: found step {twice} twice; expected each step once; remove one of the two")
        return self

    @model_validator(mode="after")
    def _only_friction_has_an_arm(self) -> Self:
        for name, source in self.columns.items():
            if source.arm is not None and name != "friction_force":
                raise ValueError(
                    f"columns.{name}: found a lever arm, {source.arm.shown('mm')}; expected one only for "
                    "friction_force; remove arm"
                )
        return self

    @model_validator(mode="after")
    def _names_one_file_or_several(self) -> Self:
        if (self.file is None) == (not self.files):
            raise ValueError(
                f"found {'neither file nor files' if self.file is None else 'both file and files'}; expected one of "
                'the two; write file = "test.csv", or files = ["test_1.csv", "test_2.csv"] for consecutive files'
            )
        return self

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the files, in the order of the test."""
        return self.files if self.file is None else (self.file,)


class ProfileSource(Record):
    """A profile measured across a wear track or a worn pin: height against position."""

    file: FileName
    """Name of the file, relative to run.toml."""
    reader: Annotated[str, AfterValidator(_named_or_described)] | None = None
    """Format, such as "dektak" or "points", or the file in the run folder that describes it, such as "our-rig.toml";
    default: detected."""
    position: Source | None = None
    """Column of the position across the track, if the format does not state it."""
    height: Source | None = None
    """Column of the height, positive out of the specimen, if the format does not state it."""
    before: FileName | None = None
    """Height map of the same place before the test, with the same columns; the wear volume is then determined from the
    difference of the two maps."""

    @model_validator(mode="after")
    def _before_is_another_file(self) -> Self:
        if self.before is not None and PureWindowsPath(self.before) == PureWindowsPath(self.file):
            raise ValueError(
                f"before: found {self.before!r}, which is also the file of the worn surface; expected the map measured "
                "before the test; correct the name"
            )
        return self


def _one_or_several(written: Any) -> Any:
    return (written,) if isinstance(written, Mapping | ProfileSource) else written


Profiles = Annotated[
    tuple[ProfileSource, ...],
    BeforeValidator(_one_or_several, json_schema_input_type=ProfileSource | tuple[ProfileSource, ...]),
]
"""One profile, or several at different places of a track."""


_MAY_GAIN = tuple(f"{role}_" for kind in SHIPPED.values() if kind.material_transfer for role in kind.roles)
"""How keys begin of bodies that may gain material from the other one."""


def _remedy(name: str) -> str:
    """Return what to do with a measurement below zero: a gain of material is stated as a volume or mass."""
    body = next((start for start in _MAY_GAIN if name.startswith(start)), None)
    if body is None:
        return "remove the sign"
    return f"remove the sign, or enter a gain of material as a negative {body}wear_volume or {body}mass_loss"


class EndValues(Record):
    """Post-test measurements with a profilometer, microscope or balance."""

    pin_wear_depth: MeasuredDepth | None = None
    """Wear depth of the pin."""
    pin_scar_diameter: MeasuredLength | None = None
    """Diameter of the scar on a spherical pin; if the disc is worn, the mean of length and width."""
    pin_scar_length: MeasuredLength | None = None
    """Length of the scar on a spherical pin, along the sliding direction."""
    pin_scar_width: MeasuredLength | None = None
    """Width of the scar on a spherical pin, across the sliding direction."""
    pin_wear_volume: MeasuredVolume | None = None
    """Wear volume of the pin."""
    pin_mass_loss: MeasuredMass | None = None
    """Mass loss of the pin; requires the density of the pin."""
    pin_profile: Profiles = ()
    """Profiles across the worn tip; scar diameter and depth are determined from them."""
    disc_wear_depth: MeasuredDepth | None = None
    """Maximum depth of the wear track on the disc."""
    disc_track_width: MeasuredLength | None = None
    """Width of the wear track on the disc."""
    disc_track_area: MeasuredArea | None = None
    """Cross-sectional area of the wear track on the disc, below the unworn surface."""
    disc_wear_volume: MeasuredVolume | None = None
    """Wear volume of the disc."""
    disc_mass_loss: MeasuredMass | None = None
    """Mass loss of the disc; requires the density of the disc."""
    disc_profile: Profiles = ()
    """Profiles across the wear track of the disc, at several places; depth and volume are determined from them."""
    curved_disc_wear_depth: MeasuredDepth | None = None
    """Wear depth of the crown of a crowned disc."""
    curved_disc_track_width: MeasuredLength | None = None
    """Width of the flat worn on a crowned disc."""
    curved_disc_wear_volume: MeasuredVolume | None = None
    """Wear volume of a crowned disc."""
    curved_disc_mass_loss: MeasuredMass | None = None
    """Mass loss of a crowned disc; requires its density."""
    curved_disc_profile: Profiles = ()
    """Profiles across the track of a crowned disc; the wear volume is determined from them."""
    flat_disc_wear_depth: MeasuredDepth | None = None
    """Depth of the track on a cylindrical disc."""
    flat_disc_track_width: MeasuredLength | None = None
    """Width of the track on a cylindrical disc."""
    flat_disc_wear_volume: MeasuredVolume | None = None
    """Wear volume of a cylindrical disc."""
    flat_disc_mass_loss: MeasuredMass | None = None
    """Mass loss of a cylindrical disc; requires its density."""
    flat_disc_profile: Profiles = ()
    """Profiles across the track of a cylindrical disc; the wear volume is determined from them."""

    @model_validator(mode="after")
    def _wear_is_a_loss(self) -> Self:
        # A body may gain material from the other one, by volume or mass, or by the length of a pin whose area stays the
        # same (``SlidingPin.refuse_wear``); no scar or groove can show that.
        for name in EndValues.model_fields:
            value = getattr(self, name)
            gains = name.endswith(("wear_volume", "mass_loss")) and name.startswith(_MAY_GAIN)
            signed = gains or name == "pin_wear_depth"
            if isinstance(value, EndValue) and value.value < 0 and not signed:
                found = value.shown({"m": "um", "m^3": "mm^3", "kg": "mg"}[value.unit])
                raise ValueError(f"{name}: found {found}; expected zero or more, since wear is a loss; {_remedy(name)}")
        return self

    @model_validator(mode="after")
    def _volume_is_given_once(self) -> Self:
        for body in ROLES:
            if getattr(self, f"{body}_profile") and getattr(self, f"{body}_wear_volume") is not None:
                raise ValueError(
                    f"{body}_wear_volume: found a wear volume in addition to {body}_profile, from which it is "
                    "computed; expected only one of the two; remove the other"
                )
        return self

    @model_validator(mode="after")
    def _volume_of_a_rolling_disc_is_given_once(self) -> Self:
        for disc in ROLLING_ROLES:
            keys = [f"{disc}_{what}" for what in ("wear_volume", "profile", "mass_loss")]
            found = [key for key in keys if getattr(self, key)]
            if f"{disc}_mass_loss" in found and len(found) > 1:
                raise ValueError(
                    f"{disc}_mass_loss: found a mass loss in addition to {found[0]}; expected only one of the two, "
                    "since either determines the wear volume; remove the other"
                )
        return self

    @model_validator(mode="after")
    def _each_map_has_one_before(self) -> Self:
        for body in ROLES:
            named: tuple[ProfileSource, ...] = getattr(self, f"{body}_profile")
            known = sum(one.before is not None for one in named)
            if known and body in ROLLING_ROLES:
                raise ValueError(
                    f"{body}_profile.before: found a map before the test of a rolling disc; expected it for a pin or "
                    "the disc under a pin only; remove the key"
                )
            if known not in (0, len(named)):
                raise ValueError(
                    f"{body}_profile: found before for {known} of {len(named)} files; expected it for all or none, so "
                    "that all are evaluated alike; add the missing maps, or remove the key"
                )
        return self

    @model_validator(mode="after")
    def _each_profile_is_given_once(self) -> Self:
        for body in ROLES:
            named: tuple[ProfileSource, ...] = getattr(self, f"{body}_profile")
            twice = next((one.file for one, count in Counter(named).items() if count > 1), None)
            if twice is not None:
                raise ValueError(
                    f"{body}_profile: found the same profile of {twice!r} twice; expected each profile once, since a "
                    "repeated profile would count as a second measurement; remove one of the two"
                )
        return self

    @property
    def mean_pin_scar(self) -> Quantity | None:
        """Scar diameter as in ASTM D4172 and G99, m: as measured, or the mean of length and width; None without."""
        if self.pin_scar_diameter is not None:
            return self.pin_scar_diameter
        measured = [one for one in (self.pin_scar_length, self.pin_scar_width) if one is not None]
        if not measured:
            return None
        count, known = len(measured), [one.standard_uncertainty for one in measured]
        spread = None if None in known else math.hypot(*(one or 0.0 for one in known)) / count
        return Quantity(value=sum(one.value for one in measured) / count, unit="m", standard_uncertainty=spread)


class Interruption(EndValues):
    """Measurements on the specimens at an interruption of the test."""

    model_config = ConfigDict(
        json_schema_extra={"anyOf": [{"required": ["sliding_distance"]}, {"required": ["rotations"]}]}
    )

    sliding_distance: Distance | None = None
    """Sliding distance of the pin up to the interruption."""
    rotations: Rotations | None = None
    """Rotations of the crowned disc up to the interruption."""
    remounted: bool = False
    """Whether the specimens were removed and remounted, which changes the zero offset of the depth sensor."""

    @property
    def place(self) -> float:
        """Where the test was interrupted: m for a pin, rotations for a crowned disc."""
        return self.sliding_distance.value if self.sliding_distance is not None else self.rotations or 0.0


def _above_zero(scale: Quantity) -> Quantity:
    if not scale.value > 0:
        raise ValueError(f"found {scale.value:g}; expected a positive scale factor, about 1")
    return scale


class Sensors(Record):
    """Uncertainties of the sensors other than noise."""

    depth_scale: Annotated[Ratio, AfterValidator(_above_zero)] = Quantity(value=1.0, unit="1")
    """Ratio of true to recorded displacement, by which the depth signal is multiplied."""


def _date_and_time(written: Any) -> Any:
    if isinstance(written, bool | int | float):
        raise ValueError(f"found {written!r}; expected a date and time such as 2006-03-01T09:30:00+01:00")
    return written


class RunManifest(Record):
    """One run: specimens, conditions, signal files and post-test measurements."""

    schema_version: Literal["tribopipe.run/1"] = Field(alias="schema")
    """Version of this document."""
    id: RunId
    """Name of the run, unique in an archive; its file is <id>.h5."""
    started: Annotated[datetime, BeforeValidator(_date_and_time)] | None = None
    """Start of the test, such as 2006-03-01T09:30:00+01:00."""
    title: str | None = None
    """Title of the run, one line."""
    operator: str | None = None
    """Operator of the test."""
    instrument: str | None = None
    """Name of the tribometer."""
    comment: str | None = None
    """Other information about the test."""
    contact: AnyContact | None = None
    """The two bodies; without them, only friction is evaluated."""
    conditions: Conditions
    """How the test was run."""
    signals: tuple[SignalFile, ...] = Field(min_length=1, max_length=100)
    """The instrument's files."""
    end_values: EndValues = EndValues()
    """Measurements on the specimens after the test."""
    interruptions: tuple[Interruption, ...] = ()
    """Measurements on the specimens at interruptions, in the order of the test."""
    sensors: Sensors = Sensors()
    """Uncertainties of the sensors other than noise."""

    @model_validator(mode="before")
    @classmethod
    def _names_of_the_contact(cls, document: Any) -> Any:
        contact = _contact_of(document)
        if contact is None:
            _refuse_unknown_kind(document)
            return document
        return contact.completed(document)

    @model_serializer(mode="wrap")
    def _in_the_names_of_the_contact(self, dumped: SerializerFunctionWrapHandler) -> Any:
        document = dumped(self)
        return document if self.contact is None else self.contact.stated(document)

    @classmethod
    def worded_for(cls, document: Mapping[str, Any], text: str) -> str:
        """Return a message about a run.toml in the names of its contact; an unknown body keeps its own."""
        contact = _contact_of(document)
        if contact is None:
            return text
        found = re.match(r"contact\.\S+: unknown key; ", text)
        unknown = found[0] if found else ""
        return unknown + contact.worded(text.removeprefix(unknown))

    @classmethod
    def known_in(cls, document: Mapping[str, Any], keys: Collection[str]) -> set[str]:
        """Return those keys that make sense with the contact of a run.toml, in its names."""
        contact = _contact_of(document)
        if contact is None:
            return set(keys)
        if "kind" in keys:
            return {key for key in keys if key in contact.model_fields}
        return {contact.worded(key) for key in keys if key not in foreign_keys(contact)}

    @model_validator(mode="after")
    def _what_is_said_fits_the_tribometer(self) -> Self:
        if self.contact is None:
            return self
        for where, part in self._parts():
            said = vars(part)  # an attribute that there is not is looked for in all names, to suggest the nearest
            foreign = next(
                (name for name in foreign_keys(type(self.contact)) if said.get(name) not in (None, ())), None
            )
            if foreign is not None:
                raise ValueError(
                    f"{where}.{foreign}: found a key that does not apply to {self.contact.kind} runs; expected one of "
                    f"{', '.join(sorted(_own_keys(part, self.contact)))}; remove the key, or correct contact.kind"
                )
        self.contact.refuse_conditions(self.conditions)
        return self

    @model_validator(mode="after")
    def _each_file_is_read_once(self) -> Self:
        named = Counter(name for part in self.signals for name in part.names)
        twice = next((name for name, count in named.items() if count > 1), None)
        if twice is not None:
            raise ValueError(f"signals: found the file {twice!r} twice; expected each file once; remove one of the two")
        return self

    @model_validator(mode="after")
    def _wear_fits_the_bodies(self) -> Self:
        for where, measured in self._parts():
            if isinstance(measured, EndValues) and self.contact is not None:
                self.contact.refuse_wear(where, measured)
        return self

    def _parts(self) -> "list[tuple[str, Conditions | EndValues]]":
        stops = [(f"interruptions[{number}]", stop) for number, stop in enumerate(self.interruptions)]
        return [("conditions", self.conditions), ("end_values", self.end_values), *stops]

    @model_validator(mode="after")
    def _interruptions_follow_each_other(self) -> Self:
        name = self.progress.signal
        for number, stop in enumerate(self.interruptions):
            if getattr(stop, name) is None:
                raise ValueError(f"interruptions[{number}].{name}: missing; add this key")
        places = [stop.place for stop in self.interruptions]
        if any(later <= earlier for earlier, later in pairwise(places)):
            raise ValueError(
                f"interruptions: found {', '.join(map(self.progress.shown, places))}; expected increasing values; "
                f"write the {self.progress.words} since the start of the test"
            )
        return self

    @property
    def tribometer(self) -> str | None:
        """Kind of the tribometer; None if run.toml does not describe the bodies."""
        return None if self.contact is None else self.contact.kind

    @property
    def contact_class(self) -> type[Contact]:
        """Class of the contact; that of a pin on a disc where run.toml does not describe the bodies."""
        return ASSUMED if self.contact is None else type(self.contact)

    @property
    def progress(self) -> Progress:
        """What wear grows along; the sliding distance where run.toml does not describe the bodies."""
        return self.contact_class.progress

    @property
    def planned(self) -> float | None:
        """Planned end along the progress, SI; None if it is not stated."""
        stated: Quantity | float | None = getattr(self.conditions, self.progress.signal)
        return stated.value if isinstance(stated, Quantity) else stated

    @property
    def nominal_speed(self) -> Quantity | None:
        """Nominal speed by which the progress follows from time, m/s; None if it is not stated."""
        conditions = self.conditions
        return conditions.nominal_speed if self.progress is SLIDING else getattr(conditions, self.progress.speed)

    @property
    def slip(self) -> Quantity | None:
        """Slip of bodies that roll on each other, uncertain by what is stated; None for others."""
        return self.slip_with(0.0)

    def slip_with(self, default: float) -> Quantity | None:
        """Return the slip; the default, a fraction of it, is for one of two speeds that is stated without uncertainty.

        A slip of which nothing is stated has no uncertainty yet.
        """
        return None if self.contact is None else self.contact.slip(self.conditions, default)

    @property
    def path(self) -> Quantity | None:
        """Sliding distance between two contacts that one place of a track meets, m; None if it is unknown.

        Where the bodies determine the track, it is that of the bodies, which may be other ones than were read.
        """
        if self.contact is None:
            return self.conditions.path
        own, conditions = self.contact.own_track_radius, self.conditions
        path = conditions.path if own is None else conditions.model_copy(update={"track_radius": own}).path
        return None if path is None else scaled(path, 1 / self.contact.contacts_per_turn)

    @property
    def friction_arm(self) -> float | None:
        """Friction torque over friction force, m; None if it is unknown."""
        radius = self.conditions.track_radius
        arm = None if radius is None else radius.value
        return arm if self.contact is None else self.contact.friction_arm(arm)

    @property
    def depth_scale(self) -> Quantity:
        """Approach of the two bodies over what the depth sensor reads."""
        scale = self.sensors.depth_scale
        return scale if self.contact is None else scaled(scale, self.contact.depth_share)

    @property
    def pin(self) -> Tip | None:
        """The pin that slides; None if there is none, or run.toml does not describe it."""
        return None if self.contact is None else self.contact.tip

    @property
    def bodies(self) -> dict[str, Specimen]:
        """The two bodies by name; nothing where run.toml does not describe them."""
        return {} if self.contact is None else self.contact.bodies

    def worded(self, text: str) -> str:
        """Return a text about the two bodies in the names of the contact."""
        return text if self.contact is None else self.contact.worded(text)

    @property
    def described(self) -> Contact:
        """The contact. Raises ``ContactError`` where run.toml does not describe the bodies."""
        if self.contact is None:
            raise _no_contact(self.id)
        return self.contact


def _no_contact(run_id: str) -> ContactError:
    return ContactError(
        f"{run_id}: found no [contact] in run.toml; expected the two bodies, which are needed to compute wear; add "
        "[contact], [contact.pin] and [contact.disc]"
    )


def _family_keys(contact: type[Contact]) -> tuple[str, ...]:
    """Return the keys of conditions and post-test measurements that make sense for the family of a contact alone."""
    bodies = tuple(f"{role}_" for role in contact.roles)
    return *contact.family_conditions, *(name for name in EndValues.model_fields if name.startswith(bodies))


def foreign_keys(contact: type[Contact]) -> tuple[str, ...]:
    """Return the keys of conditions and post-test measurements that do not apply to a contact."""
    kinds, own = contacts().values(), {*contact.own_conditions, *_family_keys(contact)}
    families = dict.fromkeys(key for kind in kinds for key in _family_keys(kind) if key not in own)
    return *families, *sorted({key for kind in kinds for key in kind.own_conditions} - own)


def _own_keys(part: Conditions | EndValues, contact: Contact) -> set[str]:
    return {*_family_keys(type(contact))} & {*type(part).model_fields}


def _contact_of(document: Any) -> type[Contact] | None:
    """Return the class of the contact that a run.toml describes, as far as it can be determined."""
    return contact_described(document.get("contact")) if isinstance(document, Mapping) else None


def unknown_kind(document: Any) -> str | None:
    """Return the kind of contact that a run.toml names and that is not installed here; None if it is."""
    contact = document.get("contact") if isinstance(document, Mapping) else None
    kind = contact.get("kind") if isinstance(contact, Mapping) else None
    return kind if isinstance(kind, str) and contact_named(kind) is None else None


def _refuse_unknown_kind(document: Any) -> None:
    """Raise ``ValueError`` for a kind that is not installed: of its other keys nothing is known."""
    kind = unknown_kind(document)
    if kind is not None:
        known = contacts()
        raise ValueError(
            f"contact.kind: found {kind!r}; expected {', '.join(map(repr, known))}, or a kind from an installed "
            f"package; {did_you_mean(kind, known)}"
        )


def manifest_path(run: Path) -> Path:
    """Name the manifest of a run given as its folder or as the file itself."""
    return run / MANIFEST_NAME if run.is_dir() or run.suffix.lower() != ".toml" else run


def read_manifest(path: Path) -> tuple[RunManifest, bytes]:
    """Read a run.toml and its bytes as they stand.

    Raises ``ManifestError`` with file, key (or line), what was found and what was expected.
    """
    if leads_out(path, path.parent):
        raise ManifestError(
            f"{path}: found a link to a file outside the run folder; expected run.toml itself, because a run folder "
            "must contain all its files; replace the link with a copy of the file"
        )
    content = read_bytes(path)
    return read_document(parse_toml(path, content), RunManifest, where=str(path)), content
