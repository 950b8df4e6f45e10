"""Preprocessing of a run's signals before anything is computed: the steps a recipe lists, and what they did."""

from collections.abc import Mapping
from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, WithJsonSchema, model_validator

from tribopipe.documents.quantity import Instant, Quantity, read_quantity
from tribopipe.documents.record import Record
from tribopipe.documents.signals import SIGNALS, SignalName

StrokeMethod = Literal["middle-of-stroke", "half-difference"]
TurnedSignal = Literal["depth", "normal_force", "friction_force", "friction_coefficient"]
"""Signals whose sign is a matter of how the sensor is mounted."""
_Written = WithJsonSchema(
    {
        "anyOf": [{"type": "string"}, {"type": "number"}, {"type": "object"}, {"type": "null"}],
        "description": 'Value of the signal with its unit, such as "80 degC" or "-5 N"; a plain number for a ratio.',
    }
)


class ContinuousAxes(Record):
    """Time, rotations and sliding distance that restart at each step, segment or file become continuous."""

    step: Literal["continuous-axes"] = "continuous-axes"
    """Name of the step."""
    carried_over: Literal["auto", "always", "never"] = "auto"
    """Whether a nonzero start, carried over from the previous test, is subtracted: if another axis or the large
    value indicates it ("told"), always, or never."""


class SignalLimits(Record):
    """Range of plausible values of a signal."""

    lowest: Annotated[Quantity | None, _Written] = None
    """Lower limit; values below it are masked."""
    highest: Annotated[Quantity | None, _Written] = None
    """Upper limit; values above it are masked."""

    @model_validator(mode="after")
    def _something_lies_between(self) -> Self:
        low, high = self.lowest, self.highest
        if low is not None and high is not None and not low.value < high.value:
            raise ValueError(
                f"lowest: found {low}, not less than highest ({high}); expected a lower value; swap the two"
            )
        return self


def _limits_of_signals(written: Any) -> Any:
    """Read limits with the unit that each signal has; unknown signals are left to be refused by name."""
    if not isinstance(written, Mapping):
        return written
    return {
        name: {
            end: read_quantity(value, SIGNALS[name].kind)
            if end in SignalLimits.model_fields and value is not None
            else value
            for end, value in limits.items()
        }
        if name in SIGNALS and isinstance(limits, Mapping)
        else limits
        for name, limits in written.items()
    }


class Mask(Record):
    """Impossible values, error codes and values beyond limits are marked as missing."""

    step: Literal["mask"] = "mask"
    """Name of the step."""
    impossible: bool = True
    """Whether physically impossible values, repeated error codes and dead load channels are masked."""
    limits: Annotated[dict[SignalName, SignalLimits], BeforeValidator(_limits_of_signals)] = Field(default_factory=dict)
    """Lowest and highest plausible value of each signal."""


class TimeWindow(Record):
    """A part of the run."""

    start: Instant
    """Time of its first sample."""
    end: Instant
    """Time of its last sample."""

    @model_validator(mode="after")
    def _start_comes_first(self) -> Self:
        if not self.start.value < self.end.value:
            raise ValueError(
                f"start: found {self.start}, not before end ({self.end}); expected an earlier start; correct one of "
                "the two"
            )
        return self


class Zero(Record):
    """The mean value measured without contact is subtracted from force signals."""

    step: Literal["zero"] = "zero"
    """Name of the step."""
    windows: tuple[TimeWindow, ...] = ()
    """Times without contact; default: start and end of the run, if the measured load shows no contact there."""
    signals: tuple[Literal["normal_force", "friction_force"], ...] = ("normal_force", "friction_force")
    """Signals to zero."""


class PressingLoad(Record):
    """The sign of a normal force that is negative under load is inverted."""

    step: Literal["pressing-load"] = "pressing-load"
    """Name of the step."""


class FrictionSign(Record):
    """The sign of negative friction in a unidirectional test is inverted."""

    step: Literal["friction-sign"] = "friction-sign"
    """Name of the step."""


class Idle(Record):
    """Depth is masked at the ends where nothing slides under full load; a nominal distance does not increase there."""

    step: Literal["idle"] = "idle"
    """Name of the step."""


class UnloadedFriction(Record):
    """The friction coefficient is masked where the load is close to zero, since it contains only noise there."""

    step: Literal["unloaded-friction"] = "unloaded-friction"
    """Name of the step."""
    share: float = Field(default=0.05, ge=0, lt=0.5)
    """Fraction of the nominal load below which the measured load counts as zero."""


class StrokeWiseFriction(Record):
    """One friction coefficient for each stroke of a reciprocating test; the turning points are masked."""

    step: Literal["stroke-wise-friction"] = "stroke-wise-friction"
    """Name of the step."""
    method: StrokeMethod = "middle-of-stroke"
    """Mean of |μ| over the middle of a stroke, or half the difference between forward and backward stroke, which is
    independent of an offset of the sensor."""
    middle: float = Field(default=0.5, gt=0, le=1)
    """Fraction of a stroke that is used as its middle part."""
    only_with_stroke: bool = True
    """Whether only runs with conditions.stroke are changed, or all runs in which friction changes sign regularly."""


class Invert(Record):
    """Signals of opposite sign are multiplied by −1."""

    step: Literal["invert"] = "invert"
    """Name of the step."""
    signals: tuple[TurnedSignal, ...]
    """Measured signals whose sign is inverted."""

    @model_validator(mode="after")
    def _something_is_turned(self) -> Self:
        if not self.signals:
            raise ValueError(
                'signals: found no signals; expected at least one signal, such as "depth"; add a signal, or remove the '
                "step"
            )
        return self


class Despike(Record):
    """Single samples far from the median of their neighbors are masked (Hampel identifier)."""

    step: Literal["despike"] = "despike"
    """Name of the step."""
    signals: tuple[SignalName, ...] = ("normal_force", "friction_force", "friction_coefficient", "depth")
    """Measured signals to despike."""
    window: int = Field(default=11, ge=3, le=1001)
    """Number of samples over which the median is taken, odd."""
    threshold: float = Field(default=6.0, gt=0)
    """Threshold in standard deviations, estimated from the median absolute deviation."""

    @model_validator(mode="after")
    def _window_has_a_middle(self) -> Self:
        if self.window % 2 == 0:
            raise ValueError(f"window: found {self.window}; expected an odd number of samples; add 1")
        return self


CleaningStep = Annotated[
    ContinuousAxes
    | Mask
    | Zero
    | PressingLoad
    | FrictionSign
    | Idle
    | UnloadedFriction
    | StrokeWiseFriction
    | Invert
    | Despike,
    Field(discriminator="step"),
]
CleaningStepName = Literal[
    "continuous-axes",
    "mask",
    "zero",
    "pressing-load",
    "friction-sign",
    "idle",
    "unloaded-friction",
    "stroke-wise-friction",
    "invert",
    "despike",
]
AUTOMATIC: tuple[CleaningStep, ...] = (
    ContinuousAxes(),
    Mask(),
    Zero(),
    PressingLoad(),
    FrictionSign(),
    Idle(),
    UnloadedFriction(),
    StrokeWiseFriction(),
)
"""Steps taken unless a recipe states otherwise: each does nothing where there is nothing to do."""


class Change(Record):
    """Effect of one step on one signal."""

    step: CleaningStepName
    """The step."""
    signal: SignalName
    """The signal."""
    samples: int
    """Number of changed samples."""
    what: str
    """Description of the change."""
    why: str
    """Reason for the change."""
    offset: Quantity | None = None
    """Value that was subtracted, with its standard uncertainty if known."""
    factor: float | None = None
    """Factor by which the signal was multiplied."""
    parts: int | None = None
    """Number of segments joined, or of strokes averaged."""

    def __str__(self) -> str:
        return f"{self.signal}: {self.what} ({self.why})"


class CleanUp(Record):
    """Preprocessing of a run's signals before the evaluation; raw signals are kept unchanged."""

    changes: tuple[Change, ...] = ()
    """All changes, in order."""
    derived: dict[SignalName, str] = Field(default_factory=dict)
    """Columns that changed because they are derived from changed columns, and those from which they are derived."""
    left_out: tuple[SignalName, ...] = ()
    """Signals without valid samples, without which the run is processed."""

    def changed(self, signal: SignalName) -> bool:
        """Return whether a signal came out otherwise than it was recorded."""
        return signal in self.derived or any(change.signal == signal and change.samples for change in self.changes)

    def __str__(self) -> str:
        if not self.changes:
            return "preprocessing: nothing to do"
        return f"preprocessing: {'; '.join(str(change) for change in self.changes)}"
