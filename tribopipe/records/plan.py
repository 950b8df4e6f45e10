"""plan.toml: what a virtual tribometer is to record, for sample runs and ground truth."""

from datetime import datetime
from typing import Literal

from pydantic import Field

from tribopipe.records.base import Record
from tribopipe.records.manifest import PinOnDisc, RunId, StatedFriction
from tribopipe.records.quantity import (
    Distance,
    DriftRate,
    Force,
    Frequency,
    Length,
    MeasuredDepth,
    Quantity,
    Ratio,
    Speed,
    Time,
    WearCoefficient,
)
from tribopipe.records.recipe import LawName


def _of(value: float, unit: str) -> Quantity:
    return Quantity(value=value, unit=unit)


class Sensors(Record):
    """How the virtual instrument records, and what it adds to the truth."""

    sampling_rate: Frequency = Field(default_factory=lambda: _of(10.0, "1/s"))
    """Samples per second."""
    depth_noise: Length = Field(default_factory=lambda: _of(1e-7, "m"))
    """Standard deviation of the depth reading."""
    depth_correlation_time: Time = Field(default_factory=lambda: _of(2.0, "s"))
    """Time over which the noise of the depth forgets itself."""
    depth_resolution: Length = Field(default_factory=lambda: _of(1e-8, "m"))
    """Step of the digitised depth."""
    friction_noise: Ratio = Field(default_factory=lambda: _of(0.02, "1"))
    """Standard deviation of the friction coefficient."""
    friction_correlation_time: Time = Field(default_factory=lambda: _of(0.5, "s"))
    """Time over which the noise of friction forgets itself."""
    load_noise: Ratio = Field(default_factory=lambda: _of(0.002, "1"))
    """Standard deviation of the normal force over the normal force."""
    scar_uncertainty: Length = Field(default_factory=lambda: _of(2e-6, "m"))
    """Standard uncertainty of the scar diameter of a spherical pin, drawn once a run."""
    pin_end_value: Literal["pin_scar_diameter", "pin_wear_depth"] = "pin_scar_diameter"
    """What is measured on a spherical pin after the test; on a flat one it is always the depth."""
    height_loss_uncertainty: Length = Field(default_factory=lambda: _of(2.5e-7, "m"))
    """Standard uncertainty of the height lost by a pin, drawn once a run where that is measured."""


class VirtualRun(Record):
    """One run of a series: load, the truth behind it, and the seed of its noise."""

    id: RunId
    """Name of the run and of its folder."""
    started: datetime
    """Start of the virtual test."""
    seed: int = Field(ge=0)
    """Seed of every random draw of this run."""
    normal_load: Force
    """F_N."""
    wear_coefficient: WearCoefficient
    """True k_D of the pin."""
    friction: StatedFriction
    """True friction."""
    zero_offset: Length
    """Sensor reading before any wear."""
    drift_rate: DriftRate
    """Drift of the depth sensor."""
    disc_wear_depth: MeasuredDepth | None = None
    """Disc wear at the end of the run; left out where none could be measured."""


class Series(Record):
    """Runs of the same pair of materials on the same instrument."""

    title: str
    """One line about the series."""
    law: LawName = "archard"
    """Wear law of the truth."""
    contact: PinOnDisc
    """The two bodies."""
    medium: str
    """What surrounds the contact."""
    depth_scale: Ratio = Field(default_factory=lambda: _of(1.0, "1"))
    """True displacement over displacement read."""
    systematic_errors: bool = False
    """Whether load, tip radius, moduli, speed and sensor scale are off by errors drawn once a run within their stated
    uncertainty, or are just what the manifest says."""
    sliding_speed: Speed
    """Nominal sliding speed."""
    sliding_distance: Distance
    """Sliding distance of each run."""
    sensors: Sensors = Sensors()
    """The instrument."""
    runs: tuple[VirtualRun, ...] = Field(min_length=1)
    """The runs."""


class Plan(Record):
    """Series of virtual runs."""

    schema_version: Literal["tribopipe.plan/1"] = Field(alias="schema")
    """Version of this document."""
    series: tuple[Series, ...] = Field(min_length=1)
    """The series."""


class Truth(Record):
    """What a virtual run was made from; lies beside it as truth.json."""

    schema_version: Literal["tribopipe.truth/1"] = Field(default="tribopipe.truth/1", alias="schema")
    """Version of this document."""
    id: RunId
    """Name of the run."""
    law: LawName
    """Wear law."""
    wear_coefficient: WearCoefficient
    """k_D."""
    friction: StatedFriction
    """Eq. 7."""
    zero_offset: Quantity
    """Sensor reading before any wear."""
    drift_rate: DriftRate
    """Drift of the depth sensor."""
    end_pin_wear_depth: Quantity
    """Pin wear at the end, without any error."""
    end_disc_wear_depth: Quantity
    """Disc wear at the end, without any error."""
