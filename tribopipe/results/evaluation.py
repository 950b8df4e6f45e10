"""What each stage returns: numbers with their uncertainty, and in words what stood in the way."""

from typing import Literal

from tribopipe.base.units import WEAR_COEFFICIENT
from tribopipe.documents.quantity import (
    Metres,
    MetresPerSecond,
    Newtons,
    Number,
    Quantity,
    Seconds,
    SquareMetresPerNewton,
    between,
    force,
    in_both_units,
)
from tribopipe.documents.recipe import Correction, FrictionSource, LawName
from tribopipe.documents.record import Record
from tribopipe.physics.conventions import WearEngine
from tribopipe.results.finding import Finding

COVERAGE_FACTOR = 1.959963984540054
"""Half width of a 95 % interval in standard uncertainties of a normal distribution."""


class DepthModel(Record):
    """What a depth sensor reads besides wear, as one statistical model fitted with the post-test measurement."""

    zero_offsets: tuple[Metres, ...]
    """Sensor reading at the start of sliding, and after each remounting or step less what drift had added."""
    drift_rate: MetresPerSecond
    """Slope against time of what the sensor reads besides wear."""
    settling_probability: float
    """Probability that the reading settles exponentially, a·(1 − exp(−t/τ))."""
    settling: Metres
    """Amplitude a; it counts as 0 as far as there is no settling."""
    settling_time: Seconds | None = None
    """Time constant τ; none where settling is improbable."""
    thermal_probability: float | None = None
    """Probability that the reading follows the recorded temperature; none where that is missing or steady."""
    thermal_shift: Metres | None = None
    """By how much the reading moves over the range of the recorded temperature."""
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
    """Uncorrected where the run lacks the depth, or an end value without which drift cannot be told from wear."""
    lacks: tuple[str, ...] = ()
    """What the run lacks for a correction."""
    anchor: str | None = None
    """Which end values the end of the curve was matched to; none where the sensor alone tells the wear."""
    correction: Correction = "two-step"
    """How the drift was found."""
    zero_offset: Metres | None = None
    """Sensor reading at the start of sliding."""
    drift_rate: MetresPerSecond | None = None
    """Slope against time of what the sensor reads beside wear."""
    two_step_rate: MetresPerSecond | None = None
    """The drift rate by two-step correction, as in the paper; none where nothing was measured after the test."""
    model: DepthModel | None = None
    """Everything that the sensor reads besides wear; none of two-step correction."""
    discrepancy: Metres | None = None
    """Wear read by the sensor at the end, minus the end value."""
    end_wear_depth: Metres | None = None
    """Wear of pin and disc at the end: what the curve is anchored on."""
    pin_wear_depth: Metres | None = None
    """The pin's part of it."""
    disc_wear_depth: Metres | None = None
    """The disc's part of it, where it was measured."""
    findings: tuple[Finding, ...] = ()
    """What speaks against the reading of two discs; of a pin's its fits say it."""

    @property
    def pin_share(self) -> float:
        """Pin wear over total wear, by the end values."""
        if self.pin_wear_depth is None or self.end_wear_depth is None or not self.end_wear_depth.value:
            return 1.0
        return self.pin_wear_depth.value / self.end_wear_depth.value

    def __str__(self) -> str:
        if self.outcome == "uncorrected":
            return f"no drift correction: the run lacks {' and '.join(self.lacks)}"
        if self.anchor is None:
            return f"drift {_in(self.drift_rate, 'nm/min')}, by the sensor alone: no wear was measured after the test"
        both = "" if self.model is None else f" (two-step {_in(self.two_step_rate, 'nm/min')})"
        return (
            f"drift {_in(self.drift_rate, 'nm/min')}{both}, discrepancy {_in(self.discrepancy, 'um')} against "
            f"{self.anchor}, wear depth at the end {_in(self.end_wear_depth, 'um')}"
        )


class FrictionFit(Record):
    """μ(s) = A·exp(−s/c) + b (Eq. 7), or as much of it as the data hold."""

    outcome: Literal["exponential", "steady-only", "none"]
    """Steady-only where an exponential cannot be identified; none where friction was not recorded."""
    notes: tuple[str, ...] = ()
    """Why the outcome is what it is, and what to beware of."""
    amplitude: Number | None = None
    """A: friction coefficient at the start above the steady state."""
    steady_state: Number | None = None
    """b; the mean of the later half where the exponential was not identified."""
    running_in_distance: Metres | None = None
    """c: distance over which the start decays by a factor e."""
    covariance: tuple[tuple[float, ...], ...] | None = None
    """Of (A, b, c): by the noise, its memory included, by the load and by the sliding distance."""
    load_uncertainty: Number | None = None
    """Relative standard uncertainty of the load in that of A and b; none where the instrument gave μ itself."""
    distance_uncertainty: Number | None = None
    """Relative standard uncertainty of the sliding distance in that of c; none where the distance was recorded."""
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
    """What friction force was divided by; "recorded" where the instrument gave μ itself."""

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
            return f"no friction fit: {'; '.join(self.notes)}"
        if self.outcome == "steady-only":
            return f"μ = {self.steady_state} (steady value only: {'; '.join(self.notes)})"
        text = (
            f"μ(s) = A·exp(−s/c) + b with A = {self.amplitude}, b = {self.steady_state}, c = {self.running_in_distance}"
        )
        return text + (f" ({'; '.join(self.notes)})" if self.notes else "")


class Contribution(Record):
    """One line of an uncertainty budget (JCGM 100:2008, 5.1.2)."""

    name: str
    """Input quantity."""
    value: Quantity | None = None
    """Its value and standard uncertainty; none for the noise of the depth signal."""
    shown_in: str | None = None
    """Unit in which people read it."""
    source: Literal["manifest", "default", "fit", "recipe"]
    """Who stated the uncertainty: the lab in run.toml or a recipe, the recipe's default, or the data themselves."""
    relative: float
    """Standard uncertainty of k_D from this input alone, over k_D, with its sign."""


class MonteCarlo(Record):
    """Propagation of distributions (JCGM 101:2008)."""

    draws: int
    """Number of draws."""
    mean: SquareMetresPerNewton
    """Mean of the draws."""
    standard_uncertainty: SquareMetresPerNewton
    """Standard deviation of the draws."""
    stable: bool
    """Whether the digits asked for were stable when drawing ended (7.9.4)."""
    first_order_interval: tuple[SquareMetresPerNewton, SquareMetresPerNewton]
    """95 % interval of JCGM 100:2008, log-normal."""
    agrees_with_first_order: bool
    """Whether both ends agree with it within those digits (8.1)."""


Basis = Literal["reading and measurement", "measurement", "reading"]
"""What a wear coefficient is based on."""


class LawValue(Record):
    """A parameter of a wear law beside k_D."""

    name: str
    """Parameter."""
    value: Quantity
    """Its value; without uncertainty where the fit held it."""
    source: Literal["fit", "recipe"]
    """Whether it was fitted with k_D, or given."""

    def __str__(self) -> str:
        return f"{self.name.replace('_', ' ')} {self.value}"


class WearFit(Record):
    """Dimensional wear coefficient k_D of one run."""

    model: LawName
    """Wear law."""
    engine: WearEngine = "giwm"
    """Pressure that k_D was found by: even, as the Global Incremental Wear Model has it, or local."""
    outcome: Literal["fitted", "not fitted"]
    """Not fitted where the run lacks what the fit needs."""
    lacks: tuple[str, ...] = ()
    """What the run lacks for a fit."""
    notes: tuple[str, ...] = ()
    """What to beware of, the defaults used among it."""
    wear_coefficient: SquareMetresPerNewton | None = None
    """k_D with its combined standard uncertainty."""
    interval: tuple[SquareMetresPerNewton, SquareMetresPerNewton] | None = None
    """95 % coverage interval of k_D by Monte Carlo; to first order, log-normal, where none was drawn."""
    random_uncertainty: SquareMetresPerNewton | None = None
    """Standard uncertainty from the noise of the depth signal alone, by the least-squares covariance."""
    budget: tuple[Contribution, ...] = ()
    """What the combined standard uncertainty is made of, to first order."""
    monte_carlo: MonteCarlo | None = None
    """How the interval was drawn."""
    correction: Correction = "two-step"
    """How drift was found: with k_D in one model, or before it."""
    basis: Basis | None = None
    """What gives k_D: depth reading and post-test measurement together, or one of them; none of two-step correction."""
    by_reading: SquareMetresPerNewton | None = None
    """k_D by the depth reading alone."""
    by_measurement: SquareMetresPerNewton | None = None
    """k_D by the post-test measurement alone."""
    deviation: float | None = None
    """Wear at the end by the reading alone minus that by the measurement alone, over its standard uncertainty."""
    sensor: DepthModel | None = None
    """What the depth sensor reads besides wear under this law."""
    findings: tuple[Finding, ...] = ()
    """What speaks against the result."""
    parameters: tuple[LawValue, ...] | None = None
    """Parameters of the law beside k_D; none where it has none."""
    parameter_covariance: tuple[tuple[float, ...], ...] | None = None
    """Of ln k_D and the parameters that were fitted, in SI, to first order."""
    friction: FrictionSource | None = None
    """Which μ Sarkar's law was given."""
    measured_end_depth: Metres | None = None
    """Pin wear depth by the end value."""
    fitted_end_depth: Metres | None = None
    """Pin wear depth at the end by the fitted law."""
    residual_deviation: Metres | None = None
    """Standard deviation of the corrected pin wear about the fit; of block averages, except of two-step correction."""
    effective_samples: float | None = None
    """Number of independent samples the residuals amount to."""

    def __str__(self) -> str:
        if self.wear_coefficient is None or self.interval is None:
            return f"{self.model}: no wear coefficient: the run lacks {' and '.join(self.lacks)}"
        return (
            f"{self.model}{by(self.engine)}: k_D = {in_both_units(self.wear_coefficient)}, "
            f"95 % interval {between(self.interval, WEAR_COEFFICIENT)}{_with(self.parameters)}; pin wear at the end "
            f"{_in(self.fitted_end_depth, 'um')} fitted, {_in(self.measured_end_depth, 'um')} measured"
        )


class PredictedPoint(Record):
    """State of the pin at one sliding distance."""

    sliding_distance: Quantity
    """Where."""
    time: Quantity | None = None
    """When, at the sliding speed; none where the speed is not known."""
    wear_depth: Quantity
    """Height worn off the pin."""
    contact_radius: Quantity
    """Radius of the contact."""
    pressure: Quantity
    """Mean contact pressure p = F_N/(πa²)."""


class WearPrediction(Record):
    """Wear depth against sliding distance from a known k_D."""

    model: LawName
    """Wear law."""
    engine: WearEngine = "giwm"
    """Pressure on the pin: even, as the Global Incremental Wear Model has it, or local."""
    scheme: Literal["exact", "published"]
    """Closed form, or the paper's explicit Euler steps."""
    wear_coefficient: SquareMetresPerNewton
    """k_D used."""
    reference: str | None = None
    """Run that k_D was identified from; none where it was given."""
    normal_load: Newtons
    """F_N predicted for."""
    pin_radius: Metres
    """R_P predicted for."""
    steps: int | None = None
    """Number of Euler steps of the published scheme."""
    step_error: float | None = None
    """Relative error of the last depth by the finite step of the published scheme."""
    notes: tuple[str, ...] = ()
    """What to beware of."""
    prediction: tuple[PredictedPoint, ...] = ()
    """The wanted distances in the order asked for."""
    reached: tuple[PredictedPoint, ...] = ()
    """Where wanted depths are reached, in the order asked for."""
    parameters: tuple[LawValue, ...] | None = None
    """Parameters of the law beside k_D; none where it has none."""

    def __str__(self) -> str:
        lines = [
            f"{self.model}{by(self.engine)}, {self.scheme}: k_D = {self.wear_coefficient.shown(WEAR_COEFFICIENT)}, "
            f"F_N = {force(self.normal_load)}, R_P = {self.pin_radius.shown('mm')}"
        ]
        for point in (*self.prediction, *self.reached):
            when = "" if point.time is None else f" ({point.time.shown('s')})"
            lines.append(f"  {point.sliding_distance.shown('m')}{when}: {point.wear_depth.shown('um')}")
        return "\n".join([*lines, *(f"  {note}" for note in self.notes)])


def by(engine: WearEngine) -> str:
    """Say the engine that a k_D was found by, after its law; nothing of the GIWM."""
    return {"giwm": "", "volume": ", by volume", "local": ", local pressure"}[engine]


def _with(parameters: tuple[LawValue, ...] | None) -> str:
    """Say the parameters of a law after its k_D; nothing where it has none."""
    return f", {', '.join(map(str, parameters))}" if parameters else ""


def _in(quantity: Quantity | None, unit: str) -> str:
    return "unknown" if quantity is None else quantity.shown(unit)
