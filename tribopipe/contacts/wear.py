"""Protocols of a contact for predictions and fits: its wear for given wear coefficients.

Each kind answers in a module of its own. Wear is given at effective progress: the progress along the contact's axis
after which Archard's law would have worn as much as the law at hand.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple, Protocol, runtime_checkable

from tribopipe.base.arrays import Column, Values
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import Recipe
from tribopipe.physics.calculation_methods import DistanceConvention
from tribopipe.physics.pin_on_disc import PinContact
from tribopipe.results.input_quantities import Input
from tribopipe.results.wear_fit import HertzStart

State = Mapping[str, Column]
"""Wear and contact at places, SI, by name: those of ``bodies`` and ``displacement``, ``half_width``, ``half_length``,
``pressure``, ``rate``, and of bodies that roll ``slip`` and ``sliding_distance``. The rate is that at which the first
body recedes, m per unit of effective progress; a counterbody is the first one under a pin that does not wear."""


class Steps(NamedTuple):
    """Equal steps of the published scheme from 0 on."""

    ends: Column
    """Progress before the first and after each step."""
    effective: Column
    """Effective progress there."""
    factor: Column
    """Rate factor of the law at this position."""


class ContactWear(Protocol):
    """Wear of the bodies of a contact, from values of ``inputs``' names and of ``coefficients``."""

    @property
    def coefficients(self) -> tuple[str, ...]:
        """Names of k_D among the values, in the order of ``bodies``."""

    @property
    def bodies(self) -> Mapping[str, Mapping[str, str]]:
        """Bodies whose wear is predicted, and the name in a state of each of their ``PredictedBody`` fields."""

    @property
    def displacement(self) -> str:
        """Name of the sum of the depths, as a displacement sensor sees it."""

    @property
    def outcomes(self) -> Mapping[str, str]:
        """Quantities that are shown along a run with their band, and their units."""

    @property
    def uncertain(self) -> tuple[str, ...]:
        """Quantities that are predicted with their uncertainty."""

    @property
    def most_places(self) -> int | None:
        """Number of positions at which wear is computed along a run, linear in between; None for every sample."""

    @property
    def slid(self) -> float:
        """Nominal distance that the unworn bodies slide on each other in one unit of progress, m."""

    @property
    def conditions(self) -> dict[str, Quantity]:
        """Conditions that a prediction may change in addition to the load."""

    def inputs(self, normal_load: Quantity, recipe: Recipe) -> dict[str, Input]:
        """Return load, geometry and moduli with the uncertainties stated, or else the recipe's defaults."""

    def worn(self, values: Values, progress: Column) -> State:
        """Return the contact after an effective progress. Raises ``ContactError`` where a body is worn away."""

    def progress_to(self, values: Values, depth: float) -> Column:
        """Return the effective progress after which the first body has worn to a depth, m; infinite where it never has.

        Raises ``ContactError`` where it is worn away before that.
        """

    def local_amount(self, values: Values, progress: Column) -> Column:
        """Return the amount of wear that local wear counts in after an effective progress (physics.local.surface)."""

    def usual_steps(self, end: float) -> int:
        """Return the number of steps that the published scheme takes up to a place."""

    def published(self, values: Values, steps: Steps, places: Column) -> State:
        """Return the contact at places by the paper's explicit Euler steps."""

    def start(self, values: Values) -> HertzStart | None:
        """Return the contact of the unworn bodies, where the published scheme starts from it."""

    def notes(self, values: Values, last: State | None) -> tuple[str, ...]:
        """Return what the model assumes of the contact, and where the state at its last place leaves it."""


@runtime_checkable
class SensedWear(ContactWear, Protocol):
    """A contact of which the depth signal gives k_D: depth of its first body against lost volume."""

    def pin(self, values: Values) -> PinContact:
        """Return the depth of the first body against worn volume."""


class Row(NamedTuple):
    """Measurement on one body."""

    body: str
    what: str
    """Name of a post-test measurement without that of the body: "wear_depth"."""
    place: int
    """Which place of a state it was measured at."""


class Noticed(NamedTuple):
    """Least wear of a body that explains its measurement, or would have been detected."""

    what: str
    value: float
    """SI."""
    progress: float
    """Effective progress it was measured at."""


@runtime_checkable
class MeasuredWear(ContactWear, Protocol):
    """A contact whose k_D is found by what was measured on the bodies, rather than by the depth signal."""

    @property
    def least(self) -> Mapping[str, float]:
        """Standard uncertainty, SI, below which nothing is measured, by what is measured."""

    def measured(self, state: State, rows: Sequence[Row]) -> Column:
        """Return what each measurement would find, SI: (..., rows)."""

    def slopes(self, values: Values, state: State, progress: Column, rows: Sequence[Row]) -> Column:
        """Return about how each measurement moves with ln k_D of each body, SI: (..., rows, bodies)."""

    def guess(self, values: Values, last: Mapping[str, Noticed]) -> Column:
        """Return k_D of about the right size, m²/N, from what was last measured on each body."""

    def equivalents(
        self, values: Values, progress: Column, coefficients: Column
    ) -> Mapping[DistanceConvention, tuple[float, ...]]:
        """Return k_D of each body that other ways of counting the distance need to reach the same wear, m²/N."""


class Reached(NamedTuple):
    """The contact where something of it has grown by so much."""

    state: State
    """What ``slopes`` and ``measured`` take of it."""
    progress: Column
    """Effective progress at which it has."""
    slope: Column
    """d ln(growth)/d ln(progress)."""


class Course(Protocol):
    """What bodies go through, by the growth of something that wear makes larger."""

    def growth(self, progress: Column, *coefficients: Column) -> Column:
        """Return the growth at an effective progress, for k_D of each body, m²/N.

        Raises ``ContactError`` where a body is worn away.
        """

    def at(self, growth: Column, *coefficients: Column) -> Reached:
        """Return the contact at a growth, to nine digits; no number, or no true one, beyond where wear ends."""


@runtime_checkable
class ExplicitWear(MeasuredWear, Protocol):
    """A contact whose state and progress are explicit in some growth, which is faster for thousands of draws."""

    def course(self, values: Values) -> Course:
        """Return the course of wear for values of the inputs. Raises ``ContactError`` where the bodies do not touch."""
