"""run.toml: what a lab writes beside the instrument's own files about one run."""

import re
from datetime import datetime
from itertools import pairwise
from pathlib import Path, PureWindowsPath
from typing import Annotated, Any, Literal, Self

from pydantic import AfterValidator, BeforeValidator, Field, model_validator

from tribopipe.records.base import Record, parse_toml, read_bytes, read_document
from tribopipe.records.quantity import (
    Density,
    Distance,
    Force,
    Length,
    MeasuredDepth,
    MeasuredLength,
    Percentage,
    Pressure,
    Quantity,
    Ratio,
    Speed,
    Temperature,
    Toughness,
)
from tribopipe.records.signals import SignalName
from tribopipe.units import show

MANIFEST_NAME = "run.toml"
MANIFEST_SCHEMA = "tribopipe.run/1"

_ID = re.compile(r"[A-Za-z0-9][A-Za-z0-9._+-]{0,99}")
_WINDOWS_DEVICES = {"con", "prn", "aux", "nul", *(f"{port}{n}" for port in ("com", "lpt") for n in range(10))}


def _usable_as_file_name(identifier: str) -> str:
    if not _ID.fullmatch(identifier) or identifier.endswith("."):
        raise ValueError(
            f"found {identifier!r}; expected up to 100 letters, digits and . _ + -, starting with a "
            "letter or digit, since the archive file is named after it"
        )
    if identifier.split(".")[0].lower() in _WINDOWS_DEVICES:
        raise ValueError(f"found {identifier!r}, a device name on Windows; choose another id")
    return identifier


RunId = Annotated[str, AfterValidator(_usable_as_file_name), Field(json_schema_extra={"pattern": f"^{_ID.pattern}$"})]


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

    shape: Literal["spherical", "flat"]
    """Spherical tip, or a flat end of constant area."""
    radius: Length
    """Tip radius R_P of a spherical pin; radius of the flat end of a flat one."""


class PinOnDisc(Record):
    """A pin pressed on a rotating disc."""

    kind: Literal["pin-on-disc"]
    """Type of tribometer."""
    pin: Pin
    """The pin."""
    disc: Specimen
    """The disc."""


class StatedFriction(Record):
    """Parameters of μ(s) = A·exp(−s/c) + b (Eq. 7), known beforehand."""

    amplitude: Ratio
    """A: friction coefficient at the start above the steady state."""
    steady_state: Ratio
    """b."""
    running_in_distance: Distance
    """c."""


class Conditions(Record):
    """How the test was run."""

    normal_load: Force
    """Nominal normal load F_N."""
    sliding_speed: Speed | None = None
    """Nominal sliding speed; needed where only one of time and sliding distance was recorded."""
    sliding_distance: Distance | None = None
    """Planned sliding distance."""
    medium: str | None = None
    """What surrounds the contact: "air", "water"…"""
    temperature: Temperature | None = None
    """Room temperature."""
    relative_humidity: Percentage | None = None
    """Relative humidity of the surrounding air."""
    friction: StatedFriction | None = None
    """Friction to predict with under Sarkar's law, where it is known beforehand; fits take the measured friction."""


class ColumnSource(Record):
    """Where one signal stands in a file."""

    column: str = Field(min_length=1)
    """Name of the column as the file's header writes it."""
    unit: str | None = None
    """Unit of the column; wins over what the file says, needed where the file says none."""


def _column_by_name(written: Any) -> Any:
    return {"column": written} if isinstance(written, str) else written


def _inside_run_folder(name: str) -> str:
    # Windows' rules also see what other systems would take for a folder or a root.
    path = PureWindowsPath(name)
    if not name.isprintable() or path.anchor or ".." in path.parts:
        raise ValueError(
            f"found {name!r}; expected the name of a file in the run folder, since a run carries all its files; "
            "copy the file beside run.toml"
        )
    return name


class SignalFile(Record):
    """One file of the instrument and what its columns mean."""

    file: Annotated[str, AfterValidator(_inside_run_folder)] = Field(min_length=1)
    """Name of the file, relative to run.toml."""
    reader: str | None = None
    """Format, where it should not be detected: "delimited", "ducom-winducom"…"""
    encoding: str | None = None
    """Text encoding, where it should not be detected: "cp1252", "shift_jis"…"""
    separator: str | None = None
    """Column separator, where it should not be detected: ";", "\\t", or " " for runs of blanks."""
    decimal: Literal[".", ","] | None = None
    """Decimal sign, where it should not be detected."""
    columns: dict[SignalName, Annotated[ColumnSource, BeforeValidator(_column_by_name)]] = Field(default_factory=dict)
    """Signal → column. Left out, columns are recognised by their names."""


class EndValues(Record):
    """What the profilometer or microscope said after the test."""

    pin_wear_depth: MeasuredDepth | None = None
    """Height worn off the pin."""
    pin_scar_diameter: MeasuredLength | None = None
    """Diameter of the flat circular scar on a spherical pin; its cap height is the wear depth."""
    disc_wear_depth: MeasuredDepth | None = None
    """Maximum depth of the wear track on the disc."""

    @model_validator(mode="after")
    def _depths_are_losses(self) -> Self:
        for name in ("pin_wear_depth", "disc_wear_depth"):
            depth = getattr(self, name)
            if depth is not None and depth.value < 0:
                raise ValueError(f"{name}: found {depth.shown('um')}; expected zero or more, since wear is a loss")
        return self


class Interruption(EndValues):
    """What was measured on the specimens where the test was interrupted."""

    sliding_distance: Distance
    """Distance slid until then."""
    remounted: bool = False
    """Whether the specimens were taken out, so that the depth sensor started again from another offset."""


def _above_zero(scale: Quantity) -> Quantity:
    if not scale.value > 0:
        raise ValueError(f"found {scale.value:g}; expected a scale above zero, about 1")
    return scale


class Sensors(Record):
    """How far the sensors can be trusted beside their noise."""

    depth_scale: Annotated[Ratio, AfterValidator(_above_zero)] = Quantity(value=1.0, unit="1")
    """True displacement over displacement read: the depth signal is multiplied by it."""


def _date_and_time(written: Any) -> Any:
    if isinstance(written, bool | int | float):
        raise ValueError(f"found {written!r}; expected a date and time such as 2006-03-01T09:30:00+01:00")
    return written


class RunManifest(Record):
    """One run: specimens, conditions, signal files and end values."""

    schema_version: Literal["tribopipe.run/1"] = Field(alias="schema")
    """Version of this document."""
    id: RunId
    """Name of the run, unique in an archive; its file is <id>.h5."""
    started: Annotated[datetime, BeforeValidator(_date_and_time)]
    """Start of the test, such as 2006-03-01T09:30:00+01:00."""
    title: str | None = None
    """One line about the run."""
    operator: str | None = None
    """Who ran the test."""
    instrument: str | None = None
    """Name of the tribometer."""
    comment: str | None = None
    """Anything else worth keeping."""
    contact: PinOnDisc
    """The two bodies."""
    conditions: Conditions
    """How the test was run."""
    signals: tuple[SignalFile, ...] = Field(min_length=1)
    """The instrument's files."""
    end_values: EndValues = EndValues()
    """What was measured on the specimens afterwards."""
    interruptions: tuple[Interruption, ...] = ()
    """What was measured on the specimens in between, in the order of the test."""
    sensors: Sensors = Sensors()
    """How far the sensors can be trusted beside their noise."""

    @model_validator(mode="after")
    def _wear_fits_the_pin(self) -> Self:
        _refuse_impossible_wear("end_values", self.end_values, self.contact.pin)
        for number, interruption in enumerate(self.interruptions):
            _refuse_impossible_wear(f"interruptions[{number}]", interruption, self.contact.pin)
        return self

    @model_validator(mode="after")
    def _interruptions_follow_each_other(self) -> Self:
        slid = [interruption.sliding_distance.value for interruption in self.interruptions]
        if any(later <= earlier for earlier, later in pairwise(slid)):
            raise ValueError(
                f"interruptions: found the sliding distances {', '.join(f'{s:g}' for s in slid)} m; expected each "
                "above the one before; write the distance slid since the start of the test"
            )
        return self


def _refuse_impossible_wear(where: str, measured: EndValues, pin: Pin) -> None:
    scar, depth, radius = measured.pin_scar_diameter, measured.pin_wear_depth, pin.radius
    if scar is not None and pin.shape == "flat":
        raise ValueError(
            f"{where}.pin_scar_diameter: found one for a flat pin, whose contact does not grow; "
            "give pin_wear_depth instead"
        )
    if scar is not None and scar.value >= 2 * radius.value:
        raise ValueError(
            f"{where}.pin_scar_diameter: found {scar.shown('um')}, no smaller "
            f"than the pin's diameter of {show(2 * radius.value, None, 'm', 'um')}; expected a scar on the tip; "
            "check both units"
        )
    if depth is not None and pin.shape == "spherical" and depth.value >= radius.value:
        raise ValueError(
            f"{where}.pin_wear_depth: found {depth.shown('um')}, no less than the pin "
            f"radius of {radius.shown('um')}; expected a depth within the tip; check both units"
        )


def manifest_path(run: Path) -> Path:
    """Name the manifest of a run given as its folder or as the file itself."""
    return run / MANIFEST_NAME if run.is_dir() or run.suffix.lower() != ".toml" else run


def read_manifest(path: Path) -> tuple[RunManifest, bytes]:
    """Read a run.toml and its bytes as they stand.

    Raises ``ManifestError`` with file, key (or line), what was found and what was expected.
    """
    content = read_bytes(path)
    return read_document(parse_toml(path, content), RunManifest, where=str(path)), content
