"""What a study finds: k_D of several runs, predictions with their bands, and how far the law holds."""

from typing import Literal

from pydantic import Field

from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import Correction, LawName
from tribopipe.documents.record import Record
from tribopipe.physics.conventions import WearEngine
from tribopipe.results.finding import Finding

Verdict = Literal["supported", "over-predicts", "under-predicts", "not decidable"]
Role = Literal["fitted", "predicted"]
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
    """The law that is better by more than 2; none where the data do not tell."""


class EngineComparison(Record):
    """k_D of one run by even and by local pressure, from the same data."""

    giwm: Quantity
    """By the Global Incremental Wear Model, which spreads the load evenly over the contact."""
    local: Quantity
    """By the pressure at each point."""
    trusted: WearEngine | None
    """The local one where the two differ by more than their standard uncertainty; none where they do not."""


class EndOfLife(Record):
    """Sliding distance at which a run reaches a wear depth."""

    wear_depth: Quantity
    """The depth."""
    sliding_distance: Quantity
    """Median of the draws."""
    interval: tuple[Quantity, Quantity | None]
    """95 % coverage interval; open above where k_D may be too small to get there."""


class RunVerdict(Record):
    """The law against one run."""

    id: str
    """The run."""
    role: Role
    """Whether the run identified k_D or was predicted."""
    normal_load: Quantity
    """Nominal load."""
    outcome: Verdict
    """What the data say of the law for this run."""
    sentence: str
    """The same in words."""
    notes: tuple[str, ...] = ()
    """What to beware of, such as an extrapolation."""
    sliding_distance: Quantity
    """End of the run."""
    measured_depth: Quantity
    """Pin wear depth at the end as measured."""
    predicted_depth: Quantity
    """Pin wear depth at the end by the law."""
    predicted_interval: Interval
    """95 % coverage interval of it."""
    measurement_interval: Interval
    """Where 95 % of measurements of it would lie."""
    e_n: float
    """Measured minus predicted depth at the end over the half width of its 95 % interval on that side."""
    e_n_curve: float
    """The largest such number along the curve, over the limit that 95 % of curves keep to anywhere."""
    e_n_curve_at: Quantity
    """Where it is largest."""
    wear_coefficient: Quantity
    """k_D of this run alone."""
    coefficient_ratio: Quantity
    """k_D of this run alone over the study's."""
    trend: Trend | None = None
    """Residual trend of the law fitted to this run alone."""
    exponent: Exponent | None = None
    """Local exponent of h(s)."""
    change_point: ChangePoint | None = None
    """Where the wear rate would leave the law."""
    engines: EngineComparison | None = None
    """k_D by even and by local pressure, of a run with a spherical pin that identified k_D."""
    findings: tuple[Finding, ...] = ()
    """What speaks against the curve of the run."""
    end_of_life: EndOfLife | None = None
    """Where the run reaches the wanted depth; none where its k_D is rather zero, or no depth is wanted."""


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


class LawResult(Record):
    """One wear law in a study."""

    model: LawName
    """Wear law."""
    engine: WearEngine = "giwm"
    """Pressure on the pin: even, as the Global Incremental Wear Model has it, or local."""
    wear_coefficient: Quantity
    """k_D with its standard uncertainty."""
    interval: Interval
    """95 % coverage interval."""
    draws: int
    """Number of accepted draws."""
    rejected: int
    """Number of draws without a solution."""
    between_runs: BetweenRuns | None = None
    """Scatter between runs; none where one run identifies k_D."""
    runs: tuple[RunVerdict, ...]
    """One verdict for each run."""


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
    correction: Correction
    """Whether drift was taken off first or fitted together with k_D."""
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
