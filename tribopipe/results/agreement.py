"""What a study finds, of any contact: k_D of several runs, predictions with their bands, how far the law holds."""

from collections import Counter
from collections.abc import Mapping
from typing import Literal

from pydantic import Field

from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import Correction, LawName
from tribopipe.documents.record import Record
from tribopipe.physics.conventions import DistanceConvention, WearEngine
from tribopipe.results.finding import Finding

Verdict = Literal["supported", "over-predicts", "under-predicts", "not decidable"]
AGREEMENT: Mapping[str, str] = {
    "supported": "consistent",
    "over-predicts": "over-predicted",
    "under-predicts": "under-predicted",
    "not decidable": "inconclusive",
}
"""How people read a result: the agreement of the measured wear with the model."""
Role = Literal["fitted", "predicted"]
WornQuantity = Literal["wear_volume", "wear_depth", "track_width"]
Interval = tuple[Quantity, Quantity]


class Trend(Record):
    """What is left of a run's residuals once k_D, zero offset and drift have taken theirs."""

    p_value: float
    """Probability of as much trend in noise alone (χ² with two degrees of freedom)."""
    amplitude: Quantity
    """Root mean square of the trend over the run, m."""


class Exponent(Record):
    """n of h ∝ sⁿ over the last three quarters of the distance; by the law ½ for a sphere far from its start."""

    measured: Quantity
    """By regression of ln h on ln s over the measured curve."""
    by_law: float
    """The same regression on the law's own curve."""


class ChangePoint(Record):
    """Where the wear rate leaves the law, if it does: one k_D before and another one after."""

    sliding_distance: Quantity
    """Most likely place."""
    rate_ratio: float
    """k_D after over k_D before."""
    p_value: float
    """Probability of so much gain by a change anywhere, in noise alone."""


class LawComparison(Record):
    """Archard's law against Sarkar's on the shape of one run, drift and k_D free (H. Akaike, 1974)."""

    delta_aic: float
    """AIC of Sarkar's law minus that of Archard's: above zero for Archard's."""
    preferred: LawName | None
    """The law that is better by more than 2; none where the data do not give it."""


class EngineComparison(Record):
    """k_D of one run by even and by local pressure, from the same data."""

    giwm: Quantity
    """By the Global Incremental Wear Model, which assumes uniform pressure over the contact."""
    local: Quantity
    """By the pressure at each point."""
    trusted: WearEngine | None
    """The local one where the two differ by more than their standard uncertainty; none where they do not."""


class EndOfLife(Record):
    """Where along a test the first body reaches a wear depth."""

    wear_depth: Quantity
    """The depth."""
    place: Quantity
    """Median of the draws: a sliding distance, or rotations."""
    interval: tuple[Quantity, Quantity | None]
    """95 % coverage interval; open above where k_D may be too small to get there."""


class BodyVerdict(Record):
    """The law against the wear of one body in a run."""

    outcome: Verdict
    """What the data show about the law for this body."""
    what: WornQuantity
    """What was measured at the end, by which the law is judged first."""
    measured: Quantity
    """As measured."""
    predicted: Quantity
    """By the law."""
    predicted_interval: Interval
    """95 % coverage interval of it."""
    measurement_interval: Interval
    """Where 95 % of measurements of it would lie."""
    e_n: float
    """Measured minus predicted at the end over the half width of its 95 % interval on that side."""
    e_n_all: float
    """The largest such number among all that was measured on the body, over the limit that 95 % of runs keep to."""
    e_n_all_at: str | Quantity
    """Which measurement it belongs to, or where along the curve."""
    wear_coefficient: Quantity
    """k_D of this run alone."""
    coefficient_ratio: Quantity
    """k_D of this run alone over the study's."""
    trend: Trend | None = None
    """Residual trend of the law fitted to this run alone; none without a curve, as the three below."""
    exponent: Exponent | None = None
    """Local exponent of h(s)."""
    change_point: ChangePoint | None = None
    """Where the wear rate would leave the law."""
    engines: EngineComparison | None = None
    """k_D by even and by local pressure, of a run with a spherical pin that identified k_D."""


class RunVerdict(Record):
    """The law against one run."""

    id: str
    """The run."""
    role: Role
    """Whether the run identified k_D or was predicted."""
    normal_load: Quantity
    """Nominal load."""
    slip: Quantity | None = None
    """Nominal slip; none of bodies that do not roll."""
    end: Quantity
    """End of the run: its sliding distance, or rotations."""
    outcome: Verdict
    """What the data show about the law for this run: that of the body that departs most."""
    sentence: str
    """The same in words."""
    notes: tuple[str, ...] = ()
    """What to beware of, such as an extrapolation."""
    findings: tuple[Finding, ...] = ()
    """What speaks against the curve of the run."""
    bodies: dict[str, BodyVerdict]
    """One for each body on which something was measured."""
    end_of_life: EndOfLife | None = None
    """Where the run reaches the wanted depth; none where its k_D is rather zero, or no depth is wanted."""

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
    """Root mean square of the runs' own relative standard uncertainties, shared errors left out."""
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
    """Scatter between runs; none where one run identifies k_D."""


class LawResult(Record):
    """One wear law in a study."""

    model: LawName
    """Wear law."""
    engine: WearEngine = "giwm"
    """Pressure that k_D was found by: even, as the Global Incremental Wear Model has it, or local."""
    distance_per_rotation: DistanceConvention | None = None
    """What counts as sliding distance in one rotation; none of bodies that do not roll."""
    bodies: dict[str, StudiedBody]
    """k_D of each body, the one that is always found first; a body that is left out counts as unworn."""
    correlation: float | None = None
    """Of both k_D."""
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
    """What a study found."""

    id: str
    """The study."""
    title: str | None = None
    """One line about it."""
    tribometer: str
    """Type of tribometer."""
    correction: Correction | None = None
    """Whether drift was subtracted first or fitted together with k_D; none where no depth signal is fitted."""
    laws: tuple[LawResult, ...]
    """One result for each wear law."""
    comparisons: dict[str, LawComparison] = Field(default_factory=dict)
    """Archard's law against Sarkar's, by run."""
    left_out: tuple[LeftOut, ...] = ()
    """Runs that were not used, and why."""
    notes: tuple[str, ...] = ()
    """What to beware of."""

    def law(self, model: LawName) -> LawResult:
        """Return the result of one law. Raises ``KeyError`` where the study has none."""
        return {result.model: result for result in self.laws}[model]
