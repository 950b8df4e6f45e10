"""Results of a fit of a wear law: k_D of each body of a contact, and its contributions."""

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Literal

from pydantic import Field

from tribopipe.base.errors import FitError
from tribopipe.base.units import WEAR_COEFFICIENT
from tribopipe.documents.contact_kinds import spoken
from tribopipe.documents.quantity import (
    Metres,
    Pascals,
    Quantity,
    SquareMetresPerNewton,
    between,
    in_both_units,
)
from tribopipe.documents.recipe import Correction, FrictionSource, LawName
from tribopipe.documents.record import Record
from tribopipe.physics.calculation_methods import DistanceConvention, WearEngine
from tribopipe.results.evaluation import DepthModel
from tribopipe.results.finding import Finding
from tribopipe.results.interactive import FitRecord, views

if TYPE_CHECKING:
    from pandas import DataFrame, Series


NO_FRICTION = "a friction signal"
"""Missing input of a law that needs friction."""
FRICTION_FIT = "friction fit"
"""The line of a budget that stands for A, b and c of Eq. 7, which are fitted together."""


class Contribution(Record):
    """One line of an uncertainty budget (JCGM 100:2008, 5.1.2)."""

    name: str
    """Input quantity."""
    value: Quantity | None = None
    """Value and standard uncertainty; None for the noise of the depth signal."""
    shown_in: str | None = None
    """Unit in which people read it."""
    source: Literal["manifest", "default", "fit", "recipe"]
    """Source of the uncertainty: the lab in run.toml or a recipe, the recipe's default, or the data themselves."""
    relative: float
    """Standard uncertainty of k_D from this input alone, over k_D, with its sign."""

    @property
    def distribution(self) -> str:
        """The distribution that the Monte Carlo draws this input from."""
        return "joint normal, c log-normal" if self.name == FRICTION_FIT else "normal"

    @property
    def sensitivity(self) -> float | None:
        """Relative change of k_D over that of the input, (∂k_D/k_D)/(∂x/x); None if the input has no size."""
        if self.value is None or not self.value.value or not self.value.standard_uncertainty:
            return None
        return self.relative * self.value.value / self.value.standard_uncertainty


class MonteCarlo(Record):
    """Propagation of distributions (JCGM 101:2008)."""

    draws: int
    """Number of draws."""
    mean: SquareMetresPerNewton
    """Mean of the draws."""
    standard_uncertainty: SquareMetresPerNewton
    """Standard deviation of the draws."""
    stable: bool
    """Whether the required digits were stable at the last draw (7.9.4)."""
    first_order_interval: tuple[SquareMetresPerNewton, SquareMetresPerNewton]
    """95 % interval of JCGM 100:2008, log-normal."""
    agrees_with_first_order: bool
    """Whether both ends agree with it within those digits (8.1)."""


Basis = Literal["reading and measurement", "measurement", "reading"]
"""Data from which a wear coefficient is determined."""


class LawValue(Record):
    """A parameter of a wear law in addition to k_D."""

    name: str
    """Parameter."""
    value: Quantity
    """Value; without uncertainty if it was fixed in the fit."""
    source: Literal["fit", "recipe"]
    """Whether it was fitted with k_D, or given."""

    def __str__(self) -> str:
        return f"{self.name.replace('_', ' ')} {self.value}"


class BodyWear(Record):
    """k_D of one body of a contact, and what it is made of."""

    wear_coefficient: SquareMetresPerNewton
    """k_D with its combined standard uncertainty."""
    interval: tuple[SquareMetresPerNewton, SquareMetresPerNewton]
    """95 % coverage interval of k_D from the Monte Carlo method, or from first-order propagation if there is none."""
    random_uncertainty: SquareMetresPerNewton | None = None
    """Standard uncertainty from the noise of the depth signal alone; None if no depth signal was fitted."""
    budget: tuple[Contribution, ...] = ()
    """Contributions to the combined standard uncertainty, by first-order propagation."""
    monte_carlo: MonteCarlo | None = None
    """Method of the interval."""
    by_reading: SquareMetresPerNewton | None = None
    """k_D by the depth reading alone."""
    by_measurement: SquareMetresPerNewton | None = None
    """k_D by the post-test measurement alone."""
    measured_end_depth: Metres | None = None
    """Wear depth of the body by the post-test measurement."""
    fitted_end_depth: Metres | None = None
    """Wear depth of the body at the end by the fitted law."""

    def __str__(self) -> str:
        return f"k_D = {in_both_units(self.wear_coefficient)}, 95 % CI: {between(self.interval, WEAR_COEFFICIENT)}"


class HertzStart(Record):
    """Contact of the unworn bodies by Hertz."""

    half_width: Metres
    """a_x."""
    half_length: Metres
    """a_z."""
    peak_pressure: Pascals
    """p₀, 1.5 times the mean pressure."""


class FittedValue(Record):
    """One post-test measurement, or one at an interruption, with what the fitted law gives for it."""

    name: str
    """Measured quantity, body, and time of the measurement."""
    place: float
    """Position in the test: sliding distance, m, or rotations."""
    measured: Quantity
    """As measured."""
    fitted: Quantity
    """Fitted value."""


class ConventionCoefficients(Record):
    """k_D by which another way of counting the sliding distance would reach the same end."""

    distance_per_rotation: DistanceConvention
    """The other way."""
    bodies: dict[str, Quantity]
    """k_D of each body that was fitted."""


class WearFit(FitRecord):
    """Dimensional wear coefficients of one run under a wear law, found together."""

    model: LawName
    """Wear law."""
    engine: WearEngine = "giwm"
    """Pressure that k_D was found by: even, as the Global Incremental Wear Model has it, or local."""
    outcome: Literal["fitted", "not fitted"]
    """Not fitted if an input of the fit is missing."""
    missing: tuple[str, ...] = ()
    """Missing inputs of the fit."""
    notes: tuple[str, ...] = ()
    """Notes and warnings, including the defaults used."""
    findings: tuple[Finding, ...] = ()
    """Findings against the result."""
    distance_per_rotation: DistanceConvention | None = None
    """Convention for the sliding distance in one rotation; None for bodies that do not roll."""
    bodies: dict[str, BodyWear] = Field(default_factory=dict)
    """k_D of each body, first the one that is always fitted; other bodies count as unworn."""
    correlation: float | None = None
    """Correlation of both k_D."""
    parameters: tuple[LawValue, ...] | None = None
    """Parameters of the law in addition to k_D; None if it has none."""
    parameter_covariance: tuple[tuple[float, ...], ...] | None = None
    """Covariance of ln k_D and the fitted parameters, in SI, by first-order propagation."""
    friction: FrictionSource | None = None
    """Which μ a law that includes friction was given."""
    correction: Correction | None = None
    """Method for drift: with k_D in one model, or before it; None if no depth signal was fitted."""
    basis: Basis | None = None
    """Source of k_D: depth signal and post-test measurement together, or one of them; not with two-step correction."""
    deviation: float | None = None
    """Wear at the end by the reading alone minus that by the measurement alone, over its standard uncertainty."""
    sensor: DepthModel | None = None
    """Contributions to the depth signal other than wear, under this law."""
    residual_deviation: Metres | None = None
    """Standard deviation of the corrected wear about the fit; of block averages, except with two-step correction."""
    effective_samples: float | None = None
    """Number of independent samples the residuals amount to."""
    start: HertzStart | None = None
    """Contact of the unworn bodies by Hertz, where the fit starts from it."""
    measurements: tuple[FittedValue, ...] = ()
    """Each measurement that was fitted; the depth signal is not among them."""
    p_value: float | None = None
    """Probability of as much disagreement under the law (χ²); None if there are no more values than unknowns."""
    equivalents: tuple[ConventionCoefficients, ...] = ()
    """The other ways of counting, so that k_D can be compared."""

    @property
    def first(self) -> BodyWear | None:
        """The body whose k_D every fit finds; None if nothing was fitted."""
        return next(iter(self.bodies.values()), None)

    @property
    def k_d(self) -> Quantity:
        """k_D of the one body that was fitted, m²/N.

        Raises ``FitError`` where nothing was fitted, or k_D of two bodies: ``bodies`` then has each by its name.
        """
        if len(self.bodies) == 1:
            return next(iter(self.bodies.values())).wear_coefficient
        if not self.bodies:
            raise FitError(f"{self}; expected a run with these inputs; add them to run.toml, and ingest the run again")
        names = ", ".join(f"fit.bodies[{name!r}].wear_coefficient" for name in self.bodies)
        raise FitError(
            f"{self.model}: found k_D for {len(self.bodies)} bodies; expected k_D for a single body; use {names}"
        )

    @property
    def params(self) -> dict[str, Quantity]:
        """What was fitted or given: ``k_d``, or ``k_d_`` and the name of each of two bodies; then the law's own."""
        one = len(self.bodies) == 1
        found = {"k_d" if one else f"k_d_{name}": body.wear_coefficient for name, body in self.bodies.items()}
        return found | {known.name: known.value for known in self.parameters or ()}

    def frame(self) -> "DataFrame":
        """Return the law along its run as a table of pandas, measured and fitted.

        Returns
        -------
        pandas.DataFrame
            What wear grows along, each fitted quantity with the ends of its 95 % band (``wear_depth_lower``), and for a
            pin the measured wear and the residual; SI, with units in ``frame.attrs["units"]``.
        """
        table: DataFrame = views().fit_frame(self)
        return table

    @property
    def residual(self) -> "Series[float]":
        """Measured minus fitted wear of a pin at each sample, m. Raises ``UnknownNameError`` where none is known."""
        residual: Series[float] = views().residual(self)
        return residual

    def __str__(self) -> str:
        counted = "" if self.distance_per_rotation is None else f", {self.distance_per_rotation}"
        head = f"{self.model}{by(self.engine)}{counted}"
        if not self.bodies:
            return f"{head}: no wear coefficient: missing {' and '.join(self.missing)}"
        each = (
            f"{spoken(name)} {body}{_parameters(self.parameters)}{_depths(body)}" for name, body in self.bodies.items()
        )
        return f"{head}: {'; '.join(each)}"


def fits_of(results: Iterable[object]) -> Iterator[WearFit]:
    """Give the fits among the results of a run, in their order, those under laws that are not installed among them."""
    yield from (result for result in results if isinstance(result, WearFit))


def by(engine: WearEngine) -> str:
    """Give the engine that a k_D was found by, after its law; nothing of the GIWM."""
    return {"giwm": "", "volume": ", from the wear volume", "local": ", local contact pressure"}[engine]


def _parameters(parameters: tuple[LawValue, ...] | None) -> str:
    """Give the parameters of a law after its k_D; nothing where it has none."""
    return f", {', '.join(map(str, parameters))}" if parameters else ""


def _depths(body: BodyWear) -> str:
    """Give the wear depth at the end, fitted and measured; nothing where no depth was fitted."""
    if body.fitted_end_depth is None:
        return ""
    measured = "not" if body.measured_end_depth is None else body.measured_end_depth.shown("um")
    return f", final wear depth {body.fitted_end_depth.shown('um')} fitted, {measured} measured"
