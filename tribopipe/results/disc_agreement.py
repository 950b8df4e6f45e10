"""What a study of twin-disc runs finds: k_D of both discs, predictions with their bands, and how far the law holds."""

from typing import Literal

from tribopipe.documents.contact import DiscName
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import LawName
from tribopipe.documents.record import Record
from tribopipe.physics.conventions import DistanceConvention
from tribopipe.results.agreement import BetweenRuns, Interval, LeftOut, Role, Verdict


class RotationsToDepth(Record):
    """Rotations after which a curved disc has worn by a depth."""

    wear_depth: Quantity
    """The depth."""
    rotations: Quantity
    """Median of the draws."""
    interval: tuple[Quantity, Quantity | None]
    """95 % coverage interval; open above where k_D may be too small to get there."""


class DiscVerdict(Record):
    """The law against one disc of a run."""

    disc: DiscName
    """Which disc."""
    outcome: Verdict
    """What the data say of the law for this disc."""
    what: Literal["wear_volume", "wear_depth", "track_width"]
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
    """Measured minus predicted over the half width of its 95 % interval on that side."""
    e_n_all: float
    """The largest such number among all that was measured on this disc, over the limit that 95 % of runs keep to."""
    e_n_all_at: str
    """What it belongs to."""
    wear_coefficient: Quantity
    """k_D of this run alone."""
    coefficient_ratio: Quantity
    """k_D of this run alone over the study's."""


class TwinDiscVerdict(Record):
    """The law against one run of two discs."""

    id: str
    """The run."""
    role: Role
    """Whether the run identified k_D or was predicted."""
    normal_load: Quantity
    """Nominal load."""
    slip: Quantity
    """Nominal slip."""
    rotations: Quantity
    """Rotations of the curved disc at the end."""
    outcome: Verdict
    """What the data say of the law for this run: that of the disc that departs most."""
    sentence: str
    """The same in words."""
    notes: tuple[str, ...] = ()
    """What to beware of."""
    discs: tuple[DiscVerdict, ...]
    """One for each disc on which something was measured."""
    end_of_life: RotationsToDepth | None = None
    """Where the curved disc reaches the wanted depth; none where no depth is wanted, or k_D is rather zero."""


class StudiedDisc(Record):
    """k_D of one disc by a study."""

    disc: DiscName
    """Which disc."""
    wear_coefficient: Quantity
    """k_D with its standard uncertainty."""
    interval: Interval
    """95 % coverage interval."""
    between_runs: BetweenRuns | None = None
    """Scatter between runs; none where one run identifies k_D."""


class TwinDiscLawResult(Record):
    """One wear law in a study of twin-disc runs."""

    model: LawName
    """Wear law."""
    distance_per_rotation: DistanceConvention
    """What counts as slid in one rotation."""
    discs: tuple[StudiedDisc, ...]
    """k_D of the curved disc, and of the flat one unless it counts as unworn."""
    correlation: float | None = None
    """Of both k_D."""
    draws: int
    """Number of accepted draws."""
    rejected: int
    """Number of draws without a solution."""
    runs: tuple[TwinDiscVerdict, ...]
    """One verdict for each run."""


class TwinDiscStudyResult(Record):
    """What a study of twin-disc runs found."""

    id: str
    """The study."""
    title: str | None = None
    """One line about it."""
    tribometer: Literal["twin-disc"] = "twin-disc"
    """Type of tribometer."""
    laws: tuple[TwinDiscLawResult, ...]
    """One result for each wear law."""
    left_out: tuple[LeftOut, ...] = ()
    """Runs that were not used, and why."""
    notes: tuple[str, ...] = ()
    """What to beware of."""

    def law(self, model: LawName) -> TwinDiscLawResult:
        """Return the result of one law. Raises ``KeyError`` where the study has none."""
        return {result.model: result for result in self.laws}[model]
