"""plan.toml: what a virtual tribometer is to record, for sample runs and ground truth."""

from collections import Counter
from collections.abc import Mapping
from datetime import datetime
from types import MappingProxyType
from typing import Annotated, Literal, Self

from pydantic import AfterValidator, Field, ValidationError, model_validator

from tribopipe.base.errors import ContactError
from tribopipe.documents.contact_kinds import AnySlidingPin, AnyTwinDisc
from tribopipe.documents.manifest import Rotations, RunId, RunManifest, StatedFriction
from tribopipe.documents.quantity import (
    Distance,
    DriftRate,
    Force,
    Frequency,
    Length,
    MeasuredDepth,
    Quantity,
    Ratio,
    Slip,
    Speed,
    Time,
    WearCoefficient,
)
from tribopipe.documents.recipe import GivenParameter, LawName
from tribopipe.documents.record import Record, first_problem
from tribopipe.physics.calculation_methods import DistanceConvention

_NOTHING: Mapping[str, Quantity] = MappingProxyType({})


def _of(value: float, unit: str) -> Quantity:
    return Quantity(value=value, unit=unit)


_MOST_SAMPLES = 10_000_000


def _refuse_endless(seconds: float, sensors: "RecordingSensors") -> None:
    samples = seconds * sensors.sampling_rate.value
    if samples > _MOST_SAMPLES:
        raise ValueError(
            f"sensors.sampling_rate: found {samples:.3g} samples per run; expected at most {_MOST_SAMPLES}; lower the "
            "rate, or shorten the runs"
        )


class RecordingSensors(Record):
    """Sampling and noise of a virtual instrument."""

    sampling_rate: Frequency = Field(default_factory=lambda: _of(10.0, "1/s"))
    """Samples per second."""
    depth_noise: Length = Field(default_factory=lambda: _of(1e-7, "m"))
    """Standard deviation of the noise in the depth signal."""
    depth_correlation_time: Time = Field(default_factory=lambda: _of(2.0, "s"))
    """Correlation time of the depth noise."""
    depth_resolution: Length = Field(default_factory=lambda: _of(1e-8, "m"))
    """Resolution of the digitized depth signal."""
    friction_noise: Ratio = Field(default_factory=lambda: _of(0.02, "1"))
    """Standard deviation of the noise in the friction coefficient."""
    friction_correlation_time: Time = Field(default_factory=lambda: _of(0.5, "s"))
    """Correlation time of the friction noise."""
    load_noise: Ratio = Field(default_factory=lambda: _of(0.002, "1"))
    """Standard deviation of the noise in the normal force, relative to the normal force."""


class Sensors(RecordingSensors):
    """Sensors and post-test measurements of the virtual pin-on-disc tribometer."""

    scar_uncertainty: Length = Field(default_factory=lambda: _of(2e-6, "m"))
    """Standard uncertainty of the scar diameter of a spherical pin, drawn once per run."""
    pin_end_value: Literal["pin_scar_diameter", "pin_wear_depth"] = "pin_scar_diameter"
    """Measurement on a spherical pin after the test; on a flat pin, always the wear depth."""
    height_loss_uncertainty: Length = Field(default_factory=lambda: _of(2.5e-7, "m"))
    """Standard uncertainty of the wear depth of a pin, drawn once per run if it is measured."""
    disc_volume_uncertainty: Ratio = Field(default_factory=lambda: _of(0.05, "1"))
    """Relative standard uncertainty of the wear volume of the counterbody, drawn once per run if it has a k_D."""


class AnyVirtualRun(Record):
    """Keys of the runs of all series."""

    id: RunId
    """Name of the run and of its folder."""
    started: datetime
    """Start of the virtual test."""
    seed: int = Field(ge=0)
    """Seed of every random draw of this run."""
    friction: StatedFriction
    """True friction, over the sliding or slip distance."""
    zero_offset: Length
    """Depth signal before any wear."""
    drift_rate: DriftRate
    """Drift of the depth sensor."""


class VirtualRun(AnyVirtualRun):
    """One run of a series: load, true values, and seed of the noise."""

    normal_load: Force
    """F_N."""
    wear_coefficient: WearCoefficient
    """True k_D of the pin."""
    disc_wear_coefficient: WearCoefficient | None = None
    """True k_D of the counterbody; if stated, its wear is simulated as well, and its wear volume is measured."""
    disc_wear_depth: MeasuredDepth | None = None
    """Wear depth of the disc at the end of the run; omit it if the wear of the disc was not measurable."""

    @model_validator(mode="after")
    def _the_counterbody_wears_in_one_way(self) -> Self:
        if self.disc_wear_coefficient is not None and self.disc_wear_depth is not None:
            raise ValueError(
                "disc_wear_depth: found a wear depth in addition to disc_wear_coefficient, from which it is computed; "
                "expected only one of the two; remove the other"
            )
        return self


class AnySeries(Record):
    """Keys of the series of all contacts."""

    title: str
    """Title of the series, one line."""
    law: LawName = "archard"
    """True wear law."""
    law_parameters: dict[str, GivenParameter] = Field(default_factory=dict)
    """True parameters of the law in addition to k_D."""
    medium: str
    """Environment or lubricant."""
    depth_scale: Ratio = Field(default_factory=lambda: _of(1.0, "1"))
    """Ratio of true to recorded displacement."""


class Series(AnySeries):
    """Runs of the same pair of materials on the same instrument."""

    contact: AnySlidingPin
    """The two bodies."""
    systematic_errors: bool = False
    """Whether errors of load, tip radius, moduli, speed and sensor scale are drawn once per run within the stated
    uncertainties, or these quantities are exactly as stated in run.toml."""
    sliding_speed: Speed
    """Nominal sliding speed."""
    sliding_distance: Distance
    """Sliding distance of each run."""
    stroke: Length | None = None
    """Stroke length of a reciprocating pin."""
    track_radius: Length | None = None
    """Radius of the wear track on the disc; required if the disc has a k_D."""
    sensors: Sensors = Sensors()
    """The instrument."""
    runs: tuple[VirtualRun, ...] = Field(min_length=1)
    """The runs."""

    @model_validator(mode="after")
    def _runs_end(self) -> Self:
        _refuse_endless(self.sliding_distance.value / self.sliding_speed.value, self.sensors)
        return self

    @model_validator(mode="after")
    def _the_contact_slides_like_this(self) -> Self:
        for number, run in enumerate(self.runs):
            try:
                path = self.manifest(run).path
            except ValidationError as error:
                raise ValueError(first_problem(error, RunManifest)) from error
            if run.disc_wear_coefficient is not None and path is None:
                raise ValueError(
                    f"runs[{number}].disc_wear_coefficient: found a wear coefficient, but neither track_radius nor "
                    "stroke in the series; expected one of the two, to determine the length of the wear track on the "
                    f"{self.contact.counterbody_name()}; add one to the series, such as "
                    'track_radius = "5 mm"'
                )
        return self

    def manifest(self, run: VirtualRun, ends: Mapping[str, Quantity] = _NOTHING) -> RunManifest:
        """Return the run.toml of a run, with these post-test measurements."""
        conditions = {
            "normal_load": run.normal_load,
            "sliding_speed": self.sliding_speed,
            "sliding_distance": self.sliding_distance,
            "stroke": self.stroke,
            "track_radius": self.track_radius,
        }
        return _manifest(self, run, conditions, ends)


DiscEndValue = Literal["wear_depth", "track_width", "wear_volume"]
"""Measurement on a disc after the test."""


class TwinDiscSensors(RecordingSensors):
    """Sensors and post-test measurements of the virtual twin-disc tribometer."""

    sampling_rate: Frequency = Field(default_factory=lambda: _of(1 / 60, "1/s"))
    """Samples per second; each is a mean over one sampling interval. One more is recorded at the end of the test."""
    depth_noise: Length = Field(default_factory=lambda: _of(3e-8, "m"))
    """Standard deviation of the noise in the depth signal."""
    depth_correlation_time: Time = Field(default_factory=lambda: _of(300.0, "s"))
    """Correlation time of the depth noise."""
    depth_resolution: Length = Field(default_factory=lambda: _of(1e-9, "m"))
    """Resolution of the digitized depth signal."""
    friction_noise: Ratio = Field(default_factory=lambda: _of(0.01, "1"))
    """Standard deviation of the noise in the friction coefficient."""
    friction_correlation_time: Time = Field(default_factory=lambda: _of(60.0, "s"))
    """Correlation time of the friction noise."""
    end_values: tuple[DiscEndValue, ...] = ("wear_volume",)
    """Measurement on either disc after the test."""
    volume_uncertainty: Ratio = Field(default_factory=lambda: _of(0.08, "1"))
    """Relative standard uncertainty of the wear volume of a disc, drawn once per run and disc."""
    wear_depth_uncertainty: Length = Field(default_factory=lambda: _of(5e-8, "m"))
    """Standard uncertainty of a disc's wear depth, drawn once per run and disc."""
    track_width_uncertainty: Length = Field(default_factory=lambda: _of(4e-6, "m"))
    """Standard uncertainty of the width of a disc's track, drawn once per run and disc."""


class Fatigue(Record):
    """Wear that accelerates because of fatigue, as suspected in the paper (Section 3.5); no wear law includes it."""

    from_rotations: Rotations
    """Rotations after which fatigue begins."""
    factor: float = Field(gt=0)
    """Factor by which both k_D are multiplied from then on."""


def _discs_that_slip(slip: Quantity) -> Quantity:
    if slip.value == 0:
        raise ValueError("found zero slip; expected a nonzero slip, since there is no sliding wear in pure rolling")
    if slip.value <= -1:
        raise ValueError(
            f"found {slip.shown('%')}; expected a slip greater than -100 %, at which the cylindrical disc stands "
            "still; enter the slip as (v2 - v1)/v1"
        )
    return slip


class TwinDiscVirtualRun(AnyVirtualRun):
    """One run of two discs: slip, rotations, true values, and seed of the noise."""

    normal_load: Force | None = None
    """Normal load; default: that of the series."""
    slip: Annotated[Slip, AfterValidator(_discs_that_slip)]
    """(v₂ − v₁)/v₁ of the unworn discs."""
    rotations: Rotations
    """Rotations of the crowned disc."""
    curved_wear_coefficient: WearCoefficient
    """True k_D of the crowned disc."""
    flat_wear_coefficient: WearCoefficient
    """True k_D of the cylindrical disc."""
    fatigue: Fatigue | None = None
    """Change of both k_D during the run; default: constant."""

    @model_validator(mode="after")
    def _fatigue_sets_in_during_the_run(self) -> Self:
        if self.fatigue is not None and self.fatigue.from_rotations >= self.rotations:
            raise ValueError(
                f"fatigue.from_rotations: found {self.fatigue.from_rotations:.0f} in a run of {self.rotations:.0f} "
                "rotations; expected fewer rotations than in the run, since fatigue would not start otherwise; correct "
                "from_rotations, or remove fatigue"
            )
        return self


class TwinDiscSeries(AnySeries):
    """Runs of the same pair of discs on the same instrument."""

    distance_per_rotation: DistanceConvention = "full-slip"
    """Convention for the sliding distance of a point of a disc in one rotation, for the true wear."""
    contact: AnyTwinDisc
    """The two discs."""
    systematic_errors: bool = False
    """Whether errors of load, radii, moduli, slip and sensor scale are drawn once per run within the stated
    uncertainties, or these quantities are exactly as stated in run.toml. The number of rotations is always exact."""
    curved_disc_speed: Speed
    """Nominal tangential speed v₁ of the crowned disc."""
    normal_load: Force | None = None
    """Normal load of runs that do not state a load."""
    sensors: TwinDiscSensors = TwinDiscSensors()
    """The instrument."""
    runs: tuple[TwinDiscVirtualRun, ...] = Field(min_length=1)
    """The runs."""

    @model_validator(mode="after")
    def _every_run_has_a_load(self) -> Self:
        for number, run in enumerate(self.runs):
            if run.normal_load is None and self.normal_load is None:
                raise ValueError(
                    f'runs[{number}].normal_load: missing; add this key, such as normal_load = "250 mN", to the run '
                    "or to its series"
                )
        return self

    @model_validator(mode="after")
    def _runs_end(self) -> Self:
        most = max(run.rotations for run in self.runs)
        _refuse_endless(most * self.contact.travel / self.curved_disc_speed.value, self.sensors)
        return self

    def load_of(self, run: TwinDiscVirtualRun) -> Quantity:
        """Return F_N of a run: its own, or that of the series."""
        load = run.normal_load or self.normal_load
        if load is None:
            raise ContactError(
                f"{run.id}: found no normal_load in the run or its series; expected a normal load in one of the two; "
                "add normal_load"
            )
        return load

    def manifest(self, run: TwinDiscVirtualRun, ends: Mapping[str, Quantity] = _NOTHING) -> RunManifest:
        """Return the run.toml of a run, with these post-test measurements."""
        conditions: dict[str, Quantity | float | None] = {
            "normal_load": self.load_of(run),
            "curved_disc_speed": self.curved_disc_speed,
            "slip": run.slip,
            "rotations": run.rotations,
        }
        return _manifest(self, run, conditions, ends)


def _manifest(
    series: Series | TwinDiscSeries,
    run: VirtualRun | TwinDiscVirtualRun,
    conditions: Mapping[str, Quantity | float | None],
    ends: Mapping[str, Quantity],
) -> RunManifest:
    given = {name: value for name, value in conditions.items() if value is not None}
    return RunManifest.model_validate(
        {
            "schema": "tribopipe.run/1",
            "id": run.id,
            "started": run.started,
            "contact": series.contact.model_dump(),
            "conditions": given | {"medium": series.medium},
            "signals": [{"file": "signals.csv"}],
            "sensors": {"depth_scale": series.depth_scale},
            "end_values": {name: value.model_dump() for name, value in ends.items()},
        }
    )


class Plan(Record):
    """Series of virtual runs."""

    schema_version: Literal["tribopipe.plan/1"] = Field(alias="schema")
    """Version of this document."""
    series: tuple[Series, ...] = ()
    """The series of a pin on a disc."""
    twin_disc_series: tuple[TwinDiscSeries, ...] = ()
    """The series of two discs."""

    @model_validator(mode="after")
    def _something_is_planned_and_once(self) -> Self:
        pins = [run.id for series in self.series for run in series.runs]
        runs = [*pins, *(run.id for series in self.twin_disc_series for run in series.runs)]
        if not runs:
            raise ValueError("series: missing; expected at least one series; add [[series]] or [[twin_disc_series]]")
        twice = [run_id for run_id, count in Counter(runs).items() if count > 1]
        if twice:
            raise ValueError(
                f"found the run {twice[0]!r} twice; expected a unique ID for each run; rename one of the two"
            )
        return self


class Truth(Record):
    """True values of a virtual run, written to truth.json in its folder."""

    schema_version: Literal["tribopipe.truth/1"] = Field(default="tribopipe.truth/1", alias="schema")
    """Version of this document."""
    id: RunId
    """Name of the run."""
    law: LawName
    """Wear law."""
    law_parameters: dict[str, Quantity] | None = None
    """Parameters of the law in addition to k_D; None if it has none."""
    wear_coefficient: WearCoefficient
    """k_D."""
    friction: StatedFriction
    """Eq. 7."""
    zero_offset: Quantity
    """Depth signal before any wear."""
    drift_rate: DriftRate
    """Drift of the depth sensor."""
    end_pin_wear_depth: Quantity
    """Wear depth of the pin at the end, without errors."""
    end_disc_wear_depth: Quantity
    """Wear depth of the disc at the end, without errors."""
    disc_wear_coefficient: WearCoefficient | None = None
    """k_D of the counterbody; None if it has none."""
    end_disc_wear_volume: Quantity | None = None
    """Wear volume of the counterbody at the end, without any error; only if it has a k_D."""


class TwinDiscTruth(Record):
    """True values of a virtual run of two discs, written to truth.json in its folder."""

    schema_version: Literal["tribopipe.twin-disc-truth/1"] = Field(
        default="tribopipe.twin-disc-truth/1", alias="schema"
    )
    """Version of this document."""
    id: RunId
    """Name of the run."""
    law: LawName
    """Wear law."""
    law_parameters: dict[str, Quantity] | None = None
    """Parameters of the law in addition to k_D; None if it has none."""
    distance_per_rotation: DistanceConvention
    """Convention for the sliding distance of a point of a disc in one rotation."""
    curved_wear_coefficient: WearCoefficient
    """k_D of the crowned disc."""
    flat_wear_coefficient: WearCoefficient
    """k_D of the cylindrical disc."""
    fatigue: Fatigue | None = None
    """Change of both k_D during the run."""
    friction: StatedFriction
    """Eq. 7, over the slip distance."""
    zero_offset: Quantity
    """Depth signal before any wear."""
    drift_rate: DriftRate
    """Drift of the depth sensor."""
    end_curved_wear_depth: Quantity
    """Wear depth of the crowned disc at the end, without any error."""
    end_flat_wear_depth: Quantity
    """Wear depth of the cylindrical disc at the end, without any error."""
    end_curved_wear_volume: Quantity
    """Wear volume of the crowned disc at the end, without errors."""
    end_flat_wear_volume: Quantity
    """Wear volume of the cylindrical disc at the end, without errors."""
    end_track_width: Quantity
    """Width of the track on both discs at the end, without any error."""
