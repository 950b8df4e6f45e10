"""What a prediction asks of a contact: each kind answers in a module of its own, and the rest is written once."""

from collections.abc import Callable, Iterator
from typing import Protocol, TypeVar

from tribopipe.base.arrays import Column
from tribopipe.base.errors import FitError
from tribopipe.documents.contact import SlidingPin, TwinDisc
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import LawName, Recipe
from tribopipe.evaluation.wear.inputs import Input
from tribopipe.evaluation.wear.known import KnownWear
from tribopipe.physics.laws import WearLaw
from tribopipe.results.run import RawRun
from tribopipe.results.wear_curves import Band
from tribopipe.results.wear_fit import HertzStart, WearFit
from tribopipe.results.wear_prediction import PredictedPoint

State = TypeVar("State")
"""What a kind of contact knows of its wear, one value of each quantity for each place."""


class Scenario(Protocol[State]):
    """What wear is predicted for: bodies, load, law and k_D. Places are counted along the contact's progress."""

    @property
    def contact(self) -> SlidingPin | TwinDisc:
        """The bodies."""

    @property
    def normal_load(self) -> Quantity:
        """F_N, N."""

    @property
    def model(self) -> LawName:
        """Name of the wear law."""

    @property
    def recipe(self) -> Recipe:
        """Where default uncertainties and given parameters of the law are from."""

    @property
    def known(self) -> KnownWear:
        """k_D of each body."""

    @property
    def law(self) -> WearLaw:
        """The wear law with its parameters."""

    @property
    def inputs(self) -> dict[str, Input]:
        """Everything uncertain that wear depends on, k_D among it."""

    @property
    def speed(self) -> Quantity | None:
        """Speed by which places follow from time, m/s; none where it is not known."""

    @property
    def conditions(self) -> dict[str, Quantity]:
        """What else is predicted for and may be another than the run's own."""

    @property
    def start(self) -> HertzStart | None:
        """Contact of the unworn bodies, where the published scheme starts from it."""

    @property
    def rolling(self) -> bool:
        """Whether k_D means something under one way of counting the distance slid in a rotation only."""

    def state(self, places: Column) -> State:
        """Return wear at places, in the limit of small steps. Raises ``ContactError`` where a body is worn away."""

    def usual_steps(self, end: float, /) -> int:
        """Return the number of steps of the published scheme up to a place."""

    def published(self, places: Column, steps: int) -> State:
        """Return wear at places by the paper's explicit Euler scheme in so many equal steps."""

    def first_depth(self, state: State) -> Column:
        """Return the wear depth of the first body, m."""

    def points(self, places: Column, state: State) -> Iterator[PredictedPoint]:
        """Yield wear and contact at each place with their uncertainties, without time."""

    def place_at(self, depth: float) -> float:
        """Return where the first body has worn to a depth, m; infinite where it does not wear."""

    def rate(self, places: Column) -> Column:
        """Return how fast the first body recedes, m over the unit of the progress."""

    def validity_notes(self, places: Column, /) -> tuple[str, ...]:
        """Say where the contact leaves what the model describes."""

    def bands(self, run: RawRun) -> dict[str, Band]:
        """Return wear along the run it is predicted for, with bands of all inputs."""

    def fitted_bands(self, run: RawRun, fit: WearFit, /) -> dict[str, Band]:
        """Return wear along the run that k_D was fitted to, with bands of what was fitted."""


def beyond(excess: Callable[[float], float], start: float) -> float:
    """Return a place at or after the start where an excess, which grows, is not below zero.

    Raises ``FitError`` where there is none within a billion times the start.
    """
    for doublings in range(30):
        if excess(place := start * 2.0**doublings) >= 0:
            return place
    raise FitError(
        "wear law: found that it wears less and less and never so deep; expected a depth that it reaches; ask for less"
    )
