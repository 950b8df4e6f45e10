"""Results of each stage: values with their uncertainty, and the reasons for missing results."""

from typing import Literal

from tribopipe.documents.preprocessing import StrokeMethod
from tribopipe.documents.quantity import (
    Metres,
    MetresPerSecond,
    Number,
    Seconds,
    in_unit,
)
from tribopipe.documents.recipe import Correction
from tribopipe.documents.record import Record
from tribopipe.results.finding import Finding
from tribopipe.results.interactive import FitRecord
from tribopipe.results.specific_wear import measured_quantities

COVERAGE_FACTOR = 1.959963984540054
"""Half width of a 95 % interval in standard uncertainties of a normal distribution."""


class DepthModel(Record):
    """Contributions to the depth signal other than wear, fitted with the post-test measurement in one model."""

    zero_offsets: tuple[Metres, ...]
    """Sensor reading at the start of sliding, and after each remounting or step minus the drift up to then."""
    drift_rate: MetresPerSecond
    """Drift rate of the sensor: slope of the linear drift against time."""
    drift_interval: tuple[MetresPerSecond, MetresPerSecond]
    """95 % interval of the drift rate, not normally distributed, averaged over settling, temperature and wander."""
    settling_probability: float
    """Probability that the reading settles exponentially, a·(1 − exp(−t/τ))."""
    settling: Metres
    """Amplitude a, averaged over the models with and without settling (a = 0)."""
    settling_time: Seconds | None = None
    """Time constant τ; None if settling is improbable."""
    thermal_probability: float | None = None
    """Probability that the depth signal changes with the recorded temperature; None if this is missing or constant."""
    thermal_shift: Metres | None = None
    """Change of the depth signal over the range of the recorded temperature."""
    wander: Metres
    """Root mean square of what is slow and is neither wear by the law, nor drift, nor settling."""
    noise: Metres
    """Standard deviation of the noise of a block average."""
    blocks: int
    """Number of block averages."""
    end_depth: Metres
    """Wear depth at the end by depth reading and post-test measurement together."""
    end_depth_by_reading: Metres
    """Wear depth at the end by the depth reading alone."""
    evidence: float
    """ln of the odds that the reading is more than wear by the law, a line and noise."""


class DriftCorrection(Record):
    """The drift subtracted from a depth reading, anchored on the post-test measurement."""

    outcome: Literal["corrected", "uncorrected"]
    """Uncorrected if the depth signal, or the post-test measurement that separates drift from wear, is missing."""
    missing: tuple[str, ...] = ()
    """Missing inputs of the correction."""
    anchor: str | None = None
    """Which post-test measurements the end of the curve was matched to; None if the sensor alone gives the wear."""
    correction: Correction = "two-step"
    """Method of the drift correction."""
    zero_offset: Metres | None = None
    """Sensor reading at the start of sliding."""
    drift_rate: MetresPerSecond | None = None
    """Drift rate of the sensor: slope of the linear drift against time."""
    two_step_rate: MetresPerSecond | None = None
    """The drift rate by two-step correction, as in the paper; None if nothing was measured after the test."""
    model: DepthModel | None = None
    """Fitted contributions to the depth signal other than wear; not available with two-step correction."""
    discrepancy: Metres | None = None
    """Wear read by the sensor at the end, minus the post-test measurement."""
    end_wear_depth: Metres | None = None
    """Wear of pin and disc at the end, to which the curve is anchored."""
    pin_wear_depth: Metres | None = None
    """The pin's part of it."""
    disc_wear_depth: Metres | None = None
    """Contribution of the disc, if measured or shown by the depth signal."""
    approach: Metres | None = None
    """Wear of pin and disc by the depth signal, if the pin alone was measured and the signal shows a groove."""
    findings: tuple[Finding, ...] = ()
    """Findings against the depth signal of two discs; for a pin, see its fits."""

    def __str__(self) -> str:
        if self.outcome == "uncorrected":
            return f"no drift correction: missing {' and '.join(self.missing)}"
        rate = in_unit(self.drift_rate, "nm/min")
        if self.anchor is None:
            return f"drift {rate}, from the sensor alone: the wear of the pin was not measured"
        both = "" if self.model is None else f" (two-step {in_unit(self.two_step_rate, 'nm/min')})"
        return (
            f"drift {rate}{both}, discrepancy {in_unit(self.discrepancy, 'um')} against "
            f"the {measured_quantities(self.anchor)}, final wear depth {in_unit(self.end_wear_depth, 'um')}"
        )


class StrokeFriction(Record):
    """Friction coefficient of a reciprocating test by each definition in use, as means over its strokes."""

    used: StrokeMethod | None = None
    """The definition that the friction coefficient of this run is given by; None if it was not averaged per stroke."""
    half_difference: Number
    """Half the difference between forward and backward stroke over the middle of both, independent of an offset."""
    middle_of_stroke: Number
    """Mean of |μ| over the middle of the strokes."""
    loop_energy: Number
    """Friction work of a cycle over its load and length, (∮F dx)/(2·L·F_N), turning points included."""
    root_mean_square: Number
    """Square root of the mean of μ² over whole strokes."""
    peak: Number
    """Largest |μ| of a stroke: static friction, if it occurs at the turning points."""
    offset: Number
    """Half the sum of forward and backward stroke: offset of the force sensor, or tilt of the specimen."""

    @property
    def by_definition(self) -> dict[str, Number]:
        """Return the value of each definition by its name."""
        return {
            name.replace("_", "-"): getattr(self, name)
            for name in ("half_difference", "middle_of_stroke", "loop_energy", "root_mean_square", "peak")
        }


class FrictionFit(FitRecord):
    """μ(s) = A·exp(−s/c) + b (Eq. 7), or as much of it as the data hold."""

    outcome: Literal["exponential", "steady-only", "none"]
    """``steady-only`` if an exponential cannot be identified; ``none`` if friction was not recorded."""
    notes: tuple[str, ...] = ()
    """Why the outcome is what it is, and what to beware of."""
    amplitude: Number | None = None
    """A: friction coefficient at the start above the steady state."""
    steady_state: Number | None = None
    """b; the mean of the later half where the exponential was not identified."""
    running_in_distance: Metres | None = None
    """c: distance over which the start decays by a factor e."""
    covariance: tuple[tuple[float, ...], ...] | None = None
    """Covariance of (A, b, c): from noise, including its memory, load and sliding distance."""
    load_uncertainty: Number | None = None
    """Relative standard uncertainty of the load in that of A and b; None if the instrument gave μ itself."""
    distance_uncertainty: Number | None = None
    """Relative standard uncertainty of the sliding distance in that of c; None if the distance was recorded."""
    window: tuple[Metres, Metres] | None = None
    """Sliding distances between which friction was fitted."""
    residual_deviation: Number | None = None
    """Standard deviation of μ about the fit."""
    effective_samples: float | None = None
    """Number of independent samples the residuals amount to."""
    mean: Number | None = None
    """Mean of μ over the whole run, as vendor software prints it."""
    standard_deviation: Number | None = None
    """Standard deviation of μ over the whole run, as vendor software prints it."""
    load: Literal["measured", "nominal", "recorded"] | None = None
    """Divisor of the friction force; "recorded" if the instrument recorded μ itself."""
    strokes: StrokeFriction | None = None
    """Friction coefficient by each definition, if a signed force was recorded in a reciprocating test."""

    @property
    def noise_covariance(self) -> tuple[tuple[float, ...], ...] | None:
        """Covariance of (A, b, c) at a given load and distance: by the noise alone."""
        if self.covariance is None or self.amplitude is None or self.steady_state is None:
            return None
        load, distance = (
            0.0 if one is None else one.value for one in (self.load_uncertainty, self.distance_uncertainty)
        )
        levels = (load * self.amplitude.value, load * self.steady_state.value, 0.0)
        along = 0.0 if self.running_in_distance is None else distance * self.running_in_distance.value
        noise = [
            [both - one * other for both, other in zip(row, levels, strict=True)]
            for row, one in zip(self.covariance, levels, strict=True)
        ]
        noise[2][2] -= along**2
        return tuple(tuple(row) for row in noise)

    def __str__(self) -> str:
        if self.outcome == "none":
            return f"friction not fitted: {'; '.join(self.notes)}"
        if self.outcome == "steady-only":
            return f"μ = {self.steady_state} (steady-state value only: {'; '.join(self.notes)})"
        text = (
            f"μ(s) = A·exp(−s/c) + b with A = {self.amplitude}, b = {self.steady_state}, c = {self.running_in_distance}"
        )
        return text + (f" ({'; '.join(self.notes)})" if self.notes else "")
