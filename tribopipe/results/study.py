"""What a study finds, of any contact: k_D of several runs, predictions with their bands, how far the law holds.

Next to the records are the curves behind them, and what a further test would buy: which uncertainty to reduce, how far
to slide, how often to repeat.
"""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from pydantic import Field

from tribopipe.base.arrays import Column
from tribopipe.base.units import WEAR_COEFFICIENT
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import Correction, LawName
from tribopipe.documents.record import Record
from tribopipe.documents.signals import SignalName
from tribopipe.physics.calculation_methods import DistanceConvention, WearEngine
from tribopipe.results.finding import Finding
from tribopipe.results.input_quantities import input_label

Verdict = Literal["supported", "over-predicts", "under-predicts", "not decidable"]
AGREEMENT: Mapping[str, str] = {
    "supported": "consistent",
    "over-predicts": "over-predicted",
    "under-predicts": "under-predicted",
    "not decidable": "inconclusive",
}
"""Agreement of the measured wear with the model, as shown to readers."""
Role = Literal["fitted", "predicted"]
WornQuantity = Literal["wear_volume", "wear_depth", "track_width"]
Interval = tuple[Quantity, Quantity]


class Trend(Record):
    """Residuals of a run after the fit of k_D, zero offset and drift."""

    p_value: float
    """Probability of as much trend in noise alone (χ² with two degrees of freedom)."""
    amplitude: Quantity
    """Root mean square of the trend over the run, m."""


class Exponent(Record):
    """n of h ∝ sⁿ over the last three quarters of the distance; by the law ½ for a sphere far from its start."""

    measured: Quantity
    """Exponent from regression of ln h on ln s over the measured curve."""
    by_law: float
    """The same regression on the law's own curve."""


class ChangePoint(Record):
    """Change of the wear rate during the test: one k_D before and another one after."""

    sliding_distance: Quantity
    """Most likely place."""
    rate_ratio: float
    """k_D after over k_D before."""
    p_value: float
    """Probability of so much gain by a change anywhere, in noise alone."""


class LawComparison(Record):
    """Laws compared on the shape of one run; drift, k_D and their own parameters are free (H. Akaike, 1974)."""

    delta_aic: dict[LawName, float]
    """AIC of each law minus the lowest; without laws whose parameters the run does not determine."""
    preferred: LawName | None
    """The law with the lowest AIC, if all others are higher by at least 2, or by 10 if measured friction is used."""


class EngineComparison(Record):
    """k_D of one run with uniform and with local contact pressure, from the same data."""

    giwm: Quantity
    """Wear from the Global Incremental Wear Model, with uniform contact pressure."""
    local: Quantity
    """Wear from the local contact pressure."""
    trusted: WearEngine | None
    """The local one if the two differ by more than their standard uncertainty; otherwise None."""


class EndOfLife(Record):
    """Position in a test at which the first body reaches a wear depth."""

    wear_depth: Quantity
    """The depth."""
    place: Quantity
    """Median of the draws: a sliding distance, or rotations."""
    interval: tuple[Quantity, Quantity | None]
    """95 % coverage interval; open above where k_D may be too small to get there."""


class BodyVerdict(Record):
    """The law against the wear of one body in a run."""

    outcome: Verdict
    """Agreement with the law for this body."""
    what: WornQuantity
    """Measurement at the end, on which the agreement is based first."""
    measured: Quantity
    """As measured."""
    predicted: Quantity
    """Predicted value."""
    predicted_interval: Interval
    """95 % coverage interval of the predicted value."""
    measurement_interval: Interval
    """95 % prediction interval of a measurement."""
    e_n: float
    """Measured minus predicted at the end divided by the half-width of its 95 % interval on that side."""
    e_n_all: float
    """The largest such number among all that was measured on the body, over the limit that 95 % of runs keep to.

    Along a curve, the limit is at least the standard uncertainty of the measured wear.
    """
    e_n_all_at: str | Quantity
    """Which measurement it belongs to, or where along the curve."""
    wear_coefficient: Quantity
    """k_D of this run alone."""
    coefficient_ratio: Quantity
    """k_D of this run alone over the study's."""
    trend: Trend | None = None
    """Residual trend of the law fitted to this run alone. This and the next three keys require a curve."""
    exponent: Exponent | None = None
    """Local exponent of h(s)."""
    change_point: ChangePoint | None = None
    """Possible position of a change of the wear rate."""
    engines: EngineComparison | None = None
    """k_D with uniform and with local contact pressure, of a run with a spherical pin that identified k_D."""


class RunVerdict(Record):
    """The law against one run."""

    id: str
    """The run."""
    role: Role
    """Whether the run identified k_D or was predicted."""
    normal_load: Quantity
    """Nominal load."""
    slip: Quantity | None = None
    """Nominal slip; only for rolling bodies."""
    end: Quantity
    """End of the run: its sliding distance, or rotations."""
    outcome: Verdict
    """Agreement with the law for this run: that of the body with the largest deviation."""
    sentence: str
    """The same in words."""
    notes: tuple[str, ...] = ()
    """Notes and warnings, such as an extrapolation."""
    findings: tuple[Finding, ...] = ()
    """Findings against the curve of the run."""
    bodies: dict[str, BodyVerdict]
    """One for each body on which something was measured."""
    end_of_life: EndOfLife | None = None
    """Position at which the run reaches the wanted depth; None if k_D may be zero, or no depth is wanted."""

    @property
    def first(self) -> BodyVerdict:
        """The body that is judged in every run."""
        return next(iter(self.bodies.values()))


class BetweenRuns(Record):
    """Scatter between runs of one condition, or of several under one law (Paule and Mandel's estimate)."""

    runs: int
    """Number of runs."""
    scatter: float
    """Standard deviation of k_D between runs over k_D, beyond what each run's own uncertainty explains."""
    within: float
    """Root mean square of the runs' own relative standard uncertainties, without shared errors."""
    p_value: float
    """Probability of as much disagreement between runs that share one k_D (Cochran's Q)."""
    weights: tuple[float, ...]
    """Weight of each run in k_D."""
    outliers: tuple[str, ...] = ()
    """Runs that disagree with all others; still counted, until `tribopipe mark-bad` takes them out."""


class StudiedBody(Record):
    """k_D of one body by a study."""

    wear_coefficient: Quantity
    """k_D with its standard uncertainty."""
    interval: Interval
    """95 % coverage interval."""
    between_runs: BetweenRuns | None = None
    """Scatter between runs; None if one run identifies k_D."""


class PressureExponent(Record):
    """m of a wear rate proportional to p^m; a law whose k_D does not depend on pressure has m = 1."""

    exponent: Quantity
    """m with its standard uncertainty, from the k_D that each run has by itself."""
    interval: Interval
    """95 % confidence interval."""
    runs: int
    """Number of runs."""
    scatter: float
    """Standard deviation of ln k between runs, beyond what their own uncertainties and m explain."""


class LawResult(Record):
    """One wear law in a study."""

    model: LawName
    """Wear law."""
    engine: WearEngine = "giwm"
    """Pressure that k_D was found by: even, as the Global Incremental Wear Model has it, or local."""
    distance_per_rotation: DistanceConvention | None = None
    """Convention for the sliding distance in one rotation; None for bodies that do not roll."""
    bodies: dict[str, StudiedBody]
    """k_D of each body, first the one that is always fitted; other bodies count as unworn."""
    correlation: float | None = None
    """Correlation of both k_D."""
    pressure_exponent: PressureExponent | None = None
    """How the wear rate of the first body depends on pressure; None for fewer than four runs or only one load."""
    draws: int
    """Number of accepted draws."""
    rejected: int
    """Number of draws without a solution."""
    runs: tuple[RunVerdict, ...]
    """One result for each run."""

    @property
    def first(self) -> StudiedBody:
        """The body whose k_D every study finds."""
        return next(iter(self.bodies.values()))

    @property
    def outliers(self) -> tuple[str, ...]:
        """The fitted runs that disagree with all others in k_D of a body."""
        found = (body.between_runs.outliers for body in self.bodies.values() if body.between_runs is not None)
        return tuple(dict.fromkeys(run_id for one in found for run_id in one))


def tally(law: LawResult) -> str:
    """Count how predicted runs agree with a law: "2 consistent, 1 over-predicted"; nothing where none was predicted."""
    outcomes = Counter(verdict.outcome for verdict in law.runs if verdict.role == "predicted")
    return ", ".join(f"{number} {AGREEMENT[outcome]}" for outcome, number in outcomes.items())


class LeftOut(Record):
    """A run of the study that was not used."""

    id: str
    """The run."""
    reason: str
    """Why."""


class StudyResult(Record):
    """Results of a study."""

    id: str
    """The study."""
    title: str | None = None
    """One line about it."""
    tribometer: str
    """Type of tribometer."""
    correction: Correction | None = None
    """Whether drift was subtracted first or fitted together with k_D; None if no depth signal is fitted."""
    laws: tuple[LawResult, ...]
    """One result for each wear law."""
    comparisons: dict[str, LawComparison] = Field(default_factory=dict)
    """The laws of the study compared with each other, by run."""
    left_out: tuple[LeftOut, ...] = ()
    """Runs that were not used, and why."""
    notes: tuple[str, ...] = ()
    """Notes and warnings."""

    def law(self, model: LawName) -> LawResult:
        """Return the result of one law. Raises ``KeyError`` where the study has none."""
        return {result.model: result for result in self.laws}[model]


CurveQuantity = Literal["wear_depth", "wear_volume"]


@dataclass(frozen=True)
class MeasuredCurve:
    """Wear as measured at the places of a curve, with its 95 % band."""

    best: Column
    lower: Column
    upper: Column


@dataclass(frozen=True)
class StudyCurve:
    """Wear of one body by a law along one run, with its 95 % band."""

    run_id: str
    model: LawName
    role: Role
    body: str
    what: CurveQuantity
    """Depth, m, or volume, m³."""
    along: SignalName
    """Quantity in which the positions are given."""
    places: Column
    predicted: Column
    lower: Column
    upper: Column
    measured: MeasuredCurve | None = None
    """None where wear was not recorded along the run."""


@dataclass(frozen=True)
class Evaluation:
    """A study's result and the curves behind it."""

    result: StudyResult
    curves: tuple[StudyCurve, ...]


SCATTER = "scatter between runs"


class Lever(Record):
    """One input of k_D, or the scatter between runs, and what it costs."""

    name: str
    """Input."""
    value: Quantity | None = None
    """Value and standard uncertainty; None for the noise of the depth signal and for the scatter."""
    shown_in: str | None = None
    """Unit in which people read it."""
    relative: float
    """Standard uncertainty of k_D from this input alone, over k_D."""
    share: float
    """Contribution to the variance of k_D."""
    if_halved: float
    """Half width of the 95 % interval of k_D over k_D, were this input twice as well known."""


class Design(Record):
    """Tests needed for a wanted interval of k_D, by first-order propagation."""

    id: str
    """Run that is planned from."""
    model: LawName
    """Wear law."""
    of: str = "k_D"
    """Body, if there are two k_D."""
    wear_coefficient: Quantity
    """k_D by this run, with its standard uncertainty without the scatter between runs."""
    half_width: float | None = None
    """Half width of the 95 % interval of k_D over k_D by one such test, with scatter; None if k_D may be zero."""
    wanted: float
    """The same as wanted."""
    levers: tuple[Lever, ...] = ()
    """Inputs, the most rewarding first."""
    sliding_distance: Quantity | None = None
    """Sliding distance of one test that would be sufficient; None if no distance is."""
    rotations: Quantity | None = None
    """Rotations of one test of two discs that would be sufficient; None if no number is, or for a pin."""
    by_distance: float | None = None
    """Half-width that no longer test can improve on."""
    replicates: int | None = None
    """Number of tests like this one whose mean k_D would be sufficient; None if no number is."""
    by_replicates: float | None = None
    """Half-width that no number of replicates can improve on, from the uncertainties that all runs share."""
    scatter: float | None = None
    """Scatter of k_D between runs over k_D that was counted with; None if it is unknown."""

    def __str__(self) -> str:
        if self.half_width is None:
            return (
                f"{self.id}, {self.model}: found {self.of} = {self.wear_coefficient.shown(WEAR_COEFFICIENT)}, where ± "
                "is one standard uncertainty; expected a 95 % interval above zero, since the target is relative to "
                "k_D; run a longer test, use a higher load, or measure the wear more accurately"
            )
        best = self.levers[0]
        label, halved = input_label(best.name), "it" if best.name == SCATTER else "its uncertainty"
        one = "" if self.scatter is None else " from one test, including the scatter between runs,"
        lines = [
            f"{self.id}, {self.model}: half-width of the 95 % interval for {self.of}{one} is "
            f"{_percent(self.half_width)}, target {_percent(self.wanted)}",
            f"  largest contribution: {label}, {100 * best.share:.0f} % of the variance; halving {halved} would "
            f"reduce the half-width to {_percent(best.if_halved)}",
        ]
        if self.half_width <= self.wanted:
            return "\n".join([*lines, "  no further test is needed"])
        if self.sliding_distance is not None:
            lines.append(f"  one test of {self.sliding_distance.value:,.0f} m would be sufficient")
        elif self.rotations is not None:
            lines.append(f"  one test of {self.rotations.value:,.0f} rotations would be sufficient")
        else:
            lines.append(f"  a longer test is not sufficient: at best {_percent(self.by_distance)}")
        if self.replicates is not None:
            lines.append(f"  the mean of {self.replicates} tests like this one would be sufficient")
        else:
            lines.append(f"  replicates are not sufficient: at best {_percent(self.by_replicates)}")
        if self.scatter is None:
            lines.append("  the scatter between runs is unknown and not included: more replicates may be needed")
        return "\n".join(lines)


def _percent(share: float | None) -> str:
    return "undefined" if share is None else f"{100 * share:.1f} %"
